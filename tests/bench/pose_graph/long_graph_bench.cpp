// The pose graph over a long drive, as fast as it goes or live at --pace: a journal of pose_graph
// (what a live session gave it, in its order) is fed to the library. For each minute of the drive:
// memory, nodes that are unknowns and nodes in all, edges, CPU time per message, how many nodes
// GRAPH would carry, and how far behind the sensors it was.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include <CLI/CLI.hpp>
#include <malloc.h>

#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/process/memory.hpp"
#include "libs/process/priority.hpp"
#include "services/pose_graph/graph_messages.hpp"
#include "services/pose_graph/pose_graph.hpp"
#include "tests/support/decoded.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

double in_use_mb() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) * 1e-6;
}

PoseGraphConfig config_for(double pace) {
  PoseGraphConfig config;
  if (pace <= 0.0) return config;
  config.wait_for_solver = false;
  config.solver_begins = give_way;
  return config;
}

class LongRun {
 public:
  explicit LongRun(double pace) : graph(config_for(pace)), pace_(pace) {}

  void on(const LogEvent& event) {
    if (pace_ > 0.0) std::this_thread::sleep_until(due());
    const double before_s = 1e-3 * process_cpu_ms();
    if (!feed(event)) return;
    for (const auto& change : graph.take_changes()) said_ += change.first.id > 0 ? 1 : 0;
    graph.take_poses();
    graph.take_retirements();
    if (graph.newest_utime_us() - trimmed_us_ >= 1'000'000) {  // as the process does, each second
      trimmed_us_ = graph.newest_utime_us();
      trims_ += give_back_memory(16 << 20) ? 1 : 0;
    }
    const double took_s = 1e-3 * process_cpu_ms() - before_s;
    ++messages_;
    sum_s_ += took_s;
    worst_s_ = std::max(worst_s_, took_s);
    const std::int64_t now_us = graph.newest_utime_us();
    if (first_us_ == 0) first_us_ = now_us;
    if (pace_ > 0.0)
      behind_s_ = std::max(behind_s_, std::chrono::duration<double>(Clock::now() - due()).count());
    minute_ = static_cast<double>(now_us - first_us_) * 1e-6 / 60.0;
    if (minute_ < next_minute_) return;
    row(minute_);
    next_minute_ += step;
  }

  void row(double minute) {
    const PoseGraphCounts& n = graph.counts();
    std::printf("%.1f,%.1f,%.1f,%zu,%zu,%zu,%ld,%ld,%ld,%.3f,%.1f,%ld,%.2f,%ld,%.3f\n", minute,
                resident_mb(), in_use_mb(), graph.nodes().size(), graph.n_nodes(),
                graph.edges().size(), n.loops, n.solves, n.bundles + n.bundles_refused,
                1e3 * sum_s_ / static_cast<double>(messages_), 1e3 * worst_s_, said_,
                1e-3 * process_cpu_ms(), trims_, behind_s_);
    std::fflush(stdout);
    messages_ = said_ = 0;
    sum_s_ = worst_s_ = behind_s_ = 0.0;
  }

  double minute() const { return minute_; }

  PoseGraph graph;
  double step = 1.0;  // minutes a row
  bool use_bundle = true;

 private:
  using Clock = std::chrono::steady_clock;

  // When the newest measurement is made, at this pace.
  Clock::time_point due() const {
    const double since_first_us =
        first_us_ == 0 ? 0.0 : static_cast<double>(graph.newest_utime_us() - first_us_);
    return began_ + std::chrono::microseconds(std::llround(since_first_us / pace_));
  }

  bool feed(const LogEvent& event) {
    std::string why;
    if (event.channel == "ROBOT_MODEL") {
      if (const auto robot = from_message(decoded<robot_model_t>(event), &why))
        graph.set_robot(*robot);
    } else if (event.channel == "CAMERA_MODEL") {
      const auto camera = from_message(decoded<camera_model_t>(event), &why);
      if (camera && use_bundle) graph.set_camera(*camera);
    } else if (event.channel == "KEYFRAME") {
      if (const auto node = node_from(decoded<keyframe_t>(event))) graph.add_node(*node);
    } else if (event.channel == "LIDAR_NODE") {
      if (const auto node = node_from(decoded<lidar_node_t>(event))) graph.add_node(*node);
    } else if (event.channel == "VISUAL_POSE") {
      graph.add_pose(pose_from(NodeKind::kKeyframe, decoded<pose_estimate_t>(event)));
    } else if (event.channel == "LIDAR_POSE") {
      graph.add_pose(pose_from(NodeKind::kLidar, decoded<pose_estimate_t>(event)));
    } else if (event.channel == "ODOMETRY") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(m)) graph.add_odometry(m.utime, *T);
    } else if (event.channel == "CONSTRAINT") {
      if (const auto loop = loop_from(decoded<constraint_t>(event))) graph.add_loop(*loop);
    } else {
      return false;
    }
    return true;
  }

  double pace_;  // 0: as fast as it goes
  Clock::time_point began_ = Clock::now();
  double behind_s_ = 0.0;
  std::int64_t first_us_ = 0;
  double minute_ = 0.0;
  double next_minute_ = 0.0;
  std::int64_t trimmed_us_ = 0, trims_ = 0;
  std::int64_t messages_ = 0;
  std::int64_t said_ = 0;
  double sum_s_ = 0.0;
  double worst_s_ = 0.0;
};

int run(int argc, char** argv) {
  CLI::App app(
      "The pose graph over a long drive: a row (CSV) for each minute with memory, nodes, edges and "
      "CPU time per message.");
  std::string journal, poses;
  double pace = 0.0, step = 1.0;
  bool use_bundle = true;
  app.add_option("journal", journal,
                 "pose_graph.lcmlog of a live session, or any log with its inputs")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--step", step, "minutes a row")->check(CLI::PositiveNumber);
  app.add_flag("!--no-bundle", use_bundle, "no bundle adjustment");
  app.add_option("--pace", pace, "live, so many times as fast as the drive was")
      ->check(CLI::PositiveNumber);
  app.add_option("--poses", poses, "file for where the nodes are at the end");
  double minutes = 1e9;
  app.add_option("--minutes", minutes, "stop after so many minutes of drive");
  CLI11_PARSE(app, argc, argv);
  LongRun bench(pace);
  bench.step = step;
  bench.use_bundle = use_bundle;
  std::printf(
      "minute,rss_mb,in_use_mb,unknowns,nodes,edges,loops,solves,bundles,ms_a_message,worst_ms,"
      "said,cpu_s,trims,behind_s\n");
  LogReader reader(journal);
  LogEvent event;
  while (bench.minute() < minutes && reader.next(&event)) bench.on(event);
  bench.row(99.0);
  std::ofstream file(poses);
  for (const auto& [id, node] : bench.graph.nodes_after({}, bench.graph.n_nodes()))
    file << static_cast<int>(id.kind) << ' ' << id.id << ' ' << node.utime_us << ' '
         << node.T_map_base.translation().transpose() << '\n';
  return 0;
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) { return fusion_slam::run(argc, argv); }
