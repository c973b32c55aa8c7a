// One graph for both sensors. Keyframes and LiDAR nodes come in with an edge to the one before;
// keyframes are tied to the LiDAR's trajectory by time; loops close it. Out come the nodes' places
// in the map and the robot's pose at sensor rate. Knows no bus. Not thread-safe. Nothing depends on
// the order in which inputs of the same utime arrive: what refers to a node that hasn't come yet
// waits for it. The thread that solves the whole graph anew is met at a fixed measurement time
// after it was started, so that the answer comes at the same place in every replay.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "libs/graph/uncertainty.hpp"
#include "libs/journal/note_bytes.hpp"
#include "libs/robot/robot_model.hpp"
#include "services/pose_graph/config.hpp"
#include "services/pose_graph/global_bundle.hpp"
#include "services/pose_graph/global_solve.hpp"
#include "services/pose_graph/graph_inputs.hpp"
#include "services/pose_graph/graph_solver.hpp"
#include "services/pose_graph/graph_types.hpp"
#include "services/pose_graph/pose_track.hpp"
#include "services/pose_graph/thinning.hpp"

namespace fusion_slam {

struct PoseGraphCounts {
  std::int64_t solves = 0;
  std::int64_t loops = 0;
  std::int64_t loops_outvoted = 0;
  std::int64_t loops_switched_off = 0;
  std::int64_t ties = 0;
  std::int64_t edges_doubted = 0;  // of the camera, for the LiDAR contradicts them
  std::int64_t bundles = 0;        // global bundle adjustments taken over
  std::int64_t bundles_refused = 0;
  std::int64_t restarts = 0;  // tracks that started anew and were hung on the last known pose
  std::int64_t levellings = 0;
  std::int64_t retired = 0;   // nodes carried by others
  std::int64_t rejected = 0;  // duplicate ids, edges from a node to itself, impossible levellings
};

// Of an interpolated pose: the tracker's own, and how far the path may have bent between its two
// poses.
Matrix6d interpolated_covariance(const PoseGraphConfig& config, const TrackAnswer& answer);

class PoseGraph {
 public:
  explicit PoseGraph(PoseGraphConfig config = {});

  void set_robot(const RobotModel& robot);
  void set_camera(const CameraModel& camera);  // without it: no bundle adjustment
  void add_node(const NodeInput& node);
  void add_pose(const PoseInput& pose);
  void add_odometry(std::int64_t utime_us, const SE3& T_odom_base);
  void add_loop(const LoopInput& loop);
  // The robot's clock was set back: from now on it is utime_us again. What the sensors said of the
  // times that come again is not compared with what they will say; nodes stay where they are.
  void clock_was_set_back(std::int64_t utime_us);
  // Moves the whole map, once and at once, so that this node's z, roll and pitch become those of
  // T_level_id: the smallest rotation about the map's origin, then a shift along z (levelling() in
  // libs/geometry). Poses between nodes stay as they are. False, with a reason, for planar robots
  // and unknown nodes.
  bool level_map(const NodeId& id, const SE3& T_level_id, std::string* why);
  // An earlier process's graph is built again from its inputs: until rebuilt() nodes are put where
  // it had them last, and nothing is solved (live, a graph is solved as often as nodes come: that
  // would take as long again).
  struct Earlier {
    std::map<NodeId, SE3> T_map_base;                         // as GRAPH said last
    std::map<std::int64_t, std::vector<Retirement>> retired;  // by take_retirements()' number
    std::vector<LoopState> switched_off;                      // as GRAPH said last
  };
  void rebuild(Earlier earlier);
  void rebuilt();
  // All that it knows, for the journal, but for the models; what has not been taken (changes,
  // poses, retirements) is not in it. restore() is the other way, before rebuild(), which then
  // tells what became of it since. False: `in` is damaged or of another version, and the graph is
  // empty.
  void write(NoteWriter* out) const;
  bool restore(NoteReader* in);
  void start_anew();  // forgets all but the robot and the camera
  void finish();      // the input has ended: place and say what still waits, then solve

  // Nodes that are new or moved (more than 1 mm or 0.1 mrad; what others carry 3 mm or 0.5 mrad)
  // since the last call; grows the revision when there are any. After level_map(): all of them.
  std::vector<std::pair<NodeId, GraphNode>> take_changes();
  std::vector<PoseOutput> take_poses();
  // Nodes that left the graph since the last call: what rebuild() needs to do it again, each with
  // the number of nodes that had come until then.
  std::vector<std::pair<std::int64_t, Retirement>> take_retirements();
  // At most so many nodes behind this one in the order of their ids, those that are carried by
  // others included (T_odom_base is not kept of them). Behind NodeId{}: the first.
  std::vector<std::pair<NodeId, GraphNode>> nodes_after(const NodeId& id, std::size_t most) const;
  std::size_t n_nodes() const { return nodes_.size() + retired_.size(); }

  std::int64_t revision() const { return revision_; }
  std::int64_t newest_utime_us() const { return newest_utime_us_; }
  const GraphNodes& nodes() const { return nodes_; }  // those that are unknowns
  const std::vector<GraphEdge>& edges() const { return edges_; }
  const PoseGraphCounts& counts() const { return counts_; }
  const BundleReport& last_bundle() const { return last_bundle_; }
  // Loops that are not believed any more, oldest first.
  const std::vector<LoopState>& switched_off() const { return switched_off_; }

 private:
  struct Hang {  // where a track that starts anew is put
    GraphEdge edge;
    bool counts_as_restart = false;
  };

