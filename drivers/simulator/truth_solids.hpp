// What a robot can hit, seen from above: every obstacle cut to the band of heights between the
// robot's floor clearance and its height, and projected to the floor. World frame, metres. Pure
// functions, callable from any thread.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "drivers/simulator/scene.hpp"
#include "libs/evaluation/map_class.hpp"

namespace fusion_slam {

struct HeightBand {
  double low_m = 0.05;   // what is lower is floor
  double high_m = 0.60;  // what is higher doesn't hit the robot
};

struct TruthTriangle {
  std::array<Eigen::Vector3d, 3> corners_m;
  ObstacleClass obstacle = ObstacleClass::kOther;
};

// A convex polygon on the floor (z is 0) or, of a surface, in space.
struct Footprint {
  std::vector<Eigen::Vector3d> outline_m;
  double low_m = 0.0;  // heights between which it stands
  double high_m = 0.0;
  bool surface = false;  // without volume: even what only touches a cell fills it
  ObstacleClass obstacle = ObstacleClass::kOther;
};

// The part of a convex polygon with sign * p[axis] <= sign * limit; empty when there is none
// (Sutherland & Hodgman 1974). What touches the limit stays.
std::vector<Eigen::Vector3d> clip(const std::vector<Eigen::Vector3d>& polygon, int axis,
                                  double sign, double limit);

// Nothing when no part lies within the band. A box's outline is the convex hull of what of it lies
// there; its heights are those of the whole part, exact for boxes that stand upright.
std::optional<Footprint> footprint_of(const Box& box, const HeightBand& band);
std::optional<Footprint> footprint_of(const TruthTriangle& triangle, const HeightBand& band);

}  // namespace fusion_slam
