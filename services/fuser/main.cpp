#include <memory>

#include "libs/bus/process.hpp"
#include "services/fuser/fuser_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(
      argc, argv, "fuser", "Fuses the LiDAR's and the camera's occupancy grids into one map.",
      [](fusion_slam::Bus& bus) { return std::make_shared<fusion_slam::FuserProcess>(bus); });
}