  struct Retired {  // small: there is one for each node that ever was
    std::int64_t utime_us = 0;
    NodeId carrier;
    Eigen::Vector3d t_carrier_base_m;
    Eigen::Quaterniond q_carrier_base;
    float translation_m2 = 0.0F;  // an upper bound of the variance, any direction
    float rotation_rad2 = 0.0F;
    SE3 T_carrier_base() const;
    Matrix6d covariance() const;  // of it, in the node's axes
  };
  struct Load {  // of a carrier
    SE3 T_said;  // where it was when those it carries were last handed out
    std::vector<NodeId> ids;
  };

  void write_nodes(NoteWriter* out) const;
  void write_retired(NoteWriter* out) const;
  bool read(NoteReader* in);
  bool read_nodes(NoteReader* in);
  bool read_retired(NoteReader* in);
  void switch_off_as_before();
  void settle();
  void thin();
  void thin_as_before();
  void retire(const NodeId& id, const NodeId& carrier, const SE3& T_carrier_base,
              Thinning* thinning);
  void hand_over_load(const NodeId& id);
  void renumber(const std::vector<std::ptrdiff_t>& number);
  void add_edge(GraphEdge edge);
  SE3 T_map(const NodeId& id) const;
  bool place_nodes();
  bool place(const NodeInput& node);
  void put(const NodeInput& node, const SE3& T_map_base);
  void refine_edges(const NodeInput& node);
  std::optional<Hang> hang(const NodeInput& node) const;
  std::optional<Hang> hang_on_other_sensor(const NodeInput& node) const;
  Hang hang_on_last_known(const NodeInput& node) const;
  bool may_still_come(NodeKind sensor, std::int64_t utime_us) const;
  bool tie_keyframes();
  void doubt_visual_edge(const NodeId& keyframe);
  bool judge_found_again(const NodeInput& node, GraphEdge* edge, SE3* T_map_base);
  std::optional<Matrix6d> covariance_between(const NodeId& a, const NodeId& b) const;
  std::int64_t utime_us(const NodeId& id) const;
  bool take_loops();
  bool was_switched_off(const LoopInput& loop);
  void refine_window();
  void solve(const std::set<NodeId>& moving);
  SolveOptions quick_options(const std::set<NodeId>& moving) const;
  void solve_quickly();
  void start_quick_solve();
  void meet_quick_solve();
  bool bundle_is_due() const;
  std::shared_ptr<const BundleQuestion> bundle_question();
  void start_global_solve(bool with_bundle);
  void meet_global_solve(bool now);
  void move_to(const GraphNodes& solved);
  void adopt(const GlobalSolve& answer);
  void judge_loops();
  GraphUncertainty uncertainty() const;
  Matrix6d map_covariance(const NodeId& id) const;
  void say_poses();
  PoseOutput said(const PoseInput& pose) const;
  std::optional<PoseOutput> bridged(const PoseInput& pose) const;

  PoseTrack& track(NodeKind sensor) { return sensor == NodeKind::kLidar ? lidar_ : visual_; }
  const PoseTrack& track(NodeKind sensor) const {
    return sensor == NodeKind::kLidar ? lidar_ : visual_;
  }
  bool known(const NodeId& id) const { return nodes_.count(id) > 0 || retired_.count(id) > 0; }

  PoseGraphConfig config_;
  std::optional<RobotModel> robot_;
  std::optional<CameraModel> camera_;
  GraphNodes nodes_;
  std::vector<GraphEdge> edges_;
  std::set<std::pair<std::int64_t, NodeId>> by_time_;
  PoseTrack visual_;
  PoseTrack lidar_;
  PoseTrack odometry_;

  std::map<std::pair<std::int64_t, NodeId>, NodeInput> waiting_nodes_;
  std::set<std::pair<std::int64_t, NodeId>> waiting_ties_;
  std::vector<LoopInput> waiting_loops_;
  std::deque<PoseInput> waiting_poses_;
  bool finishing_ = false;
  bool rebuilding_ = false;
  std::map<NodeId, SE3> earlier_;  // where rebuild() puts nodes
  std::map<std::int64_t, std::vector<Retirement>> earlier_retired_;
  std::vector<LoopState> earlier_off_;

  std::int64_t newest_utime_us_ = 0;
  std::int64_t revision_ = 0;
  std::map<NodeId, Retired> retired_;
  std::map<NodeId, Load> loads_;  // by carrier
  std::vector<std::pair<std::int64_t, Retirement>> retirements_;
  std::int64_t n_placed_ = 0;
  std::int64_t next_thinning_ = 0;
  GraphNodes taken_;  // as last handed out
  std::set<NodeId> changed_;
  std::vector<PoseOutput> poses_;
  std::optional<PoseOutput> last_pose_;
  mutable std::map<NodeId, Matrix6d> map_covariance_;  // of nodes asked for since the last solve
  std::vector<LoopState> switched_off_;
  int unsolved_loops_ = 0;              // taken since the last solve of the whole graph
  std::map<std::size_t, int> doubted_;  // edge: whole solves in a row that it did not fit
  std::unique_ptr<BackgroundSolve> background_;
  std::int64_t rest_until_us_ = 0;        // live: of measurements; no whole solve begins before
  bool solve_wanted_ = false;             // meanwhile
  std::int64_t quick_rest_until_us_ = 0;  // live: of measurements; as for solve_quickly()
  bool quick_wanted_ = false;
  std::int64_t quick_took_us_ = 0;  // live: the last one
  std::unique_ptr<BackgroundSolve> quick_;
  LandmarkStore seen_;
  std::map<std::pair<NodeId, NodeId>, std::vector<std::pair<int, int>>> same_points_;  // by loop
  std::size_t bundled_keyframes_ = 0;  // at the last bundle adjustment
  int new_visual_loops_ = 0;           // since then
  BundleReport last_bundle_;
  PoseGraphCounts counts_;
};

}  // namespace fusion_slam
