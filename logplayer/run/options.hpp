// What `fusion-slam run` was asked to do.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "libs/bus/policy.hpp"

namespace fusion_slam {

// What a run does with a saved map.
enum class MapUse {
  kLocalize,  // finds the robot in it; the map is only read
  kContinue,  // maps on, and joins the result to it
};

struct RunOptions {
  std::filesystem::path log;
  std::filesystem::path out;
  Mode mode = Mode::kLockstep;           // the pace
  std::filesystem::path map;             // a saved map; empty: make one from nothing
  MapUse map_use = MapUse::kLocalize;    // with a map
  std::string lcm_url;                   // empty: a private network
  std::int64_t most_events = 0;          // sensor events to play; 0: all
  std::filesystem::path relations;       // reference relations (Kuemmerle et al. 2009), optional
  double relations_time_offset_s = 0.0;  // added to the trajectory's times
  std::set<std::string> without;         // inputs left out: camera, lidar, odometry
  bool keep_session = true;              // record session.lcmlog
  std::filesystem::path programs;        // where the services' programs are
};

// The processes of a run, in the order they are started; each is a program of that name.
const std::vector<std::string>& service_names();
std::vector<std::string> service_names(const RunOptions& options);

// Parses the command line. Nothing: exit with *exit_code (help was shown, or the usage was wrong).
std::optional<RunOptions> parse_run_options(int argc, char** argv, int* exit_code);

}  // namespace fusion_slam
