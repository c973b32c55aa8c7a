#include <iostream>

#include "logplayer/run/run.hpp"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = fusion_slam::parse_run_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    return fusion_slam::run_log(*options);
  } catch (const std::exception& error) {
    std::cerr << "run: " << error.what() << std::endl;
    return 1;
  }
}
