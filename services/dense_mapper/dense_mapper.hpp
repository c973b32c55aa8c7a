// Dense mapping (Yu et al. 2025, section 2.2, threads 4 to 6): keyframe depth -> filtered cloud ->
// OctoMap submaps by ray casting -> global cloud, OctoMap and raster. Submaps hang on keyframes of
// the pose graph: when the graph moves them, the global map is composed again and no image is
// integrated twice. The order in which keyframes and poses arrive does not matter. For a camera
// carried by hand it also finds out how the map has to move to be level, and asks the graph for it.
// Not thread-safe.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/camera/rgbd_frame.hpp"
#include "libs/grid/tiled_grid.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/submaps/changed_tiles.hpp"
#include "services/dense_mapper/base_map.hpp"
#include "services/dense_mapper/config.hpp"
#include "services/dense_mapper/dense_submap.hpp"
#include "services/dense_mapper/depth_cloud.hpp"
#include "services/dense_mapper/level.hpp"
#include "services/dense_mapper/mounting.hpp"
#include "services/dense_mapper/raster.hpp"
#include "services/dense_mapper/saved_map.hpp"

namespace fusion_slam {

struct DenseTiles {  // all in the map frame
  std::vector<Tile> octomap;
  std::vector<Tile> cloud;
  std::vector<Tile> grid;  // none until the map is level
};

class DenseMapper {
 public:
  DenseMapper(const CameraModel& camera, const RobotModel& robot, const DenseMapperConfig& config);

  // The graph begins with this keyframe, and so does the first submap (after a reset ids count on);
  // before set_pose(). 1 unless said; older keyframes are never mapped.
  void begin_at(std::int64_t id);
  // Id 1, 2, 3 ... False: the image does not fit the camera model, or this id came before; ignored.
  bool add_keyframe(std::int64_t id, const RgbdFrame& frame);
  // Where the graph has a keyframe's base now; utime_us: of the graph's newest measurement.
  void set_pose(std::int64_t id, const SE3& T_map_base, std::int64_t utime_us);
  // Integrates what waits for poses. To be called after each batch of add_keyframe and set_pose.
  void integrate_ready();

  // True when there is something to publish: a keyframe, anchors that moved by more than the slack
  // (followed each moved_period_us), or the level the grid waited for.
  bool due() const;
  // To be called before each update(). A wish is to be passed on to the pose graph; until
  // set_pose() shows that it has come true, or the next estimate finds the map level, update()
  // composes no grid. Never for a planar robot, whose map is level. `exact`: for the final map.
  std::optional<LevelWish> wish_level(bool exact);
  // place -> compose -> the tiles that changed, revisions set. The raster follows each keyframe;
  // OctoMap and cloud follow when a submap is full or has moved. `exact`: everything now, and
  // submaps placed without slack; for the final map.
  DenseTiles update(bool exact);
  // The same in two steps, so that the raster need not wait for the rest: octomap and cloud of the
  // result of update_grid() are empty, grid of that of update_maps().
  DenseTiles update_grid(bool exact);
  DenseTiles update_maps();

  // --- for a process that is killed and started again (saving.cpp)
  // Goes on where an earlier one ended, by what its records made: before anything else. The images
  // of map.open_keyframes are to be added again; poses come from the graph. All is due to be
  // published. False: the map is of another resolution; nothing has happened.
  bool restore(SavedMap map);
  // From now on changes are remembered for take_changes().
  void keep_changes() { keeps_changes_ = true; }
  // A record of what has changed since the last call; nothing when nothing has.
  SavedBytes take_changes();
  // All, as records of about 1 MB. What has changed so far is in them.
  void write_all(const std::function<void(const SavedBytes&)>& emit);
  // It is mapped or waits to be: its image is not needed any more.
  bool has(std::int64_t id) const { return waiting_.count(id) != 0 || integrated_.contains(id); }
  // Nothing keeps it from being mapped at once.
  bool ready(std::int64_t id) const;

  // --- for a process that can't keep up (pace.hpp); never in a replay
  // False: anchors that move are not followed until this is called again, or for the final map.
  void follow_moves(bool follow) { follows_moves_ = follow; }
  // Where submaps moved, each update_grid() composes at most so many cubes of the map again; the
  // rest stays as it was until the next. Moves that come meanwhile are followed after these.
  void follow_at_most(std::size_t cubes) { cubes_a_step_ = cubes; }
  // How many cubes that has been so far.
  std::size_t cubes_followed() const { return cubes_followed_; }
  // A submap would begin with this keyframe, where the base of a closed one, looking the same way,
  // lies close by.
  bool repeats_a_place(std::int64_t id) const;
  // Not mapped, nor are the other keyframes of a submap that begins with it. Counts as mapped.
  void leave_out(std::int64_t id);
  // Of a submap that was left out, or forgotten since.
  bool belongs_to_left_out(std::int64_t id) const;
  // Keyframes whose images a restart would need: of open submaps, and those that wait.
  std::set<std::int64_t> needed_images() const;
  // While an earlier process's images are mapped again without records of it: full submaps are
  // packed although nothing is published.
  void pack_full() { maps_due_ |= close_full_submaps(); }

