// world_check WORLD.yaml --out DIR: writes the true map, says how near the route comes to
// obstacles, and draws simulated LiDAR scans over the true map (scans.png).
#include <cmath>
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/simulator/drive.hpp"
#include "drivers/simulator/scene.hpp"
#include "drivers/simulator/simulation.hpp"
#include "drivers/simulator/truth_files.hpp"
#include "drivers/simulator/world.hpp"

namespace fusion_slam {
namespace {

// The true map at `scale` pixels a cell; (column, row) of a point on it.
class MapPicture {
 public:
  MapPicture(const TruthMap& map, int scale)
      : raster_(map.raster), scale_(scale), picture_(raster_.height, raster_.width) {
    static const cv::Vec3b kClasses[kObstacleClasses] = {
        {0, 0, 0}, {70, 70, 70}, {178, 114, 0}, {0, 94, 213}, {115, 158, 0}, {0, 159, 230}};
    for (int row = 0; row < raster_.height; ++row)
      for (int column = 0; column < raster_.width; ++column) {
        const std::size_t i = raster_.index(column, row);
        const CellState state = state_of_cell(raster_.probability[i]);
        picture_(raster_.height - 1 - row, column) =
            state == CellState::kUnoccupied ? cv::Vec3b(252, 252, 252)
            : state == CellState::kOccupied ? kClasses[map.classes[i]]
                                            : cv::Vec3b(205, 205, 205);
      }
    cv::resize(picture_, picture_, {}, scale, scale, cv::INTER_NEAREST);
  }
  cv::Point at(const Eigen::Vector2d& p) const {
    const double k = scale_ / raster_.resolution_m;
    return {
        int(std::lround((p.x() - raster_.origin_x_m) * k)),
        int(std::lround((raster_.height * raster_.resolution_m - p.y() + raster_.origin_y_m) * k))};
  }
  cv::Mat_<cv::Vec3b>& picture() { return picture_; }

 private:
  const MapRaster& raster_;
  int scale_;
  cv::Mat_<cv::Vec3b> picture_;
};

int check(const std::string& file, const std::filesystem::path& out, double seconds) {
  const World world = load_world(file);
  const RobotModel robot = simulated_robot();
  const TruthMap map = write_truth(world, world.route_m, robot, robot.map_resolution_m, out);
  const Drive drive(world.route_m, world.limits, seconds);
  const Scene scene(world.boxes, world.meshes);
  const int scale = std::max(1, 1400 / std::max(map.raster.width, map.raster.height));
  MapPicture drawing(map, scale);
  double nearest = 2.0;
  Eigen::Vector2d where(0, 0);
  const Eigen::Vector3d lidar = robot.T_base_lidar.translation();
  std::vector<cv::Point> way;
  for (double t = 0.0; t < seconds; t += 0.05) {
    const SE2 T = drive.T_world_base(t);
    const double distance = nearest_obstacle_m(map, {T.x, T.y}, 2.0);
    if (distance < nearest) nearest = distance, where = {T.x, T.y};
    way.push_back(drawing.at({T.x, T.y}));
  }
  cv::polylines(drawing.picture(), way, false, {170, 170, 170}, 1, cv::LINE_AA);
  const int n_scans = 5;
  for (int k = 0; k < n_scans; ++k) {
    const double t = (drive.lap_s() > 0.0 ? drive.lap_s() : seconds) * (k + 0.3) / n_scans;
    const SE2 T = drive.T_world_base(t);
    const cv::Scalar colour(40 + 50 * k, 60, 230 - 45 * k);
    for (int beam = 0; beam < 360; ++beam) {
      const double angle = T.yaw + beam * M_PI / 180.0;
      const Eigen::Vector3d direction(std::cos(angle), std::sin(angle), 0.0);
      const Eigen::Vector3d from(T.x, T.y, lidar.z());
      const auto hit = scene.cast(from, direction, robot.lidar.range_max_m);
      if (hit && hit->t > robot.lidar.range_min_m)
        cv::circle(drawing.picture(), drawing.at((from + hit->t * direction).head<2>()), 2, colour,
                   cv::FILLED, cv::LINE_AA);
    }
    cv::circle(drawing.picture(), drawing.at({T.x, T.y}), 6, colour, cv::FILLED, cv::LINE_AA);
  }
  cv::imwrite((out / "scans.png").string(), drawing.picture());
  std::cout << world.name << ": " << map.raster.width << " x " << map.raster.height
            << " cells, closed " << map.closed << ", lap " << drive.lap_s() << " s, nearest "
            << nearest << " m at (" << where.x() << ", " << where.y() << ")\n";
  return map.closed && nearest >= 0.25 ? 0 : 1;
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app("Writes a world's true map, checks its route and draws LiDAR scans", "world_check");
  std::string world, out;
  double seconds = 240.0;
  app.add_option("WORLD", world, "world file")->required();
  app.add_option("--out", out, "directory for the pictures")->required();
  app.add_option("--seconds", seconds, "how much of the drive to check")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return fusion_slam::check(world, out, seconds);
  } catch (const std::exception& error) {
    std::cerr << "world_check: " << error.what() << "\n";
    return 1;
  }
}
