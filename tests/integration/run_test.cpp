// The whole chain: a simulated recording through `run`, with every service its own process over UDP
// multicast.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "libs/eventlog/reader.hpp"
#include "libs/eventlog/writer.hpp"
#include "libs/process/child.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

const fs::path kPrograms = FS_BINARY_DIR "/bin";

fs::path folder(const std::string& name) {
  const fs::path path = fs::path(FS_BINARY_DIR) / "tests" / "run_results" / name;
  fs::create_directories(path);
  return path;
}

// 6 s of the office, made once.
const fs::path& recording() {
  static const fs::path kLog = [] {
    const fs::path log = folder("recording") / "office.lcm";
    Child simulate("simulate",
                   {kPrograms / "simulate", FS_SOURCE_DIR "/config/worlds/office.yaml", "--seed",
                    "3", "--seconds", "6", "--camera-hz", "10", "--out", log},
                   folder("recording") / "simulate.log");
    while (simulate.running()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_TRUE(simulate.ended_well()) << simulate.last_lines(20);
    return log;
  }();
  return kLog;
}

Child start_run(const fs::path& log, const fs::path& out, std::vector<std::string> more = {}) {
  std::vector<std::string> argv{kPrograms / "run", log, "--out", out};
  argv.insert(argv.end(), more.begin(), more.end());
  fs::remove_all(out);
  fs::create_directories(out);
  return {"run", argv, out / "run.log"};
}

std::string finish(Child& run) {
  while (run.running()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return run.how_it_ended();
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  return all.str();
}

nlohmann::json metrics(const fs::path& out) {
  return nlohmann::json::parse(bytes_of(out / "metrics.json"));
}

// The pid of the first process named so whose parent is `parent`; 0: none.
pid_t child_named(pid_t parent, const std::string& name) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    std::string pid, command, state;
    pid_t ppid = 0;
    if (stat >> pid >> command >> state >> ppid && ppid == parent && command == "(" + name + ")")
      return static_cast<pid_t>(std::stoi(pid));
  }
  return 0;
}

