// A map whose truth is known: points in a box, keyframes that walk past and see them, with noise.
#pragma once

#include <random>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

struct MadeUpMap {
  CameraModel camera;
  std::vector<double> scales{1.0};
  std::vector<Eigen::Vector3d> points;  // landmark i + 1 is point i
  std::map<std::int64_t, SE3> poses;    // of the keyframes, exact
  VisualMap map;
};

// `noise` 1: pixels by 0.6 px, depths by the camera's sigma; 0: exact. Every second feature has
// depth when `half_bearing_only`.
inline MadeUpMap make_map(int n_keyframes, int n_points, double noise,
                          bool half_bearing_only = false, bool linked = true) {
  MadeUpMap m;
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int i = 0; i < n_points; ++i)
    m.points.emplace_back(0.7 * unit(random), 0.5 * unit(random), 3.0 + 0.8 * unit(random));
  std::vector<Descriptor> looks(n_points);
  for (Descriptor& d : looks)
    for (auto& word : d) word = (std::uint64_t{random()} << 32U) | random();
  for (int i = 0; i < n_points && linked; ++i) {
    Landmark landmark;
    landmark.p_odom = m.points[i];
    landmark.descriptor = looks[i];
    m.map.add_landmark(std::move(landmark));
  }
  for (int k = 1; k <= n_keyframes; ++k) {
    const SE3 T =
        from_xyz_rpy(0.1 * k - 0.3, 0.02 * k, 0.03 * k, 0.01 * k, 0.02 * k - 0.05, 0.01 * k);
    m.poses[k] = T;
    auto set = std::make_shared<FeatureSet>();
    std::vector<int> of;
    for (int i = 0; i < n_points; ++i) {
      const Eigen::Vector3d p = T.inverse() * m.points[i];
      const Eigen::Vector2d pixel = m.camera.project(p);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
      Feature f;
      f.u_px = static_cast<float>(pixel.x() + noise * 0.6 * normal(random));
      f.v_px = static_cast<float>(pixel.y() + noise * 0.6 * normal(random));
      const double sigma = m.camera.depth_sigma(p.z());
      if (!half_bearing_only || i % 2 == 0) {
        f.depth_m = static_cast<float>(p.z() + noise * sigma * normal(random));
        f.depth_sigma_m = static_cast<float>(sigma);
      }
      set->features.push_back(f);
      set->descriptors.push_back(looks[i]);
      of.push_back(i);
    }
    MapKeyframe keyframe;
    keyframe.id = k;
    keyframe.segment = 1;
    keyframe.T_odom_camera = T;
    keyframe.features = set;
    keyframe.landmark_of_feature.assign(set->size(), 0);
    m.map.add_keyframe(std::move(keyframe));
    for (std::size_t f = 0; f < of.size() && linked; ++f) {
      m.map.link(of[f] + 1, k, static_cast<int>(f));
      renew_look(*set, static_cast<int>(f), T, 1.0, m.map.landmark(of[f] + 1));
    }
  }
  return m;
}

// Every link stands at both ends.
inline bool consistent(const VisualMap& map) {
  for (const auto& [id, landmark] : map.landmarks())
    for (const Observation& o : landmark.observations) {
      const MapKeyframe* keyframe = map.keyframe(o.keyframe);
      if (keyframe != nullptr && keyframe->landmark_of_feature[o.feature] != id) return false;
    }
  for (const auto& [id, keyframe] : map.keyframes())
    for (const std::int64_t seen : keyframe.landmark_of_feature) {
      if (seen == 0) continue;
      const Landmark* landmark = map.landmark(seen);
      if (landmark == nullptr) return false;
      bool back = false;
      for (const Observation& o : landmark->observations) back = back || o.keyframe == id;
      if (!back) return false;
    }
  return true;
}

}  // namespace fusion_slam
