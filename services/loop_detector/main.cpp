#include "libs/bus/process.hpp"
#include "services/loop_detector/loop_detector_process.hpp"

int main(int argc, char** argv) {
  return fusion_slam::process_main(argc, argv, "loop_detector",
                                   "Finds places that the camera has seen before",
                                   [](fusion_slam::Bus& bus) {
                                     return std::make_shared<fusion_slam::LoopDetectorProcess>(bus);
                                   });
}