  bool level() const { return levelled_ && !wish_; }  // z is up, z = 0 the floor, as far as known
  bool floor_seen() const { return robot_.planar || floor_seen_; }
  std::size_t waiting() const { return waiting_.size(); }
  std::size_t integrated() const { return integrated_.size(); }
  std::int64_t dropped() const { return dropped_; }  // waited too long, see max_waiting
  const SE3& mounting_correction() const { return mounting_.correction(); }
  // What is kept packed for ever: submaps, and the map composed of them.
  std::size_t submaps() const { return submaps_.size(); }
  std::size_t submap_bytes() const;
  std::size_t map_bytes() const { return base_.size_bytes(); }

 private:
  using Columns = std::set<ColumnIndex>;
  std::int64_t submap_of(std::int64_t keyframe_id) const;
  SE3 pose_of(std::int64_t keyframe_id) const;  // T_map_base, on the floor when the robot is
  SE3 placement(std::int64_t id, const DenseSubmap& submap) const;
  SE3 pose_or_place(std::int64_t id, const DenseSubmap& submap) const;
  bool needs_placing(std::int64_t id, const DenseSubmap& submap, double slack_m) const;
  bool anything_moved(double slack_m) const;
  void integrate(std::int64_t keyframe_id, std::int64_t submap_id, const DepthCloud& cloud);
  DenseSubmap& submap_for(std::int64_t submap_id);
  void integrate_late(const DepthCloud& cloud, const SE3& T_submap_camera, std::int64_t submap_id,
                      DenseSubmap* submap);
  bool place_submaps(double slack_m);
  void follow_in_base(bool all);
  bool close_full_submaps();
  void extend_base();
  void supersede(std::int64_t id);
  bool holds_too_much() const;
  void forget_submap(std::int64_t id);
  void check_wish();
  void found_level();
  void mark_all(std::int64_t id, const DenseSubmap& submap);
  void mark(const std::set<CubeIndex>& cubes);

  // publish.cpp
  using Composed = std::map<CubeIndex, VoxelCells>;
  Composed compose(const std::set<CubeIndex>& cubes, const SliceRange& slices);
  void publish_grid(std::vector<Tile>* out);
  void publish_octomap(const Composed& composed, std::vector<Tile>* out);
  void publish_clouds(const Composed& composed, std::vector<Tile>* out);
  Band band() const;

  // saving.cpp
  SavedValues saved_values() const;
  void changed_submap(std::int64_t id);
  void placed_submap(std::int64_t id);
  void note_dirty_base(SavedMapWriter* out);

  CameraModel camera_;
  RobotModel robot_;
  DenseMapperConfig config_;
  std::int64_t first_id_ = 1;                   // of the graph's keyframes
  std::map<std::int64_t, SE3> T_map_base_;      // of keyframes, by the graph
  std::map<std::int64_t, DepthCloud> waiting_;  // for a pose
  IdRanges integrated_;
  std::map<std::int64_t, SavedKeyframe> open_keyframes_;  // of open submaps
  std::set<std::int64_t> to_repeat_;  // of them, those whose images an earlier process had mapped
  DenseSubmaps submaps_;
  Mounting mounting_;
  BaseMap base_;  // of the closed submaps with id < base_upto_
  std::int64_t base_upto_ = 0;
  bool levelled_ = false;          // once, at least
  std::optional<LevelWish> wish_;  // that hasn't come true yet
  bool floor_seen_ = false;
  bool grid_is_late_ = false;         // the level came, the grid hasn't been composed since
  std::size_t level_keyframes_ = 0;   // behind the latest estimate
  int fresh_keyframes_ = 0;           // since the last update()
  bool maps_due_ = false;             // OctoMap and cloud, too
  bool finishing_ = false;            // the last update_grid() was exact: nothing stays open
  std::set<CubeIndex> dirty_cubes_;   // OctoMap and cloud to be composed again
  std::set<CubeIndex> dirty_base_;    // a submap moved there: the base is to be composed again
  std::set<CubeIndex> dirty_points_;  // of these the base's voxels have followed already
  Columns dirty_columns_;             // raster
  ColumnRasters columns_;             // the band of the map, seen from above
  TiledGrid grid_;                    // as published
  ChangedTiles octomap_tiles_;
  ChangedTiles cloud_tiles_;
  ChangedTiles grid_tiles_;
  std::int64_t newest_us_ = 0;  // image in the map
  std::int64_t graph_us_ = 0;   // graph
  std::int64_t placed_us_ = 0;  // graph when submaps were last placed
  std::int64_t dropped_ = 0;

  bool follows_moves_ = true;
  std::size_t cubes_a_step_ = std::numeric_limits<std::size_t>::max();
  std::size_t cubes_followed_ = 0;
  bool part_followed_ = false;  // some of dirty_base_ is left for the next step

  bool keeps_changes_ = false;
  bool dirty_base_noted_ = false;  // the latest record has some
  struct Changes {
    bool values = false;
    std::map<std::int64_t, SavedKeyframe> keyframes;
    std::set<std::int64_t> whole;     // submaps: closed, or dropped from
    std::set<std::int64_t> placed;    // submaps: the rest
    std::set<std::int64_t> left_out;  // keyframes
  } changes_;
};

}  // namespace fusion_slam
