// The back end without a bus: LiDAR mapper, loop detector and pose graph on a log (imported, or a
// session.lcmlog, whose KEYFRAME and VISUAL_POSE are used). Writes OUT/trajectory.tum,
// OUT/loops.txt (each decided candidate), OUT/closures.relations (the accepted ones) and
// OUT/graph.svg, and says where the time goes, what bundle adjustment did, and how honest the
// covariances are. --wrong-loop puts false closures into the graph and says what becomes of them.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <set>

#include <CLI/CLI.hpp>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/session/final_trajectory.hpp"
#include "logplayer/loops/loop_report.hpp"
#include "services/lidar_mapper/lidar_mapper.hpp"
#include "services/loop_detector/loop_detector.hpp"
#include "services/loop_detector/loop_messages.hpp"
#include "services/pose_graph/graph_messages.hpp"
#include "services/pose_graph/pose_graph.hpp"
#include "tests/bench/loops/edge_nees.hpp"
#include "tests/bench/loops/wrong_loops.hpp"
#include "tests/support/decoded.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

// CPU time of this process, its threads included: others may be at work on the machine.
class Stopwatch {
 public:
  template <class Work>
  auto time(const char* what, Work work) {
    struct Stop {
      Stopwatch* watch;
      const char* what;
      double before_ms;
      ~Stop() { watch->ms_[what].push_back(process_cpu_ms() - before_ms); }
    } stop{this, what, process_cpu_ms()};
    return work();
  }
  void report() {
    for (auto& [what, ms] : ms_) {
      std::sort(ms.begin(), ms.end());
      double sum = 0.0;
      for (const double t : ms) sum += t;
      std::printf("%-16s %6zu calls, CPU median %.2f ms, p99 %.2f, worst %.1f, sum %.2f s\n",
                  what.c_str(), ms.size(), ms[ms.size() / 2], ms[ms.size() * 99 / 100], ms.back(),
                  sum * 1e-3);
    }
  }

 private:
  std::map<std::string, std::vector<double>> ms_;
};

Matrix6d full(const Eigen::Matrix3d& planar) {
  Matrix6d all = Matrix6d::Identity() * 1e-6;
  const int index[3] = {0, 1, 5};
  for (int row = 0; row < 3; ++row)
    for (int col = 0; col < 3; ++col) all(index[row], index[col]) = planar(row, col);
  for (const int i : index) all(i, i) += 1e-8;
  return all;
}

class BackEnd {
 public:
  explicit BackEnd(const std::string& out)
      : loops_(out + "/loops.txt"), truth_(out + "/groundtruth.tum") {}

