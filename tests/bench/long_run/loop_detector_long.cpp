// Does the loop detector grow with the area or with time? Its library is fed with what a long drive
// said (journals of the services, or a session.lcmlog), as fast as it goes, in the order of
// measurement time; each minute of drive is a line of CSV. Then the same once more as after a
// restart. CPU time; memory is this process's.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <set>

#include <CLI/CLI.hpp>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/journal/journal.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/loop_detector/loop_detector.hpp"
#include "services/loop_detector/loop_messages.hpp"
#include "tests/support/decoded.hpp"
#include "tests/support/process_meter.hpp"

namespace fusion_slam {
namespace {

NodeKind kind_of(std::int8_t kind) {
  return kind == graph_node_t::LIDAR ? NodeKind::kLidar : NodeKind::kKeyframe;
}

// One file; only channels that no file before it has are taken from it.
struct Source {
  std::unique_ptr<LogReader> reader;
  std::set<std::string> channels;
  LogEvent event;
  std::int64_t utime_us = 0;
  bool more = true;

  void advance() {
    while ((more = reader->next(&event))) {
      if (channels.count(event.channel) == 0) continue;
      if (event.channel == "GRAPH")
        utime_us = std::max(utime_us, decoded<graph_t>(event).utime);
      else if (event.channel == "SUBMAP")
        utime_us = std::max(utime_us, decoded<tile_t>(event).utime);
      else if (event.channel == "GROUND_TRUTH")
        utime_us = decoded<bot_core::pose_t>(event).utime;
      else if (event.channel == "KEYFRAME")
        utime_us = decoded<keyframe_t>(event).utime;
      else if (event.channel == "LIDAR_NODE")
        utime_us = decoded<lidar_node_t>(event).utime;
      return;
    }
  }
};

class Drive {
 public:
  explicit Drive(const std::vector<std::string>& files) {
    std::set<std::string> missing{"ROBOT_MODEL", "CAMERA_MODEL", "KEYFRAME",    "LIDAR_NODE",
                                  "SUBMAP",      "GRAPH",        "GROUND_TRUTH"};
    for (const std::string& file : files) {
      Source source;
      source.reader = std::make_unique<LogReader>(file);
      LogEvent event;
      while (source.reader->offset_bytes() < 60'000'000 && source.reader->next(&event))
        if (missing.erase(event.channel) > 0) source.channels.insert(event.channel);
      source.reader->seek(0);
      source.advance();
      sources_.push_back(std::move(source));
    }
  }
  bool has(const std::string& channel) const {
    return std::any_of(sources_.begin(), sources_.end(),
                       [&](const Source& s) { return s.channels.count(channel) > 0; });
  }
  bool next(LogEvent* event, std::int64_t* utime_us) {
    Source* first = nullptr;
    for (Source& source : sources_)
      if (source.more && (first == nullptr || source.utime_us < first->utime_us)) first = &source;
    if (first == nullptr) return false;
    *event = std::move(first->event);
    *utime_us = first->utime_us;
    first->advance();
    return true;
  }

 private:
  std::vector<Source> sources_;
};

class Bench {
 public:
  Bench(bool verdicts, bool by_truth) : verdicts_(verdicts), by_truth_(by_truth) {
    std::printf(
        "minute,rss_mb,keyframe_ms_mean,keyframe_ms_p95,scan_ms_mean,scan_ms_p95,"
        "candidates,accepted,constraints,searches,nothing_new,places,nodes,edges\n");
  }

  // Writes what the process would have written.
  void write_journal(const std::string& file) { journal_ = std::make_unique<Journal>(file); }

