// How far the camera's mounting is off, for a robot on wheels: the floor it sees should be z = 0 of
// base. A degree of pitch lifts the floor by 9 cm at 5 m, into the band of obstacles; measured from
// the floor itself it lifts nothing. Not thread-safe, deterministic.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "libs/geometry/pose.hpp"
#include "services/dense_mapper/depth_cloud.hpp"

namespace fusion_slam {

// The floor in the base frame as the mounting on paper gives it: z = slope_x x + slope_y y +
// height_m.
struct FloorPlane {
  double slope_x = 0.0;
  double slope_y = 0.0;
  double height_m = 0.0;
};

// Least squares over the level surfaces near z = 0, the far ones leaving the fit in three rounds.
// Nothing when too little floor is seen, or what is seen is not a floor 4 degrees and 6 cm off at
// most.
std::optional<FloorPlane> fit_floor(const std::vector<SurfacePoint>& surfaces_camera,
                                    const SE3& T_base_camera);

// All that a Mounting goes by.
struct MountingState {
  std::deque<FloorPlane> floors;  // the latest
  std::size_t n_floors = 0;
  bool off = false;
  FloorPlane used;
};

class Mounting {
 public:
  Mounting() = default;
  explicit Mounting(const MountingState& state);  // goes on from there
  MountingState state() const { return state_; }

  void add(const DepthCloud& cloud, const SE3& T_base_camera);

  // T_true_base: takes points placed by the mounting on paper to where they are; the median of the
  // latest keyframes' floors. It changes only when that is worth it: 0.1 degree or 5 mm.
  const SE3& correction() const { return T_true_base_; }
  std::size_t floors() const { return state_.n_floors; }

 private:
  MountingState state_;
  SE3 T_true_base_ = SE3::Identity();
};

// The motion that makes this floor z = 0: the smallest rotation, then a shift along z.
SE3 levelled_floor(const FloorPlane& floor);

}  // namespace fusion_slam
