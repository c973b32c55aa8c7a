#include <memory>

#include "libs/bus/process.hpp"
#include "services/pose_graph/pose_graph_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(
      argc, argv, "pose_graph", "One pose graph for camera and LiDAR: publishes GRAPH and POSE.",
      [](fusion_slam::Bus& bus) { return std::make_shared<fusion_slam::PoseGraphProcess>(bus); });
}
