// Places made of random points with random descriptors, and keyframes that see them.
#pragma once

#include <random>

#include "libs/camera/camera_model.hpp"
#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {

struct MadeUpPlace {
  std::vector<Eigen::Vector3d> points;
  std::vector<Descriptor> descriptors;
};

inline MadeUpPlace make_place(unsigned seed, int n = 400) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  MadeUpPlace place;
  for (int i = 0; i < n; ++i) {
    place.points.emplace_back(1.2 * u(random), 0.9 * u(random), 2.5 + u(random));
    Descriptor d;
    for (auto& word : d) word = (static_cast<std::uint64_t>(random()) << 32U) | random();
    place.descriptors.push_back(d);
  }
  return place;
}

// What a camera in this pose sees of it: half a pixel of noise, 25 bits of each descriptor flipped.
inline FeatureSet see_place(const MadeUpPlace& place, const CameraModel& camera,
                            const SE3& T_place_camera, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 0.5);
  FeatureSet set;
  for (std::size_t i = 0; i < place.points.size(); ++i) {
    const Eigen::Vector3d p = T_place_camera.inverse() * place.points[i];
    const Eigen::Vector2d pixel = camera.project(p);
    if (p.z() < 0.4 || pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479)
      continue;
    Feature f;
    f.u_px = static_cast<float>(pixel.x() + normal(random));
    f.v_px = static_cast<float>(pixel.y() + normal(random));
    f.depth_m = static_cast<float>(p.z());
    set.features.push_back(f);
    Descriptor d = place.descriptors[i];
    for (int k = 0; k < 25; ++k) {
      const unsigned bit = random() % 256;
      d[bit / 64] ^= 1ULL << (bit % 64);
    }
    set.descriptors.push_back(d);
  }
  return set;
}

inline LoopKeyframe keyframe_at(std::int64_t id, FeatureSet set) {
  LoopKeyframe keyframe;
  keyframe.id = id;
  keyframe.utime_us = id * 1'000'000;
  keyframe.features = std::move(set);
  return keyframe;
}

}  // namespace fusion_slam
