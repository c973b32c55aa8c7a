// KEYFRAME, as visual odometry says it.
#pragma once

#include "fusion_slam/keyframe_t.hpp"
#include "libs/features/feature.hpp"
#include "libs/messages/convert.hpp"
#include "services/loop_detector/loop_types.hpp"

namespace fusion_slam {

inline keyframe_t message_of(const LoopKeyframe& keyframe) {
  keyframe_t m{};
  m.utime = keyframe.utime_us;
  m.id = keyframe.id;
  m.T_odom_base = to_message(keyframe.T_odom_base, keyframe.utime_us);
  m.T_previous_base = m.T_odom_base;
  m.n = static_cast<std::int32_t>(keyframe.features.size());
  m.n_descriptor_bytes = m.n * 32;
  m.descriptors.resize(m.n_descriptor_bytes);
  for (int i = 0; i < m.n; ++i) {
    const Feature& f = keyframe.features.features[i];
    m.u_px.push_back(f.u_px);
    m.v_px.push_back(f.v_px);
    m.depth_m.push_back(f.depth_m);
    m.angle_rad.push_back(f.angle_rad);
    m.octave.push_back(f.octave);
    m.depth_sigma_m.push_back(f.depth_sigma_m);
    m.landmark_id.push_back(0);
    descriptor_to_bytes(keyframe.features.descriptors[i], m.descriptors.data() + 32 * i);
  }
  return m;
}

}  // namespace fusion_slam