  void on(const LogEvent& event, std::int64_t utime_us) {
    std::string why;
    if (journal_ && event.channel != "SUBMAP" && event.channel != "GRAPH" &&
        event.channel != "GROUND_TRUTH")
      journal_->append(utime_us, event.channel, event.data.data(), event.data.size());
    if (event.channel == "ROBOT_MODEL" && !detector_) {
      robot_ = *from_message(decoded<robot_model_t>(event), &why);
      detector_ = std::make_unique<LoopDetector>(robot_);
      if (camera_) detector_->set_camera(*camera_);
    } else if (event.channel == "CAMERA_MODEL" && !camera_) {
      camera_ = from_message(decoded<camera_model_t>(event), &why);
      if (detector_ && camera_) detector_->set_camera(*camera_);
    }
    if (!detector_ || utime_us == 0) return;
    if (begin_us_ == 0) begin_us_ = utime_us;
    if (utime_us - begin_us_ >= 60'000'000LL * (minute_ + 1)) line();
    if (event.channel == "KEYFRAME") {
      auto keyframe = from_message(decoded<keyframe_t>(event), &why);
      if (!keyframe) return;
      unplaced_.emplace_back(NodeId{NodeKind::kKeyframe, keyframe->id}, utime_us);
      const double before = process_cpu_ms();
      const auto decided = detector_->add(*keyframe);
      keyframe_ms_.push_back(process_cpu_ms() - before);
      say(decided);
    } else if (event.channel == "LIDAR_NODE") {
      const auto scan = from_message(decoded<lidar_node_t>(event), &why);
      if (!scan) return;
      unplaced_.emplace_back(NodeId{NodeKind::kLidar, scan->id}, utime_us);
      const double before = process_cpu_ms();
      const auto decided = detector_->add(*scan);
      scan_ms_.push_back(process_cpu_ms() - before);
      say(decided);
    } else if (event.channel == "SUBMAP") {
      detector_->add_tile(from_message(decoded<tile_t>(event)));
    } else if (event.channel == "GROUND_TRUTH") {
      on_truth(decoded<bot_core::pose_t>(event));
    } else if (event.channel == "GRAPH" && !by_truth_) {
      const auto graph = decoded<graph_t>(event);
      for (const graph_node_t& node : graph.nodes)
        if (node.kind == graph_node_t::KEYFRAME || node.kind == graph_node_t::LIDAR)
          if (const auto T = from_message(node.T_map_base))
            detector_->moved({kind_of(node.kind), node.id}, *T);
      for (const loop_state_t& loop : graph.switched_off) {
        const NodeId from{kind_of(loop.from_kind), loop.from_id};
        const NodeId to{kind_of(loop.to_kind), loop.to_id};
        if (off_.emplace(from, to).second) detector_->switched_off(from, to);
      }
    }
  }

  void line() {
    ++minute_;
    const LoopCounts& c = detector_->counts();
    std::printf(
        "%lld,%.1f,%.2f,%.2f,%.2f,%.2f,%lld,%lld,%lld,%lld,%lld,%zu,%zu,%zu\n",
        static_cast<long long>(minute_), resident_mb(), mean(keyframe_ms_), p95(&keyframe_ms_),
        mean(scan_ms_), p95(&scan_ms_), static_cast<long long>(c.candidates - last_.candidates),
        static_cast<long long>(c.accepted - last_.accepted), static_cast<long long>(constraints_),
        static_cast<long long>(c.lidar_searches - last_.lidar_searches),
        static_cast<long long>(c.nothing_new - last_.nothing_new), detector_->sizes().places,
        detector_->sizes().nodes, detector_->sizes().edges);
    std::fflush(stdout);
    last_ = c;
    constraints_ = 0;
    keyframe_ms_.clear();
    scan_ms_.clear();
  }

