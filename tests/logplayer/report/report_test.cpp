#include "logplayer/report/report.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/status_t.hpp"
#include "libs/eventlog/writer.hpp"
#include "libs/messages/convert.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

template <class Message>
void log(LogWriter* writer, const std::string& channel, const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  writer->write(0, channel, bytes);
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

class RunFolder : public testing::Test {
 protected:
  RunFolder() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write("metrics.json",
          R"({"log": "/x/kitchen<1>.lcm", "mode": "lockstep", "complete": true,
              "coverage_percent": 100.0, "ape_rmse_m": 0.0123, "dropped_total": 0})");
    std::ofstream truth(folder_ / "groundtruth.tum"), estimate(folder_ / "trajectory.tum");
    for (int i = 0; i < 50; ++i) {
      const double t = 0.1 * i, x = std::cos(t), y = std::sin(t);
      truth << t << " " << x << " " << y << " 0 0 0 0 1\n";
      estimate << t << " " << x << " " << y + (i == 25 ? 0.04 : 0.0) << " 0 0 0 0 1\n";
    }
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  void write_session() const {
    LogWriter writer(folder_ / "session.lcmlog");
    for (int i = 0; i < 3; ++i) {
      status_t status{};
      status.utime = 1'000'000 * i;
      status.process = "fuser";
      status.peak_rss_bytes = 12'300'000;
      log(&writer, "STATUS", status);
      lidar_node_t node{};
      node.id = i;
      node.utime = 1'000'000 * i;
      log(&writer, "LIDAR_NODE", node);
    }
    constraint_t loop{};
    loop.from_kind = loop.to_kind = graph_node_t::LIDAR;
    loop.to_id = 2;
    loop.T_from_to = to_message(SE3::Identity(), 0);
    loop.source = "lidar loop";
    log(&writer, "CONSTRAINT", loop);
    graph_t graph{};
    loop_state_t off{};
    off.from_kind = off.to_kind = graph_node_t::LIDAR;
    off.to_id = 2;
    off.reason = "2 m <off>";
    graph.switched_off = {off};
    graph.n_switched_off = 1;
    log(&writer, "GRAPH", graph);
    writer.close();
  }
  fs::path folder_ = fs::path(testing::TempDir()) / "fs_run_report";
};

TEST_F(RunFolder, WhatIsThereIsShown) {
  write_session();
  const fs::path page = write_report({folder_, {}, {}});
  EXPECT_EQ(page, folder_ / "report.html");
  const std::string html = text_of(page);
  for (const char* part :
       {"kitchen&lt;1&gt;", "0.0123 m", "Absolute pose error", "12.3 MB", "1 closures, 1 of them",
        "scan 0 - scan 2, lidar loop, switched off: 2 m &lt;off&gt;", "</html>"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(text_of(write_report({folder_, {}, folder_ / "again.html"})), html);
}

TEST_F(RunFolder, WhatIsNotThereIsLeftOutOrNamed) {
  fs::remove(folder_ / "groundtruth.tum");
  const std::string html = text_of(write_report({folder_, {}, {}}));
  EXPECT_NE(html.find("No session.lcmlog"), std::string::npos);
  EXPECT_EQ(html.find("Absolute pose error"), std::string::npos);
}

TEST_F(RunFolder, NoRunIsAnError) {
  fs::remove(folder_ / "metrics.json");
  EXPECT_THROW(write_report({folder_, {}, {}}), std::runtime_error);
  write("metrics.json", "{\"log\": ");
  EXPECT_THROW(write_report({folder_, {}, {}}), std::runtime_error);
  write("metrics.json", "[1]");
  EXPECT_THROW(write_report({folder_, {}, {}}), std::runtime_error);
  EXPECT_FALSE(fs::exists(folder_ / "report.html"));
}

TEST_F(RunFolder, TheTrueMapStandsBeside) {
  write("true.pgm", std::string("P5\n2 1\n255\n") + static_cast<char>(254) + '\0');
  write("true.yaml",
        "image: true.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.25\nmode: trinary\n");
  EXPECT_NE(text_of(write_report({folder_, folder_ / "true.yaml", {}})).find("True map"),
            std::string::npos);
}

}  // namespace
}  // namespace fusion_slam
