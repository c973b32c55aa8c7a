// A second session's messages as if they had come after the first's: ids, sequence numbers and
// times that do not collide.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "libs/eventlog/event.hpp"
#include "libs/graph/node_id.hpp"

namespace fusion_slam {

// Added to what the second session says.
struct Offsets {
  std::int64_t keyframe = 0;
  std::int64_t lidar_node = 0;  // submaps are named by LiDAR nodes
  std::int64_t landmark = 0;
  std::int64_t time_us = 0;
  std::map<std::string, std::int64_t> seq;  // by channel

  NodeId moved(const NodeId& id) const {
    return {id.kind, id.id + (id.kind == NodeKind::kLidar ? lidar_node : keyframe)};
  }
};

// The largest of each that a session's messages hold: the offsets of whoever comes after it. Its
// time_us stays 0. False: the message holds none.
void note_largest(const LogEvent& event, Offsets* largest);

// The message with the offsets added; id 0 (none) stays 0. Messages of the journal's streams and of
// SUBMAP; others are returned as they are.
LogEvent renumbered(const LogEvent& event, const Offsets& offsets);

}  // namespace fusion_slam
