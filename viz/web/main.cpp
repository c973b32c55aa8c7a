// viewer: the web page of Fusion-SLAM.
#include <exception>
#include <iostream>

#include "viz/web/viewer.hpp"

int main(int argc, char** argv) {
  try {
    int exit_code = 0;
    const auto options = fusion_slam::parse_viewer_options(argc, argv, &exit_code);
    if (!options) return exit_code;
    fusion_slam::run_viewer(*options);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "viewer: " << error.what() << "\n";
    return 1;
  }
}
