#include <atomic>
#include <csignal>
#include <exception>
#include <iostream>

#include "procman/deputy/deputy_process.hpp"
#include "procman/deputy/options.hpp"

namespace {

std::atomic<bool> stop{false};

void on_signal(int) { stop = true; }

}  // namespace

int main(int argc, char** argv) {
  try {
    int exit_code = 0;
    const auto options = fusion_slam::parse_deputy_options(argc, argv, &exit_code);
    if (!options) return exit_code;
    fusion_slam::DeputyProcess deputy(*options);
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    std::signal(SIGHUP, on_signal);
    std::cerr << "procman-deputy: \"" << options->name << "\" waits for orders" << std::endl;
    deputy.run(&stop);
  } catch (const std::exception& error) {
    std::cerr << "procman-deputy: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
