// SessionCollector::write(): one file after the other.
#include <sstream>
#include <stdexcept>
#include <utility>

#include "libs/evaluation/tum_file.hpp"
#include "libs/maps/atomic_file.hpp"
#include "libs/maps/map_picture.hpp"
#include "libs/maps/octomap_file.hpp"
#include "libs/maps/ply_file.hpp"
#include "libs/maps/ros_map.hpp"
#include "libs/session/session_collector.hpp"

namespace fusion_slam {
namespace {

// Collects what was written and what was not.
class Output {
 public:
  Output(const std::filesystem::path& directory, SessionResult* result)
      : directory_(directory), result_(result) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error)
      throw std::runtime_error(directory.string() + ": can't be made: " + error.message() +
                               "; choose another directory");
  }

  void write(const std::string& name, const std::string& bytes) {
    write_file_atomically(directory_ / name, bytes);
    result_->files.push_back(name);
  }
  void leave_out(const std::string& name, const std::string& reason) {
    result_->missing.push_back({name, reason});
  }
  void write_trajectory(const std::string& name, const Trajectory& trajectory,
                        const std::string& reason_when_empty) {
    if (trajectory.empty()) return leave_out(name, reason_when_empty);
    std::ostringstream text;
    write_tum(text, trajectory, "timestamp tx ty tz qx qy qz qw");
    write(name, text.str());
  }

 private:
  std::filesystem::path directory_;
  SessionResult* result_;
};

StampedPose stamped(std::int64_t utime_us, const SE3& T) {
  return {static_cast<double>(utime_us) / 1e6, T};
}

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void measure_areas(const MapRaster& raster, SessionResult* result) {
  std::size_t free_cells = 0;
  std::size_t occupied_cells = 0;
  for (const std::uint8_t cell : raster.probability) {
    const CellState state = state_of_cell(cell);
    if (state == CellState::kUnoccupied) ++free_cells;
    if (state == CellState::kOccupied) ++occupied_cells;
  }
  const double cell_m2 = raster.resolution_m * raster.resolution_m;
  result->free_area_m2 = static_cast<double>(free_cells) * cell_m2;
  result->occupied_area_m2 = static_cast<double>(occupied_cells) * cell_m2;
}

double length_m(const std::vector<FinalPose>& poses) {
  double length = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    length += (poses[i].T_map_base.translation() - poses[i - 1].T_map_base.translation()).norm();
  return length;
}

void write_maps(const MapCollection& maps, const std::vector<FinalPose>& way, Output* output,
                SessionResult* result) {
  std::string why;
  if (const auto raster = maps.grid(&result->map_source, &why)) {
    std::vector<Eigen::Vector2d> way_m;
    way_m.reserve(way.size());
    for (const FinalPose& pose : way) way_m.emplace_back(pose.T_map_base.translation().head<2>());
    output->write("map.pgm", pgm_bytes(*raster));
    output->write("map.yaml", map_yaml(*raster, "map.pgm"));
    output->write("map.png", map_png_bytes(*raster, way_m));
    measure_areas(*raster, result);
  } else {
    for (const char* name : {"map.pgm", "map.yaml", "map.png"}) output->leave_out(name, why);
  }
  // What each sensor alone would have given: to see, and to score, what fusion is good for.
  for (const auto& [name, channel] :
       {std::pair("lidar_map", "GRID_LIDAR"), std::pair("visual_map", "GRID_VISUAL")}) {
    const std::string pgm = std::string(name) + ".pgm", yaml = std::string(name) + ".yaml";
    if (const auto raster = maps.grid_of(channel, &why)) {
      output->write(pgm, pgm_bytes(*raster));
      output->write(yaml, map_yaml(*raster, pgm));
    } else {
      output->leave_out(pgm, why);
      output->leave_out(yaml, why);
    }
  }
  if (const auto octomap = octomap_bt_bytes(maps.octomap(), &why))
    output->write("octomap.bt", *octomap);
  else
    output->leave_out("octomap.bt", why);
  const auto cloud = maps.cloud();
  result->cloud_points = cloud.size();
  if (cloud.empty())
    output->leave_out("cloud.ply", "no point of the cloud came");
  else
    output->write("cloud.ply", ply_bytes(cloud));
}

}  // namespace

SessionResult SessionCollector::write(const std::filesystem::path& directory) const {
  SessionResult result;
  Output output(directory, &result);
  TrackedSession tracked = tracked_;
  tracked.T_map_nodes = graph_.T_map_nodes();
  const SE3 T_base_reference = robot_ ? robot_->T_base_reference() : SE3::Identity();

  const std::vector<FinalPose> poses = final_trajectory(tracked);
  Trajectory trajectory;
  for (const FinalPose& pose : poses) {
    trajectory.push_back(stamped(pose.utime_us, pose.T_map_base * T_base_reference));
    if (pose.bridged) ++result.bridged_poses;
  }
  Trajectory live;
  for (const auto& [utime_us, T_map_base] : live_)
    live.push_back(stamped(utime_us, T_map_base * T_base_reference));
  Trajectory ground_truth;
  for (const auto& [utime_us, T] : ground_truth_) ground_truth.push_back(stamped(utime_us, T));

  result.camera_frames = tracked.camera_utimes_us.size();
  result.lidar_scans = tracked.lidar_utimes_us.size();
  result.trajectory_poses = trajectory.size();
  result.coverage_percent =
      percent(trajectory.size(), tracked.has_camera() ? result.camera_frames : result.lidar_scans);
  result.live_poses = live.size();
  result.live_lost = live_lost_;
  result.ground_truth_poses = ground_truth.size();
  result.graph_nodes = tracked.T_map_nodes.size();
  result.graph_revision = graph_.revision();
  result.damaged_tiles = maps_.damaged_tiles();
  result.damaged_messages = damaged_messages_;
  result.path_length_m = length_m(poses);

  output.write_trajectory("trajectory.tum", trajectory,
                          "no VISUAL_POSE or LIDAR_POSE hangs on a node of GRAPH");
  output.write_trajectory("live.tum", live, "no POSE came");
  output.write_trajectory("groundtruth.tum", ground_truth, "the log has no GROUND_TRUTH");
  write_maps(maps_, poses, &output, &result);
  return result;
}

}  // namespace fusion_slam
