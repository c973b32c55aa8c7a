// Safe way points from a seed: a probabilistic road map (Kavraki et al. 1996) over the true map,
// and Dijkstra's shortest paths between random places in it. Pure functions; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/truth_map.hpp"
#include "drivers/simulator/world.hpp"

namespace fusion_slam {

struct RandomRouteOptions {
  Eigen::Vector2d start_m = Eigen::Vector2d::Zero();  // free: the first way point
  DriveLimits limits;
  double seconds = 60.0;  // the route takes longer than this
  double robot_radius_m = 0.20;
  double robot_height_m = 0.50;
  double margin_m = 0.12;  // more than the radius at way points and on the way between them, since
                           // the robot cuts corners; the drive itself keeps the radius
};

// Way points such that a Drive through them keeps the robot's radius free for `seconds`. Equal
// arguments give equal routes. Throws std::invalid_argument when there is no room to drive.
std::vector<Eigen::Vector2d> random_route(const World& world, const RandomRouteOptions& options,
                                          std::uint64_t seed);

// How far the nearest cell that is not free is, everywhere on a true map.
class Clearance {
 public:
  explicit Clearance(const TruthMap& map);
  double at(const Eigen::Vector2d& p_m) const;  // never too large; 0 off the map
  // Least of it on the straight way between two points, to half a cell; -1 once below `enough_m`.
  double between(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m, double enough_m) const;
  const std::vector<Eigen::Vector2d>& free_cells_m() const { return free_cells_m_; }  // centres

 private:
  MapRaster raster_;  // geometry only
  std::vector<float> distance_m_;
  std::vector<Eigen::Vector2d> free_cells_m_;
};

}  // namespace fusion_slam