 private:
  static double mean(const std::vector<double>& ms) {
    double sum = 0.0;
    for (const double t : ms) sum += t;
    return ms.empty() ? 0.0 : sum / static_cast<double>(ms.size());
  }
  static double p95(std::vector<double>* ms) {
    if (ms->empty()) return 0.0;
    std::sort(ms->begin(), ms->end());
    return (*ms)[ms->size() * 95 / 100];
  }
  // Instead of GRAPH: a graph that keeps up and is right.
  void on_truth(const bot_core::pose_t& message) {
    const auto T_world_reference = from_message(message);
    if (!by_truth_ || !T_world_reference) return;
    const SE3 T_world_base = *T_world_reference * robot_.T_base_reference().inverse();
    std::vector<std::pair<NodeId, std::int64_t>> later;
    for (const auto& [id, utime_us] : unplaced_) {
      if (utime_us > message.utime) {
        later.emplace_back(id, utime_us);
        continue;
      }
      if (truth_us_ == 0) continue;
      const double share =
          static_cast<double>(utime_us - truth_us_) /
          static_cast<double>(std::max<std::int64_t>(1, message.utime - truth_us_));
      detector_->moved(id, retract(T_truth_, share * local(T_truth_, T_world_base)));
    }
    unplaced_ = later;
    truth_us_ = message.utime;
    T_truth_ = T_world_base;
  }
  template <class Message>
  void append(const std::string& channel, const Message& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    journal_->append(0, channel, bytes.data(), bytes.size());
  }
  void say(const std::vector<LoopCandidate>& decided) {
    const KnownPlacesNews news = detector_->take_news();
    if (journal_ && !news.retired.empty()) append(kRetiredNote, note_of(news.retired));
    if (journal_ && !news.known.empty()) append(kKnownPlacesNote, note_of(news.known));
    for (const LoopCandidate& c : decided) {
      if (c.accepted && journal_)
        for (const LoopMeasurement& m : c.measurements) {
          constraint_t message = to_message(m, c.utime_us);
          message.seq = ++said_;
          append("CONSTRAINT", message);
        }
      if (c.accepted) constraints_ += static_cast<std::int64_t>(c.measurements.size());
      if (!verdicts_) continue;
      std::fprintf(stderr, "%d %lld -> %d %lld %s:", static_cast<int>(c.from.kind),
                   static_cast<long long>(c.from.id), static_cast<int>(c.to.kind),
                   static_cast<long long>(c.to.id), c.accepted ? "accepted" : "rejected");
      for (const StageVerdict& s : c.stages)
        std::fprintf(stderr, " %s %.17g %.17g %d (%s)", s.stage.c_str(), s.score, s.threshold,
                     s.passed ? 1 : 0, s.reason.c_str());
      for (const LoopMeasurement& m : c.measurements)
        std::fprintf(stderr, " | %.17g %.17g", m.T_from_to.translation().x(),
                     std::sqrt(m.covariance(0, 0)));
      std::fprintf(stderr, "\n");
    }
  }

  bool verdicts_, by_truth_;
  std::unique_ptr<Journal> journal_;
  std::int64_t said_ = 0;
  RobotModel robot_;
  SE3 T_truth_ = SE3::Identity();
  std::int64_t truth_us_ = 0;
  std::vector<std::pair<NodeId, std::int64_t>> unplaced_;
  std::unique_ptr<LoopDetector> detector_;
  std::optional<CameraModel> camera_;
  std::set<std::pair<NodeId, NodeId>> off_;
  std::int64_t begin_us_ = 0, minute_ = 0, constraints_ = 0;
  std::vector<double> keyframe_ms_, scan_ms_;
  LoopCounts last_;
};

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  CLI::App app{"Feeds the loop detector's library with a long drive; a line of CSV a minute"};
  std::vector<std::string> files;
  double minutes = 1e9;
  bool verdicts = false, by_truth = false;
  app.add_option("LOGS", files,
                 "loop_detector.lcmlog pose_graph.lcmlog lidar_mapper.lcmlog of a session's "
                 "journals, or one session.lcmlog; a channel is taken from the first that has it")
      ->required();
  app.add_option("--minutes", minutes, "stop after so many minutes of drive");
  app.add_flag("--by-truth", by_truth, "nodes lie where GROUND_TRUTH says, not GRAPH");
  app.add_flag("--verdicts", verdicts, "each candidate on stderr, to compare two versions");
  std::string journal;
  app.add_option("--journal", journal,
                 "write the journal that the process would have; then `loop_detector --journal` "
                 "says how long it takes to be built up again");
  CLI11_PARSE(app, argc, argv);
  fusion_slam::Drive drive(files);
  fusion_slam::Bench bench(verdicts, by_truth);
  if (by_truth && !drive.has("GROUND_TRUTH")) {
    std::fprintf(stderr, "no GROUND_TRUTH in these logs: leave out --by-truth\n");
    return 2;
  }
  if (!journal.empty()) bench.write_journal(journal);
  fusion_slam::LogEvent event;
  std::int64_t utime_us = 0, begin_us = 0;
  while (drive.next(&event, &utime_us)) {
    if (begin_us == 0) begin_us = utime_us;
    if (static_cast<double>(utime_us - begin_us) > minutes * 6e7) break;
    bench.on(event, utime_us);
  }
  bench.line();
  return 0;
}
