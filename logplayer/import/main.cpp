// import FORMAT SRC OUT.lcm: any recording to a standard LCM log.
#include <exception>
#include <iostream>

#include <unistd.h>

#include "logplayer/import/import.hpp"

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = fusion_slam::parse_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  try {
    const auto summary = fusion_slam::run_import(*options, isatty(2) != 0 ? &std::cerr : nullptr);
    fusion_slam::print_summary(*options, summary, std::cout);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "import: " << error.what() << "\n";
    return 1;
  }
}