  void on(const LogEvent& event) {
    if (event.channel == "ROBOT_MODEL") {
      if (detector_) return;
      std::string why;
      robot_ = *from_message(decoded<robot_model_t>(event), &why);
      if (without.count("lidar") > 0) robot_.has_lidar = false;
      if (without.count("camera") > 0) robot_.has_camera = false;
      mapper_ = std::make_unique<LidarMapper>(robot_);
      detector_ = std::make_unique<LoopDetector>(robot_);
      report_.on_robot(robot_.T_base_reference());
      if (camera_) detector_->set_camera(*camera_);
      graph_.set_robot(robot_);
    } else if (event.channel == "CAMERA_MODEL") {
      std::string why;
      camera_ = from_message(decoded<camera_model_t>(event), &why);
      if (detector_) detector_->set_camera(*camera_);
      if (camera_ && use_bundle) graph_.set_camera(*camera_);
    }
    if (!detector_ || left_out(event.channel)) return;
    if (event.channel == "ODOMETRY") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(m)) {
        mapper_->add_odometry(m.utime, to_se2(*T));
        graph_.add_odometry(m.utime, *T);
        odometry_comes_ = true;
        if (waiting_ && m.utime >= waiting_->utime_us) hand_on_scan();
      }
    } else if (event.channel == "LIDAR") {
      std::string why;
      if (const auto scan = from_message(decoded<bot_core::planar_lidar_t>(event), &why)) {
        hand_on_scan();  // no scan waits longer than for the next one
        waiting_ = *scan;
        if (!odometry_comes_) hand_on_scan();
      }
    } else if (event.channel == "GROUND_TRUTH") {
      const auto m = decoded<bot_core::pose_t>(event);
      if (const auto T = from_message(m)) {
        true_poses_[m.utime] = *T * robot_.T_base_reference().inverse();
        report_.on_truth(m.utime, true_poses_[m.utime]);
        truth_ << tum_line(m.utime, *T);
      }
    } else if (event.channel == "KEYFRAME") {
      on_keyframe(decoded<keyframe_t>(event));
    } else if (event.channel == "VISUAL_POSE") {
      on_visual_pose(decoded<pose_estimate_t>(event));
    }
  }

  void finish(const std::string& out) {
    hand_on_scan();
    take(detector_->finish());
    watch_.time("finish", [&] { graph_.finish(); });
    pass_on();
    std::ofstream file(out + "/trajectory.tum");
    for (const auto& [id, node] : graph_.nodes_after({}, graph_.n_nodes()))
      session_.T_map_nodes[id] = node.T_map_base;
    for (const FinalPose& pose : final_trajectory(session_)) {
      const SE3 T = pose.T_map_base * robot_.T_base_reference();
      file << tum_line(pose.utime_us, T);
    }
    draw(out + "/graph.svg");
    const LoopCounts& c = detector_->counts();
    const PoseGraphCounts& g = graph_.counts();
    std::printf(
        "%ld keyframes, %ld scans; %ld LiDAR searches, %ld candidates, %ld accepted; graph: %zu "
        "nodes, %zu edges, %ld loops, %ld outvoted, %ld solves\n",
        c.keyframes, c.scans, c.lidar_searches, c.candidates, c.accepted, graph_.nodes().size(),
        graph_.edges().size(), g.loops, g.loops_outvoted, g.solves);
    if (g.restarts > 0)
      std::printf("%ld tracks started anew where nothing said how the robot had moved\n",
                  g.restarts);
    wrong_loops.say_remaining(graph_);
    std::printf("bundle adjustments: %ld taken over, %ld refused\n", g.bundles, g.bundles_refused);
    watch_.report();
    LoopReportOptions all;
    all.all = true;
    const std::string text = report_.text(all);
    say_end_to_start();
    say_nees(graph_.nodes(), graph_.edges(), true_poses_, robot_.planar);
    for (const EdgeKind kind : {EdgeKind::kVisual, EdgeKind::kLidar})
      say_chain_nees(graph_.nodes(), graph_.edges(), true_poses_, robot_.planar, kind);
    loops_ << text;
    std::ofstream(out + "/closures.relations") << report_.as_relations();
    const std::size_t totals = text.find(" candidates, ");
    std::printf("%s", text.substr(text.rfind('\n', totals) + 1).c_str());
  }

  std::set<std::string> without;  // inputs left out: camera, lidar, odometry
  bool use_loops = true;
  bool use_bundle = true;
  WrongLoops wrong_loops;

 private:
  bool left_out(const std::string& channel) const {
    const char* input = channel == "ODOMETRY"                               ? "odometry"
                        : channel == "LIDAR"                                ? "lidar"
                        : channel == "KEYFRAME" || channel == "VISUAL_POSE" ? "camera"
                                                                            : "";
    return without.count(input) > 0;
  }

  static std::string tum_line(std::int64_t utime_us, const SE3& T) {
    const Eigen::Quaterniond q(T.linear());
    char line[256];
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n",
                  static_cast<double>(utime_us) * 1e-6, T.translation().x(), T.translation().y(),
                  T.translation().z(), q.x(), q.y(), q.z(), q.w());
    return line;
  }
  // Where the last node is as seen from the first, against the truth: what is left after closure.
  void say_end_to_start() const {
    std::map<std::int64_t, SE3> by_time;
    for (const auto& [id, node] : graph_.nodes()) by_time[node.utime_us] = node.T_map_base;
    while (!by_time.empty() && !true_pose(true_poses_, by_time.rbegin()->first))
      by_time.erase(std::prev(by_time.end()));
    while (!by_time.empty() && !true_pose(true_poses_, by_time.begin()->first))
      by_time.erase(by_time.begin());
    if (by_time.empty()) return;
    const SE3 seen = by_time.begin()->second.inverse() * by_time.rbegin()->second;
    const SE3 right = true_pose(true_poses_, by_time.begin()->first)->inverse() *
                      *true_pose(true_poses_, by_time.rbegin()->first);
    std::printf("end against start: %.4f m, %.2f degrees off\n",
                (seen.translation() - right.translation()).norm(),
                log_so3(right.linear().transpose() * seen.linear()).norm() * 180.0 / M_PI);
  }

  // As the process does it: a scan waits for the odometry of its own time.
  void hand_on_scan() {
    if (!waiting_) return;
    const LaserScan scan = *waiting_;
    waiting_.reset();
    on_scan(scan);
  }

  // The way in grey, a loop a red line between its nodes.
  void draw(const std::string& path) const {
    Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
    for (const auto& [id, node] : graph_.nodes()) {
      low = low.cwiseMin(node.T_map_base.translation().head<2>());
      high = high.cwiseMax(node.T_map_base.translation().head<2>());
    }
    const double scale = 1000.0 / std::max(1.0, (high - low).maxCoeff());
    std::ofstream svg(path);
    const Eigen::Vector2d size = (high - low) * scale;
    svg << "<svg xmlns='http://www.w3.org/2000/svg' width='" << size.x() + 40 << "' height='"
        << size.y() + 40 << "'><rect width='100%' height='100%' fill='white'/>\n";
    const auto line = [&](const GraphEdge& edge, const char* style) {
      const auto at = [&](const NodeId& id) -> Eigen::Vector2d {
        const Eigen::Vector2d p = graph_.nodes().at(id).T_map_base.translation().head<2>();
        return {20 + (p.x() - low.x()) * scale, 20 + (high.y() - p.y()) * scale};
      };
      const Eigen::Vector2d a = at(edge.from), b = at(edge.to);
      svg << "<line x1='" << a.x() << "' y1='" << a.y() << "' x2='" << b.x() << "' y2='" << b.y()
          << "' " << style << "/>\n";
    };
    for (const GraphEdge& edge : graph_.edges())
      if (edge.kind == EdgeKind::kLoop) line(edge, "stroke='#d03030' stroke-width='0.7'");
    for (const GraphEdge& edge : graph_.edges())
      if (edge.kind != EdgeKind::kLoop) line(edge, "stroke='#303030' stroke-width='1.5'");
    svg << "</svg>\n";
  }

  void on_scan(const LaserScan& scan) {
    const MapperOutput output =
        watch_.time("lidar_mapper", [&] { return mapper_->add_scan(scan); });
    session_.lidar_utimes_us.insert(scan.utime_us);
    if (output.node) {
      const LidarNode& node = *output.node;
      NodeInput input;
      LoopScan loop_scan;
      input.id = {NodeKind::kLidar, node.id};
      loop_scan.id = node.id;
      input.utime_us = loop_scan.utime_us = node.utime_us;
      input.T_odom_base = loop_scan.T_odom_base = to_se3(node.T_odom_base);
      input.previous_id = loop_scan.previous_id = node.previous_id;
      input.T_previous_base = loop_scan.T_previous_base = to_se3(node.T_previous_base);
      input.covariance = loop_scan.covariance = full(node.covariance);
      for (const auto& in : node.submaps) {
        loop_scan.submaps.push_back({in.submap_id, to_se3(in.T_submap_base)});
      }
      loop_scan.points_base = node.points_base;
      report_.on_node(input.id, input.utime_us);
      watch_.time("graph node", [&] { graph_.add_node(input); });
      pass_on();
      take(watch_.time("detector scan", [&] { return detector_->add(loop_scan); }));
    }
    for (const Tile& tile : output.tiles) detector_->add_tile(tile);
    if (!output.pose) return;
    const LidarPose& pose = *output.pose;
    PoseInput input;
    input.sensor = NodeKind::kLidar;
    input.utime_us = pose.utime_us;
    input.T_odom_base = to_se3(pose.T_odom_base);
    input.covariance = full(pose.covariance);
    input.state = pose.state == MatchState::kLost
                      ? PoseState::kLost
                      : (pose.state == MatchState::kWeak ? PoseState::kWeak : PoseState::kOk);
    input.reason = pose.reason;
    input.reference = NodeId{NodeKind::kLidar, pose.reference_id};
    input.T_reference_base = to_se3(pose.T_reference_base);
    input.fix_utime_us = pose.fix_utime_us;
    session_.lidar[pose.utime_us] = {false, *input.reference, input.T_reference_base};
    watch_.time("graph pose", [&] { graph_.add_pose(input); });
    pass_on();
  }

  void on_keyframe(const keyframe_t& message) {
    std::string why;
    auto keyframe = from_message(message, &why);
    const auto node = node_from(message);
    if (!keyframe || !node) return;
    report_.on_node(node->id, node->utime_us);
    watch_.time("graph node", [&] { graph_.add_node(*node); });
    pass_on();
    take(watch_.time("detector keyframe", [&] { return detector_->add(*keyframe); }));
  }

  void on_visual_pose(const pose_estimate_t& message) {
    const PoseInput pose = pose_from(NodeKind::kKeyframe, message);
    session_.camera_utimes_us.insert(message.utime);
    if (pose.reference)
      session_.visual[message.utime] = {pose.state == PoseState::kLost, *pose.reference,
                                        pose.T_reference_base};
    mapper_->add_visual_pose(message.utime, to_se2(pose.T_odom_base), pose.state == PoseState::kOk);
    watch_.time("graph pose", [&] { graph_.add_pose(pose); });
    pass_on();
  }

  void pass_on() {
    wrong_loops.inject(&graph_);
    for (const auto& [id, node] : graph_.take_changes()) detector_->moved(id, node.T_map_base);
    graph_.take_poses();
    for (; switched_off_said_ < graph_.switched_off().size(); ++switched_off_said_) {
      const LoopState& off = graph_.switched_off()[switched_off_said_];
      detector_->switched_off(off.from, off.to);
      wrong_loops.say_switched_off(graph_, off);
    }
    const std::int64_t asked = graph_.counts().bundles + graph_.counts().bundles_refused;
    if (asked == bundles_said_) return;
    bundles_said_ = asked;
    std::printf("bundle adjustment %s: %s\n",
                graph_.last_bundle().accepted ? "taken over" : "refused",
                graph_.last_bundle().reason.c_str());
  }

  void take(const std::vector<LoopCandidate>& decided) {
    for (const LoopCandidate& c : decided) {
      report_.on_candidate(to_message(c));
      if (c.accepted)
        for (const LoopMeasurement& m : c.measurements)
          report_.on_constraint(to_message(m, c.utime_us));
      if (!c.accepted || !use_loops) continue;
      for (const LoopMeasurement& m : c.measurements)
        watch_.time("graph loop", [&] {
          graph_.add_loop({m.from, m.to, m.T_from_to, m.covariance, m.same_features});
        });
    }
    pass_on();
  }

  std::optional<LaserScan> waiting_;
  bool odometry_comes_ = false;
  RobotModel robot_;
  std::optional<CameraModel> camera_;
  std::unique_ptr<LidarMapper> mapper_;
  std::unique_ptr<LoopDetector> detector_;
  PoseGraph graph_;
  TrackedSession session_;
  std::int64_t bundles_said_ = 0;
  std::size_t switched_off_said_ = 0;
  std::ofstream loops_;
  std::ofstream truth_;
  LoopReport report_;
  TruePoses true_poses_;
  Stopwatch watch_;
};

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"Runs the back end over a log; writes OUT/trajectory.tum and OUT/loops.txt"};
  std::string log, out = "out";
  std::set<std::string> without;
  bool no_loops = false, no_bundle = false;
  std::vector<double> wrong_loops_s;
  double wrong_by_m = 0.0;
  app.add_option("LOG", log, "imported log or session.lcmlog")->required();
  app.add_option("--out", out, "folder");
  app.add_option("--without", without, "inputs left out: camera, lidar, odometry")
      ->delimiter(',')
      ->check(CLI::IsMember({"camera", "lidar", "odometry"}));
  app.add_flag("--no-loops", no_loops, "find loops but keep them from the graph");
  app.add_flag("--no-bundle", no_bundle, "no global bundle adjustment");
  app.add_option("--wrong-loop", wrong_loops_s,
                 "so many seconds after the first node: a false closure put in by hand, which says "
                 "that the robot is where it was at half that time; several: a,b")
      ->delimiter(',');
  app.add_option("--wrong-by", wrong_by_m,
                 "the false closures are so many metres beside the graph's opinion instead");
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(out);
  fusion_slam::BackEnd back_end(out);
  back_end.without = without;
  back_end.use_loops = !no_loops;
  back_end.use_bundle = !no_bundle;
  back_end.wrong_loops = fusion_slam::WrongLoops(wrong_loops_s, wrong_by_m);
  fusion_slam::LogReader reader(log);
  fusion_slam::LogEvent event;
  while (reader.next(&event)) back_end.on(event);
  back_end.finish(out);
  return 0;
}
