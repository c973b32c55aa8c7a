#include "libs/config/robot_config.hpp"

#include <cstdlib>

#include "libs/config/sensors.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

const char* const kLidarMount = "lidar_mount_xyz_m_rpy_deg";
const char* const kCameraMount = "camera_mount_xyz_m_rpy_deg";

SE3 mounting(const YamlMap& map, const std::string& key) {
  const auto v = map.numbers(key, 6, -360.0, 360.0, {0, 0, 0, 0, 0, 0});
  for (std::size_t i = 0; i < 3; ++i)
    if (std::abs(v[i]) > 10.0)
      map.fail(key, "puts the sensor more than 10 m away; the first three are metres");
  const double deg = M_PI / 180.0;
  return from_xyz_rpy(v[0], v[1], v[2], v[3] * deg, v[4] * deg, v[5] * deg);
}

fs::path sensor_file(const YamlMap& map, const fs::path& robot_file, const std::string& kind) {
  const fs::path directory = fs::absolute(robot_file).parent_path().parent_path() / "sensors";
  const std::string name = map.choice(kind, sensor_names(directory, kind), "");
  return directory / (name + ".yaml");
}

}  // namespace

RobotConfig load_robot_config(const fs::path& path) {
  const YamlMap map = YamlMap::from_file(
      path, {"name", "lidar", "camera", kLidarMount, kCameraMount, "odometry", "planar",
             "reference_frame", "map_resolution_m", "floor_clearance_m", "robot_height_m"});
  RobotConfig config;
  RobotModel& robot = config.robot;
  robot.name = map.text("name", path.stem().string());
  robot.has_lidar = map.has("lidar");
  robot.has_camera = map.has("camera");
  if (!robot.has_lidar && !robot.has_camera)
    map.fail("lidar", "and 'camera' are both missing; a robot needs one of them");
  if (robot.has_lidar) {
    config.lidar_file = sensor_file(map, path, "lidar");
    robot.lidar = load_lidar_model(config.lidar_file);
  }
  if (robot.has_camera) {
    config.camera_file = sensor_file(map, path, "camera");
    config.camera = load_camera_model(config.camera_file);
  }
  robot.T_base_lidar = mounting(map, kLidarMount);
  SE3 body_from_optical = SE3::Identity();
  body_from_optical.linear() = optical_to_body();
  robot.T_base_camera = mounting(map, kCameraMount) * body_from_optical;
  robot.has_odometry = map.flag("odometry", false);
  robot.planar = map.flag("planar", true);
  const std::string frame = map.choice("reference_frame", {"base", "camera", "lidar"}, "base");
  robot.reference_frame = frame == "camera"  ? ReferenceFrame::kCamera
                          : frame == "lidar" ? ReferenceFrame::kLidar
                                             : ReferenceFrame::kBase;
  robot.map_resolution_m = map.number("map_resolution_m", 0.005, 1.0, robot.map_resolution_m);
  robot.floor_clearance_m = map.number("floor_clearance_m", -10.0, 10.0, robot.floor_clearance_m);
  robot.robot_height_m = map.number("robot_height_m", 0.01, 20.0, robot.robot_height_m);
  if (robot.floor_clearance_m >= robot.robot_height_m)
    map.fail("floor_clearance_m", "is not below robot_height_m");
  return config;
}

RobotConfig find_robot(const std::string& robot) {
  const bool is_file =
      robot.find('/') != std::string::npos || fs::path(robot).extension() == ".yaml";
  const fs::path file =
      is_file ? fs::path(robot) : config_directory() / "robots" / (robot + ".yaml");
  if (!fs::exists(file))
    throw ConfigError("there is no robot " + robot + " (" + file.string() +
                      "): write that file, see config/robots/lab-robot.yaml");
  return load_robot_config(file);
}

fs::path config_directory() {
  if (const char* directory = std::getenv("FUSION_SLAM_CONFIG")) {
    if (fs::is_directory(fs::path(directory) / "robots")) return directory;
    throw ConfigError(std::string("FUSION_SLAM_CONFIG=") + directory +
                      ": has no robots/ in it; unset it or give the right directory");
  }
  std::error_code error;
  fs::path at = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (; !at.empty(); at = at.parent_path()) {
    for (const fs::path& candidate : {at / "config", at / "share/fusion-slam/config"})
      if (fs::is_directory(candidate / "robots")) return candidate;
    if (at == at.root_path()) break;
  }
  throw ConfigError(
      "no config/robots above this program; set FUSION_SLAM_CONFIG to the directory that holds "
      "robots/ and sensors/");
}

}  // namespace fusion_slam
