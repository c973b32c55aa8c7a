#include <atomic>
#include <csignal>
#include <exception>
#include <iostream>

#include "procman/sheriff/options.hpp"
#include "procman/sheriff/tasks.hpp"

namespace {

std::atomic<bool> stop{false};

void on_signal(int) { stop = true; }

}  // namespace

int main(int argc, char** argv) {
  int exit_code = 0;
  const auto options = fusion_slam::parse_sheriff_options(argc, argv, &exit_code);
  if (!options) return exit_code;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  try {
    return fusion_slam::run_sheriff(*options, &stop);
  } catch (const std::exception& error) {
    std::cerr << "fusion-slam lab: " << error.what() << std::endl;
    return 1;
  }
}
