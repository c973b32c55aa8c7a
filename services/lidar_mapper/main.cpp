#include "libs/bus/process.hpp"
#include "services/lidar_mapper/lidar_mapper_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(
      argc, argv, "lidar_mapper",
      "Matches LiDAR scans to small maps: LIDAR to LIDAR_POSE, LIDAR_NODE, SUBMAP",
      [](fusion_slam::Bus& bus) { return std::make_shared<fusion_slam::LidarMapperProcess>(bus); });
}