template <class Condition>
bool soon(Condition condition) {
  for (int i = 0; i < 1000 && !condition(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

TEST(Run, TwoLockstepRunsAreIdenticalAndNothingIsDropped) {
  std::vector<std::string> first;
  for (const char* name : {"lockstep_1", "lockstep_2"}) {
    const fs::path out = folder(name);
    Child run = start_run(recording(), out);
    ASSERT_EQ(finish(run), "exit code 0") << run.last_lines(30);
    const auto m = metrics(out);
    EXPECT_EQ(m["dropped_total"], 0);
    EXPECT_EQ(m["lost_total"], 0);
    EXPECT_TRUE(m["complete"]);
    EXPECT_GE(m["coverage_percent"].get<double>(), 98.0);
    EXPECT_LT(m["ape_rmse_m"].get<double>(), 0.10);
    std::vector<std::string> all;
    for (const char* file : {"trajectory.tum", "live.tum", "map.pgm", "octomap.bt", "cloud.ply"}) {
      all.push_back(bytes_of(out / file));
      EXPECT_GT(all.back().size(), 100U) << file;
    }
    if (first.empty()) first = all;
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_TRUE(all[i] == first[i]) << "file " << i;
    for (const char* file : {"map.yaml", "map.png", "session.lcmlog", "groundtruth.tum"})
      EXPECT_TRUE(fs::exists(out / file)) << file;
  }
}

std::string run_map(const std::vector<std::string>& arguments, const fs::path& log_file) {
  std::vector<std::string> argv{kPrograms / "map"};
  argv.insert(argv.end(), arguments.begin(), arguments.end());
  Child map("map", argv, log_file);
  return finish(map);
}

// A map is saved, the same drive is found in it, and a second session is joined to it.
TEST(Run, MapLifeCycle) {
  const fs::path out = folder("map_first"), map = folder("map_saved") / "map";
  const fs::path map_log = folder("map_saved") / "map.log";
  Child first = start_run(recording(), out);
  ASSERT_EQ(finish(first), "exit code 0") << first.last_lines(30);
  ASSERT_EQ(run_map({"save", out, map}, map_log), "exit code 0") << bytes_of(map_log);
  const std::string journal = bytes_of(map / "journal.lcmlog");

  const fs::path found = folder("map_localize");
  Child localize = start_run(recording(), found, {"--map", map, "--mode", "localize"});
  ASSERT_EQ(finish(localize), "exit code 0") << localize.last_lines(30);
  const auto m = metrics(found);
  EXPECT_TRUE(m["map"]["localized"]) << m["map"];
  EXPECT_EQ(m["map"]["state"].get<std::string>().rfind("LOCALIZED", 0), 0U) << m["map"];
  EXPECT_GE(m["coverage_percent"].get<double>(), 90.0);
  EXPECT_LT(m["ape_rmse_m"].get<double>(), 0.10);
  EXPECT_EQ(bytes_of(found / "map.pgm"), bytes_of(map / "map.pgm"));  // the saved map is shown

  const fs::path more = folder("map_continue");
  Child go_on = start_run(recording(), more, {"--map", map, "--mode", "continue"});
  ASSERT_EQ(finish(go_on), "exit code 0") << go_on.last_lines(30);
  EXPECT_EQ(run_map({"load", "--check", more / "map"}, map_log), "exit code 0")
      << bytes_of(map_log);
  EXPECT_NE(bytes_of(map_log).find("2 sessions"), std::string::npos);
  EXPECT_EQ(bytes_of(map / "journal.lcmlog"), journal);  // only read
}

TEST(Run, ThroughputModeDropsNothing) {
  const fs::path out = folder("throughput");
  Child run = start_run(recording(), out, {"--mode", "throughput"});
  ASSERT_EQ(finish(run), "exit code 0") << run.last_lines(30);
  const auto m = metrics(out);
  EXPECT_EQ(m["dropped_total"], 0);
  EXPECT_EQ(m["lost_total"], 0);
  EXPECT_GE(m["coverage_percent"].get<double>(), 98.0);
}

TEST(Run, InterruptLeavesAPartialResultAndNoOrphan) {
  const fs::path out = folder("interrupt");
  Child run = start_run(recording(), out);
  pid_t service = 0;
  ASSERT_TRUE(soon([&] { return (service = child_named(run.pid(), "pose_graph")) != 0; }));
  ASSERT_TRUE(soon([&] {
    return fs::exists(out / "session.lcmlog") && fs::file_size(out / "session.lcmlog") > 300'000;
  }));
  run.signal(SIGINT);
  EXPECT_EQ(finish(run), "exit code 130") << run.last_lines(30);
  EXPECT_FALSE(metrics(out)["complete"]);
  EXPECT_TRUE(fs::exists(out / "trajectory.tum"));
  EXPECT_TRUE(soon([&] { return !fs::exists("/proc/" + std::to_string(service)); }));
}

TEST(Run, AServiceThatDiesEndsTheRunWithItsLastLines) {
  const fs::path out = folder("death");
  Child run = start_run(recording(), out);
  pid_t service = 0;
  ASSERT_TRUE(soon([&] { return (service = child_named(run.pid(), "fuser")) != 0; }));
  ASSERT_TRUE(soon([&] {
    return fs::exists(out / "session.lcmlog") && fs::file_size(out / "session.lcmlog") > 2'000'000;
  }));
  kill(service, SIGKILL);
  EXPECT_EQ(finish(run), "exit code 1");
  EXPECT_NE(run.last_lines(50).find("fuser ended: signal 9"), std::string::npos)
      << run.last_lines(50);
  EXPECT_GT(metrics(out)["duration_s"], 0.0) << "what was played until then";
}

TEST(Run, AnEventThatCannotBeDecodedIsSkippedAndCounted) {
  const fs::path out = folder("damaged");
  const fs::path log = folder("recording") / "damaged.lcm";
  {
    LogReader reader(recording());
    LogWriter writer(log);
    LogEvent event;
    for (int n = 0; n < 60 && reader.next(&event); ++n) {
      if (event.channel == "CAMERA" && n > 20) event.data.resize(event.data.size() / 2);
      writer.write(event.timestamp_us, event.channel, event.data);
    }
    writer.close();
  }
  Child run = start_run(log, out, {"--no-session"});
  ASSERT_EQ(finish(run), "exit code 0") << run.last_lines(30);
  EXPECT_GT(metrics(out)["undecodable_events_skipped"], 0);
  EXPECT_EQ(metrics(out)["dropped_total"], 0);
}

TEST(Run, DoesNotOverwriteTheLogItReads) {
  const fs::path out = folder("own_session");
  const fs::path log = out / "session.lcmlog";
  fs::copy_file(recording(), log, fs::copy_options::overwrite_existing);
  Child run("run", {kPrograms / "run", log, "--out", out}, out / "run.log");
  EXPECT_EQ(finish(run), "exit code 1");
  EXPECT_TRUE(bytes_of(log) == bytes_of(recording()));
  EXPECT_NE(run.last_lines(50).find("overwrite"), std::string::npos) << run.last_lines(50);
}

TEST(Run, AForeignFileIsNamed) {
  const fs::path out = folder("foreign");
  Child run = start_run(FS_SOURCE_DIR "/README.md", out);
  EXPECT_EQ(finish(run), "exit code 1");
  EXPECT_NE(run.last_lines(50).find("README.md"), std::string::npos) << run.last_lines(50);
}

TEST(Run, ALossyNetworkCostsTimeButNoMessage) {
  if (geteuid() != 0) GTEST_SKIP() << "skipped: unshare needs root";
  const fs::path out = folder("lossy");
  fs::remove_all(out);
  fs::create_directories(out);
  // A receive buffer that holds no burst: the kernel drops most of a camera frame's fragments at
  // first.
  const std::string command =
      "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo && "
      "exec " +
      (kPrograms / "run").string() + " " + recording().string() + " --out " + out.string() +
      " --mode throughput --max-events 250 --lcm-url "
      "'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=30000'";
  Child run("run", {"unshare", "--net", "sh", "-c", command}, out / "run.log");
  ASSERT_EQ(finish(run), "exit code 0") << run.last_lines(30);
  const auto m = metrics(out);
  EXPECT_TRUE(m["complete"]) << m;
  EXPECT_EQ(m["dropped_total"], 0);
  EXPECT_EQ(m["lost_total"], 0);
  EXPECT_EQ(m["channels"]["VISUAL_POSE"], m["channels"]["CAMERA"]);
  EXPECT_GE(m["coverage_percent"].get<double>(), 98.0);
}

}  // namespace
}  // namespace fusion_slam
