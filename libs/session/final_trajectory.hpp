// The trajectory after the last optimisation: what the trackers said relative to graph nodes, put
// where the nodes are now.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

struct TrackedPose {  // of VISUAL_POSE or LIDAR_POSE
  bool lost = false;
  NodeId reference;
  SE3 T_reference_base = SE3::Identity();
};

struct TrackedSession {
  std::set<std::int64_t> camera_utimes_us;  // frames that the camera took
  std::set<std::int64_t> lidar_utimes_us;
  std::map<std::int64_t, TrackedPose> visual;  // by utime
  std::map<std::int64_t, TrackedPose> lidar;
  std::map<NodeId, SE3> T_map_nodes;  // last GRAPH

  bool has_camera() const { return !camera_utimes_us.empty() || !visual.empty(); }
};

struct FinalPose {
  std::int64_t utime_us = 0;
  SE3 T_map_base = SE3::Identity();
  bool bridged = false;  // the camera was lost: interpolated between two scans
};

// One pose for each camera frame whose VISUAL_POSE wasn't LOST, or that lies between two scans with
// a pose, at most 0.5 s apart; without a camera, one for each scan with a pose. Ordered by time.
std::vector<FinalPose> final_trajectory(const TrackedSession& session);

}  // namespace fusion_slam
