#include "drivers/simulator/random_route.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint64_t kRouteStream = 60;
constexpr double kFloorM = 0.03;        // what is lower is driven over
constexpr std::size_t kPlaces = 160;    // of the road map
constexpr double kLongestEdgeM = 3.0;   // keeps the way points frequent
constexpr double kShortestTripM = 1.5;  // a goal nearer than this is no trip
constexpr std::size_t kOften = 50;      // steps after which a driven path is checked
constexpr int kFutileGoals = 60;        // goals in a row that can't be driven to
constexpr std::uint8_t kFreeByte = 1;   // truth_map.hpp

struct RoadMap {
  std::vector<Eigen::Vector2d> places_m;                           // 0: the start
  std::vector<std::vector<std::pair<std::size_t, double>>> edges;  // to, length
};

RoadMap make_road_map(const Clearance& clearance, const RandomRouteOptions& options,
                      Random* random) {
  const double enough_m = options.robot_radius_m + options.margin_m;
  RoadMap map;
  map.places_m.push_back(options.start_m);
  const auto& free = clearance.free_cells_m();
  for (std::size_t i = 0; i < 40 * kPlaces && map.places_m.size() <= kPlaces && !free.empty();
       ++i) {
    const Eigen::Vector2d& p = free[random->bits() % free.size()];
    if (clearance.at(p) >= enough_m) map.places_m.push_back(p);
  }
  map.edges.resize(map.places_m.size());
  for (std::size_t i = 0; i < map.places_m.size(); ++i)
    for (std::size_t j = i + 1; j < map.places_m.size(); ++j) {
      const double length = (map.places_m[i] - map.places_m[j]).norm();
      // The start is where somebody put it: there the radius must do.
      const double needed = i == 0 ? options.robot_radius_m : enough_m;
      if (length > kLongestEdgeM || length < 0.1 ||
          clearance.between(map.places_m[i], map.places_m[j], needed) < 0.0)
        continue;
      map.edges[i].emplace_back(j, length);
      map.edges[j].emplace_back(i, length);
    }
  return map;
}

// Dijkstra 1959: lengths and predecessors from one place.
struct Paths {
  std::vector<double> length_m;
  std::vector<std::size_t> before;
};
Paths shortest_paths(const RoadMap& map, std::size_t from) {
  const std::size_t n = map.places_m.size();
  Paths paths{std::vector<double>(n, INFINITY), std::vector<std::size_t>(n, from)};
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  paths.length_m[from] = 0.0;
  queue.emplace(0.0, from);
  while (!queue.empty()) {
    const auto [length, at] = queue.top();
    queue.pop();
    if (length > paths.length_m[at]) continue;
    for (const auto& [to, edge] : map.edges[at])
      if (length + edge < paths.length_m[to]) {
        paths.length_m[to] = length + edge;
        paths.before[to] = at;
        queue.emplace(length + edge, to);
      }
  }
  return paths;
}

// A drive so far: at the last way point, in the middle of a step.
struct Driven {
  Drive::Step step;
  std::size_t steps = 0;
  double length_m = 0.0;  // of the way points
};

// Drives on along `trip`; false when the robot touches something or doesn't arrive. Only the trip
// is driven, not all that was before it.
bool drive_on(const std::vector<Eigen::Vector2d>& trip, const Clearance& clearance,
              const RandomRouteOptions& options, Driven* driven) {
  const double longest_s = 4.0 * driven->length_m / options.limits.max_speed_m_s + 10.0;
  for (std::size_t goal = 0; static_cast<double>(driven->steps) * Drive::kStepS < longest_s;) {
    const SE2& pose = driven->step.T_world_base;
    const Eigen::Vector2d at(pose.x, pose.y);
    if ((trip[goal] - at).norm() < Drive::kReachedM && ++goal == trip.size()) return true;
    if (driven->steps++ % kOften == 0 && clearance.at(at) < options.robot_radius_m) return false;
    driven->step.T_world_base = drive_step(trip[goal], options.limits, &driven->step);
  }
  return false;
}

std::vector<TruthTriangle> triangles_of(const World& world) {
  std::vector<TruthTriangle> triangles;
  for (const Mesh& mesh : world.meshes)
    for (const auto& [a, b, c] : mesh.triangles)
      triangles.push_back({{mesh.vertices_m[a].cast<double>(), mesh.vertices_m[b].cast<double>(),
                            mesh.vertices_m[c].cast<double>()},
                           mesh.obstacle});
  return triangles;
}

}  // namespace

