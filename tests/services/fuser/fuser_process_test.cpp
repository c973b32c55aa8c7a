// The process on a private bus: what comes in after finish still reaches the map.
#include "services/fuser/fuser_process.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

class FuserOnBus : public ::testing::Test {
 protected:
  FuserOnBus() : transport_(std::make_shared<Transport>("memq://")) {
    bus_ = std::make_unique<Bus>(test_bus("fuser"), transport_);
    world_ = std::make_unique<Bus>(test_bus("world"), transport_);
    process_ = std::make_unique<FuserProcess>(*bus_);
    receiver_ = std::make_unique<TileReceiver>(*world_, "GRID_FUSED",
                                               [this](const Tile& t) { fused_[t.key] = t; });
    submaps_ = std::make_unique<TilePublisher>(*world_, "SUBMAP");
    visual_ = std::make_unique<TilePublisher>(*world_, "GRID_VISUAL");
  }
  template <class Condition>
  bool soon(Condition condition) {
    for (int i = 0; i < 500 && !condition(); ++i) {
      while (bus_->handle(1)) {
      }
      while (world_->handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return condition();
  }
  static Tile tile(std::int64_t submap, int x, double p, std::int64_t utime_us) {
    TileCells cells;
    cells.fill(cell_from_probability(p));
    return encode_grid_tile({submap, x, 0, 0}, cells, 0.05, 1, utime_us);
  }
  void say_graph(double x_m, std::int64_t utime_us) {
    graph_t graph{};
    graph.utime = utime_us;
    graph.n_parts = 1;
    graph.n_nodes = 1;
    graph.nodes.resize(1);
    graph.nodes[0].kind = graph_node_t::LIDAR;
    graph.nodes[0].id = 1;
    graph.nodes[0].T_map_base = to_message(to_se3({x_m, 0, 0}), utime_us);
    world_->publish("GRAPH", graph);
  }

  std::shared_ptr<Transport> transport_;
  std::unique_ptr<Bus> bus_, world_;
  std::unique_ptr<FuserProcess> process_;
  std::unique_ptr<TileReceiver> receiver_;
  std::unique_ptr<TilePublisher> submaps_, visual_;
  std::map<TileKey, Tile> fused_;
};

TEST_F(FuserOnBus, FusesAndFollowsTheGraphAfterFinish) {
  submaps_->publish(tile(1, 0, 0.9, 1000));  // before the model and before its anchor
  visual_->publish(tile(0, 0, 0.1, 1000));
  world_->publish("ROBOT_MODEL", to_message(RobotModel{}, 1000));
  say_graph(0.0, 2000);
  command_t finish{};
  finish.utime = 3000;
  finish.verb = "finish";
  world_->publish("COMMAND", finish);
  const TileKey here{0, 0, 0, 0};
  const TileKey there{0, 5, 0, 0};
  ASSERT_TRUE(soon([&] {
    const auto cells = fused_.count(here) != 0 ? decode_fused_tile(fused_[here]) : std::nullopt;
    return cells && cells->provenance[0] == static_cast<std::uint8_t>(Provenance::kConflict);
  }));
  say_graph(16.0, 3000);  // the last optimisation, after finish, with no newer time
  EXPECT_TRUE(soon([&] { return fused_.count(there) != 0; }));
  const auto cells = decode_fused_tile(fused_[here]);
  ASSERT_TRUE(cells);
  EXPECT_EQ(cells->provenance[0], static_cast<std::uint8_t>(Provenance::kCamera));
}

TEST_F(FuserOnBus, AfterResetTheMapIsWhatTheMappersSay) {
  world_->publish("ROBOT_MODEL", to_message(RobotModel{}, 1000));
  submaps_->publish(tile(1, 0, 0.9, 1000));
  visual_->publish(tile(0, 3, 0.1, 1000));
  say_graph(0.0, 2'000'000);
  ASSERT_TRUE(soon([&] { return fused_.size() >= 2; }));
  command_t reset{};
  reset.utime = 2'000'000;
  reset.verb = "reset";
  world_->publish("COMMAND", reset);
  // As the mappers do; no measurement follows.
  submaps_->clear();
  visual_->clear();
  EXPECT_TRUE(soon([&] {
    return std::all_of(fused_.begin(), fused_.end(), [](const auto& entry) {
      return entry.second.encoding == TileEncoding::kEmpty;
    });
  }));
  submaps_->publish(tile(2, 0, 0.9, 3'000'000));
  graph_t graph{};
  graph.utime = 9'000'000;
  graph.n_parts = 1;
  graph.n_nodes = 1;
  graph.nodes.resize(1);
  graph.nodes[0].kind = graph_node_t::LIDAR;
  graph.nodes[0].id = 2;
  graph.nodes[0].utime = 2'500'000;
  graph.nodes[0].T_map_base = to_message(SE3::Identity(), 1);
  world_->publish("GRAPH", graph);
  EXPECT_TRUE(soon([&] {
    return fused_.count({0, 0, 0, 0}) > 0 &&
           fused_[{0, 0, 0, 0}].encoding == TileEncoding::kGridFused;
  }));
}

}  // namespace
}  // namespace fusion_slam
