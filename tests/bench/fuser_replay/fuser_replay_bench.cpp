// The fuser's library over the SUBMAP, GRID_VISUAL and GRAPH messages of a recorded session: CPU
// time, and that of composing the submaps alone (libs/grid/grid_mosaic).
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "fusion_slam/graph_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/grid/grid_mosaic.hpp"
#include "libs/messages/convert.hpp"
#include "services/fuser/fuser.hpp"

namespace fusion_slam {
namespace {

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

struct Cost {
  std::vector<double> ms;

  void add(double before) { ms.push_back(cpu_ms() - before); }
  void print(const char* what) {
    if (ms.empty()) return;
    std::sort(ms.begin(), ms.end());
    double sum = 0.0;
    for (const double t : ms) sum += t;
    std::printf("%-28s %6zu calls, median %.2f, p95 %.2f, worst %.2f ms, in all %.2f s\n", what,
                ms.size(), ms[ms.size() / 2], ms[ms.size() * 95 / 100], ms.back(), sum * 1e-3);
  }
};

struct Input {
  bool visual = false;
  bool anchor = false;
  Tile tile;
  std::int64_t id = 0;
  SE3 T_map_submap = SE3::Identity();
  std::int64_t utime_us = 0;
};

std::vector<Input> read(const std::string& path) {
  std::vector<Input> inputs;
  LogReader reader(path);
  LogEvent event;
  while (reader.next(&event)) {
    const int size = static_cast<int>(event.data.size());
    if (event.channel == "SUBMAP" || event.channel == "GRID_VISUAL") {
      tile_t message;
      if (message.decode(event.data.data(), 0, size) < 0) continue;
      Input input;
      input.visual = event.channel == "GRID_VISUAL";
      input.tile = from_message(message);
      inputs.push_back(std::move(input));
    } else if (event.channel == "GRAPH") {
      graph_t message;
      if (message.decode(event.data.data(), 0, size) < 0) continue;
      for (const graph_node_t& node : message.nodes) {
        const auto T = from_message(node.T_map_base);
        if (node.kind != graph_node_t::LIDAR || !T) continue;
        Input input;
        input.anchor = true;
        input.id = node.id;
        input.T_map_submap = *T;
        input.utime_us = message.utime;
        inputs.push_back(std::move(input));
      }
    }
  }
  return inputs;
}

void run_fuser(const std::vector<Input>& inputs) {
  Fuser fuser(0.05, FuserConfig{});
  Cost all;
  std::size_t lidar = 0, fused = 0;
  for (const Input& input : inputs) {
    const double before = cpu_ms();
    if (input.anchor)
      fuser.set_anchor(input.id, input.T_map_submap, input.utime_us);
    else if (input.visual)
      fuser.add_visual_tile(input.tile);
    else
      fuser.add_submap_tile(input.tile);
    if (fuser.due()) {
      const FuserOutput output = fuser.update(false);
      lidar += output.lidar.size();
      fused += output.fused.size();
    }
    all.add(before);
  }
  const double before = cpu_ms();
  fuser.update(true);
  all.add(before);
  all.print("fuser");
  std::printf("%zu GRID_LIDAR and %zu GRID_FUSED tiles\n", lidar, fused);
}

// Composition alone, at the fuser's pace.
void run_mosaic(const std::vector<Input>& inputs) {
  GridMosaic mosaic(0.05, 0.25);
  Cost all;
  std::int64_t newest_us = 0, composed_us = 0;
  for (const Input& input : inputs) {
    if (input.visual) continue;
    const auto cells = input.anchor ? std::nullopt : decode_grid_tile(input.tile);
    const double before = cpu_ms();
    if (input.anchor)
      mosaic.set_pose(input.id, to_se2(input.T_map_submap));
    else if (cells)
      mosaic.set_tile(input.tile.key.submap_id, {input.tile.key.x, input.tile.key.y}, *cells,
                      input.tile.resolution_m);
    newest_us = std::max({newest_us, input.utime_us, input.tile.utime_us});
    if (newest_us >= composed_us + 1'000'000) {
      mosaic.recompose(false);
      composed_us = newest_us;
    }
    all.add(before);
  }
  const double before = cpu_ms();
  mosaic.recompose(true);
  std::printf("submaps hold %.2f MB, packed but for the newest\n",
              1e-6 * static_cast<double>(mosaic.submap_bytes()));
  all.add(before);
  all.print("grid_mosaic");
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"The fuser over a recorded session: CPU time"};
  std::string log;
  app.add_option("session", log, "session.lcmlog of a run")->required();
  CLI11_PARSE(app, argc, argv);
  try {
    const auto inputs = fusion_slam::read(log);
    std::printf("%zu inputs\n", inputs.size());
    fusion_slam::run_fuser(inputs);
    fusion_slam::run_mosaic(inputs);
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}