Clearance::Clearance(const TruthMap& map) : raster_(map.raster) {
  cv::Mat_<std::uint8_t> free(raster_.height, raster_.width);
  for (int row = 0; row < raster_.height; ++row)
    for (int column = 0; column < raster_.width; ++column) {
      const bool is_free = raster_.probability[raster_.index(column, row)] == kFreeByte;
      free(row, column) = is_free ? 1 : 0;
      if (is_free)
        free_cells_m_.emplace_back(raster_.origin_x_m + (column + 0.5) * raster_.resolution_m,
                                   raster_.origin_y_m + (row + 0.5) * raster_.resolution_m);
    }
  cv::Mat cells;
  cv::distanceTransform(free, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  // From a point in one cell to the border of another: up to a diagonal less than between centres.
  const auto diagonal = static_cast<float>(M_SQRT2);
  for (int row = 0; row < raster_.height; ++row)
    for (int column = 0; column < raster_.width; ++column)
      distance_m_.push_back(std::max(0.0F, cells.at<float>(row, column) - diagonal) *
                            static_cast<float>(raster_.resolution_m));
  raster_.probability.clear();
  raster_.provenance.clear();
}

double Clearance::at(const Eigen::Vector2d& p_m) const {
  const int column =
      static_cast<int>(std::floor((p_m.x() - raster_.origin_x_m) / raster_.resolution_m));
  const int row =
      static_cast<int>(std::floor((p_m.y() - raster_.origin_y_m) / raster_.resolution_m));
  if (column < 0 || row < 0 || column >= raster_.width || row >= raster_.height) return 0.0;
  return static_cast<double>(distance_m_[raster_.index(column, row)]);
}

double Clearance::between(const Eigen::Vector2d& a_m, const Eigen::Vector2d& b_m,
                          double enough_m) const {
  const int n = 1 + static_cast<int>((b_m - a_m).norm() / (0.5 * raster_.resolution_m));
  double least = INFINITY;
  for (int i = 0; i <= n; ++i) {
    least = std::min(least, at(a_m + (b_m - a_m) * (static_cast<double>(i) / n)));
    if (least < enough_m) return -1.0;
  }
  return least;
}

std::vector<Eigen::Vector2d> random_route(const World& world, const RandomRouteOptions& options,
                                          std::uint64_t seed) {
  TruthOptions truth;
  truth.resolution_m = 0.025;
  truth.band = {kFloorM, options.robot_height_m};
  const TruthMap truth_map =
      make_truth_map(world.boxes, triangles_of(world), options.start_m, truth);
  if (!truth_map.closed)
    throw std::invalid_argument(
        "the route's start is not within walls: a random route would leave the world");
  const Clearance clearance(truth_map);
  Random random(seed, kRouteStream);
  const RoadMap map = make_road_map(clearance, options, &random);
  std::vector<Eigen::Vector2d> points{options.start_m};
  std::size_t at = 0;
  int futile = 0;
  for (Driven driven; static_cast<double>(driven.steps) * Drive::kStepS <= options.seconds + 2.0;) {
    if (++futile > kFutileGoals)
      throw std::invalid_argument("found no way of " + std::to_string(options.seconds) +
                                  " s that keeps a robot of radius " +
                                  std::to_string(options.robot_radius_m) +
                                  " m free: is the route's start in a narrow place?");
    const std::size_t goal = random.bits() % map.places_m.size();
    const Paths paths = shortest_paths(map, at);
    if (!(paths.length_m[goal] >= kShortestTripM) || std::isinf(paths.length_m[goal])) continue;
    std::vector<Eigen::Vector2d> trip;
    for (std::size_t k = goal; k != at; k = paths.before[k]) trip.push_back(map.places_m[k]);
    std::reverse(trip.begin(), trip.end());
    Driven further = driven;
    if (points.size() == 1) further.step = drive_start(points[0], trip[0]);
    further.length_m += paths.length_m[goal];
    if (!drive_on(trip, clearance, options, &further)) continue;
    futile = 0;
    points.insert(points.end(), trip.begin(), trip.end());
    driven = further;
    at = goal;
  }
  return points;
}

}  // namespace fusion_slam
