#include <memory>

#include "libs/bus/process.hpp"
#include "services/dense_mapper/dense_mapper_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(
      argc, argv, "dense_mapper",
      "Maps keyframe depth: coloured cloud, OctoMap and the camera's occupancy grid.",
      [](fusion_slam::Bus& bus) { return std::make_shared<fusion_slam::DenseMapperProcess>(bus); });
}
