#include "libs/place_messages/place_messages.hpp"

#include <cmath>

namespace fusion_slam {
namespace {

constexpr int kMaxOctave = 31;

}  // namespace

std::optional<FeatureSet> features_from(const keyframe_t& message, std::string* why) {
  if (message.n < 0 || message.n_descriptor_bytes != message.n * std::int64_t{kDescriptorBytes}) {
    *why = "number of descriptor bytes is not 32 times the number of features";
    return std::nullopt;
  }
  FeatureSet set;
  for (std::int32_t i = 0; i < message.n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    Feature f;
    f.u_px = message.u_px[k];
    f.v_px = message.v_px[k];
    f.depth_m = message.depth_m[k];
    f.angle_rad = message.angle_rad[k];
    f.octave = message.octave[k];
    f.depth_sigma_m = message.depth_sigma_m[k];
    const bool finite = std::isfinite(f.u_px) && std::isfinite(f.v_px) &&
                        std::isfinite(f.depth_m) && std::isfinite(f.angle_rad);
    if (!finite || f.octave < 0 || f.octave > kMaxOctave) {
      *why = "feature " + std::to_string(i) + " has an impossible position, angle or octave";
      return std::nullopt;
    }
    set.features.push_back(f);
    set.descriptors.push_back(
        descriptor_from_bytes(message.descriptors.data() + k * kDescriptorBytes));
  }
  return set;
}

std::optional<Points> points_from(const lidar_node_t& message, std::string* why) {
  Points points;
  for (std::int32_t i = 0; i < message.n_points; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!std::isfinite(message.x_m[k]) || !std::isfinite(message.y_m[k])) {
      *why = "point " + std::to_string(i) + " is not finite";
      return std::nullopt;
    }
    points.emplace_back(message.x_m[k], message.y_m[k]);
  }
  return points;
}

}  // namespace fusion_slam
