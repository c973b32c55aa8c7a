#include "libs/bus/process.hpp"
#include "services/visual_odometry/visual_odometry_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(
      argc, argv, "visual_odometry", "Tracks an RGB-D camera frame by frame and makes keyframes",
      [](fusion_slam::Bus& bus) {
        return std::make_shared<fusion_slam::VisualOdometryProcess>(bus);
      });
}
