// The program: options, the server, and a session behind it, live or recorded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "viz/web/web_server.hpp"

namespace fusion_slam {

struct ViewerOptions {
  std::filesystem::path session;  // a log, or a folder with session.lcmlog; empty: live
  std::string lcm_url;
  ServerOptions server;
  std::filesystem::path save_directory = ".";
  std::filesystem::path lab;  // configuration for the sheriff; empty: nothing can be started
};

// Nothing when the program has to end with *exit_code (--help, wrong usage).
std::optional<ViewerOptions> parse_viewer_options(int argc, char** argv, int* exit_code);

// Until SIGINT, SIGTERM or (live) COMMAND quit. Throws std::runtime_error, for people, when it
// can't start.
void run_viewer(const ViewerOptions& options);

}  // namespace fusion_slam
