// `eval map`: an occupancy grid against a reference grid.
#pragma once

#include <filesystem>
#include <vector>

namespace CLI {
class App;
}

namespace fusion_slam {

struct MapTaskOptions {
  std::filesystem::path reference;           // map.yaml
  std::filesystem::path estimate;            // map.yaml
  std::vector<std::filesystem::path> align;  // reference and estimated trajectory, or none
  std::filesystem::path classes;             // empty: none
  int tolerance_cells = 1;
  double max_diff_s = 0.01;
  std::filesystem::path json;    // empty: none
  std::filesystem::path plot;    // empty: none
  std::filesystem::path report;  // empty: none
};

// Adds the sub-command's arguments; `options` must outlive the parsing.
void add_map_options(CLI::App& app, MapTaskOptions& options);

// Reads, computes, prints the table and writes what was asked for. Returns the program's exit code:
// 0, or 1 with the reason on stderr. Throws std::runtime_error for files that can't be read.
int run_map_task(const MapTaskOptions& options);

}  // namespace fusion_slam
