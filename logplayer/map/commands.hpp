// `fusion-slam map save | load | info | export | merge`.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libs/map_directory/manifest.hpp"

namespace fusion_slam {

struct MapOptions {
  std::string verb;
  std::filesystem::path session;  // save
  std::filesystem::path map;      // save: to make; others: to read
  std::filesystem::path other;    // merge: the second map
  std::filesystem::path out;      // export, merge
  std::string format;             // export: pgm, png, bt, ot, ply, pcd, tum
  std::string grid = "best";      // export pgm, png: best, fused, lidar, visual
  bool images = true;             // save: with KEYFRAME_IMAGE
  bool check_only = false;        // load
  std::string lcm_url;            // load
};

// Nothing: exit with *exit_code (help was shown, or the usage was wrong).
std::optional<MapOptions> parse_map_options(int argc, char** argv, int* exit_code);

// The exit code: 0 done, 1 failed (said on stderr). Throws std::runtime_error, for people.
int run_map_command(const MapOptions& options);

// What is in a map, for people.
std::string describe(const MapSummary& summary);

// Each returns the exit code and throws std::runtime_error, for people.
int save_map(const MapOptions& options);
int show_map(const MapOptions& options);
int export_map(const MapOptions& options);
int merge_two_maps(const MapOptions& options);
// Checks a map whole, then publishes it until Ctrl-C: everybody sees it at once, and late listeners
// within 2 s.
int load_map(const MapOptions& options);

}  // namespace fusion_slam
