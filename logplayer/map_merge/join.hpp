// Where does a second session lie in a first one's map? Proven the way a robot is localised: by
// both sensors, or by one under its stricter rules (libs/localization).
#pragma once

#include <string>
#include <vector>

#include "libs/localization/localizer.hpp"
#include "libs/map_directory/map_reader.hpp"

namespace fusion_slam {

struct Join {
  std::vector<MapFix> fixes;  // nodes of the second session, placed in the first's map
  std::string reason;         // why there is none
  std::int64_t times_found = 0;
};

// Drives the second session's journal through the first one's map.
Join find_join(const MapReader& first, const MapState& first_state, const MapReader& second,
               const RobotModel& second_robot);

// A closure between the two sessions: `from` a node of the first, `to` one of the second.
struct CrossLoop {
  NodeId from;
  NodeId to;
  SE3 T_from_to = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();
};

// One for each 0.5 m of the second session's way or 0.5 rad of turning: nearer ones say the same
// thing again. Fixes by views hang on the keyframe that was known again, those by the grid on the
// nearest LiDAR node.
std::vector<CrossLoop> cross_loops(const std::vector<MapFix>& fixes,
                                   const std::map<NodeId, SE3>& T_map_nodes);

}  // namespace fusion_slam
