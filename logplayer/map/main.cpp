// map: saves, shows, publishes, exports and joins maps.
#include <exception>
#include <iostream>

#include "logplayer/map/commands.hpp"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = fusion_slam::parse_map_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    return fusion_slam::run_map_command(*options);
  } catch (const std::exception& error) {
    std::cerr << "map " << options->verb << ": " << error.what() << std::endl;
    return 1;
  }
}
