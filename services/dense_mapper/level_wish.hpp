// What the dense mapper asks of the pose graph for a camera carried by hand.
#pragma once

#include <cstdint>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

// "The map should be so that this keyframe's base has this z, roll and pitch": then its z is up and
// its z = 0 the floor.
struct LevelWish {
  std::int64_t anchor_id = 0;  // keyframe
  SE3 T_level_anchor = SE3::Identity();
  bool floor_seen = false;
  std::int64_t utime_us = 0;  // of the newest image behind it
};

}  // namespace fusion_slam
