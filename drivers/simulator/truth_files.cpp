#include "drivers/simulator/truth_files.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "libs/maps/atomic_file.hpp"
#include "libs/maps/map_picture.hpp"
#include "libs/maps/ply_file.hpp"
#include "libs/maps/ros_map.hpp"

namespace fusion_slam {
namespace {

constexpr double kBelowFloor_m = -0.005;

ColouredPoint point_of(const Eigen::Vector3d& p_m, ObstacleClass obstacle) {
  // By class; Okabe & Ito 2008.
  static constexpr std::uint8_t kRgb[kObstacleClasses][3] = {
      {160, 160, 160}, {90, 90, 90}, {0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {230, 159, 0}};
  const auto& rgb = kRgb[static_cast<std::size_t>(obstacle)];
  return {p_m.cast<float>(), rgb[0], rgb[1], rgb[2]};
}

// A whole model that is lower than the LiDAR's plane is a low box, unless its class is known.
std::vector<TruthTriangle> triangles_of(const std::vector<Mesh>& meshes,
                                        const TruthOptions& options) {
  std::map<std::string, float> tops_m;
  for (const Mesh& mesh : meshes)
    for (const Eigen::Vector3f& v : mesh.vertices_m) {
      const auto top = tops_m.emplace(mesh.name, v.z()).first;
      top->second = std::max(top->second, v.z());
    }
  std::vector<TruthTriangle> triangles;
  for (const Mesh& mesh : meshes) {
    ObstacleClass obstacle = mesh.obstacle;
    if (obstacle == ObstacleClass::kOther &&
        tops_m[mesh.name] < static_cast<float>(options.lidar_height_m))
      obstacle = ObstacleClass::kLowBox;
    for (const auto& [a, b, c] : mesh.triangles)
      triangles.push_back({{mesh.vertices_m[a].cast<double>(), mesh.vertices_m[b].cast<double>(),
                            mesh.vertices_m[c].cast<double>()},
                           obstacle});
  }
  return triangles;
}

// Middles of n equal parts of [0, 1].
int parts(double length_m, double spacing_m) {
  return std::max(1, static_cast<int>(std::ceil(length_m / spacing_m)));
}
double middle(int i, int n) { return (i + 0.5) / n; }

void sample_box(const Box& box, double spacing_m, std::vector<ColouredPoint>* points) {
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, s = (axis + 1) % 3, t = (axis + 2) % 3;
    const int n = parts(2.0 * box.half_m[s], spacing_m), m = parts(2.0 * box.half_m[t], spacing_m);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < m; ++j) {
        Eigen::Vector3d p;
        p[axis] = (face % 2 == 1 ? 1.0 : -1.0) * box.half_m[axis];
        p[s] = (2.0 * middle(i, n) - 1.0) * box.half_m[s];
        p[t] = (2.0 * middle(j, m) - 1.0) * box.half_m[t];
        p = box.T_world_box * p;
        if (p.z() > kBelowFloor_m) points->push_back(point_of(p, box.obstacle));
      }
  }
}

// Rows parallel to the edge a-b; in each, points at equal distances.
void sample_triangle(const TruthTriangle& triangle, double spacing_m,
                     std::vector<ColouredPoint>* points) {
  const auto& [a, b, c] = triangle.corners_m;
  const double base_m = (b - a).norm();
  const double height_m = base_m > 0.0 ? (b - a).cross(c - a).norm() / base_m : (c - a).norm();
  const int rows = parts(height_m, spacing_m);
  for (int row = 0; row < rows; ++row) {
    const double up = middle(row, rows);
    const int n = parts(base_m * (1.0 - up), spacing_m);
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector3d p = a + up * (c - a) + (1.0 - up) * middle(i, n) * (b - a);
      if (p.z() > kBelowFloor_m) points->push_back(point_of(p, triangle.obstacle));
    }
  }
}

}  // namespace

std::vector<ColouredPoint> sample_surfaces(const std::vector<Box>& boxes,
                                           const std::vector<TruthTriangle>& triangles,
                                           double spacing_m) {
  std::vector<ColouredPoint> points;
  for (const Box& box : boxes) sample_box(box, spacing_m, &points);
  for (const TruthTriangle& triangle : triangles) sample_triangle(triangle, spacing_m, &points);
  return points;
}

std::string class_pgm_bytes(const TruthMap& map) {
  std::string bytes = "P5\n" + std::to_string(map.raster.width) + " " +
                      std::to_string(map.raster.height) + "\n255\n";
  for (int row = map.raster.height - 1; row >= 0; --row)
    for (int column = 0; column < map.raster.width; ++column)
      bytes.push_back(static_cast<char>(map.classes[map.raster.index(column, row)]));
  return bytes;
}

TruthMap write_truth(const World& world, const std::vector<Eigen::Vector2d>& route_m,
                     const RobotModel& robot, double resolution_m,
                     const std::filesystem::path& directory) {
  if (route_m.empty())
    throw std::runtime_error("the true map needs a route: its start says what is inside");
  TruthOptions options = truth_options_for(robot);
  options.resolution_m = resolution_m;
  const std::vector<TruthTriangle> triangles = triangles_of(world.meshes, options);
  TruthMap map = make_truth_map(world.boxes, triangles, route_m.front(), options);
  std::filesystem::create_directories(directory);
  write_file_atomically(directory / "map.pgm", pgm_bytes(map.raster));
  write_file_atomically(directory / "map.yaml", map_yaml(map.raster, "map.pgm"));
  write_file_atomically(directory / "classes.pgm", class_pgm_bytes(map));
  write_file_atomically(directory / "map.png", map_png_bytes(map.raster, route_m));
  write_file_atomically(directory / "surfaces.ply",
                        ply_bytes(sample_surfaces(world.boxes, triangles, resolution_m)));
  return map;
}

}  // namespace fusion_slam
