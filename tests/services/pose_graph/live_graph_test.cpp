// The live process with a graph too large for one message: who starts late has it all, and a
// restart from the journal carries the same nodes.
#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "fusion_slam/graph_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/pose_graph/pose_graph_process.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

constexpr int kPerRound = 30;  // nodes; a round takes 20 s
constexpr int kNodes = 20 * kPerRound;

// Runs until it is destroyed, as if it were killed: nothing is said at the end.
struct Service {
  Service(const std::string& journal, const std::shared_ptr<Transport>& network) {
    BusOptions options = test_bus("pose_graph");
    options.journal = journal;
    bus = std::make_unique<Bus>(options, network);
    process = std::make_unique<PoseGraphProcess>(*bus);
    thread = std::thread([this] { bus->run(); });
  }
  ~Service() {
    bus->stop();
    if (thread.joinable()) thread.join();
  }
  void renew_journal() {
    bus->stop();
    thread.join();
    EXPECT_TRUE(bus->renew_journal());
  }
  std::string says() const { return bus->status().state_text; }
  std::unique_ptr<Bus> bus;
  std::unique_ptr<PoseGraphProcess> process;
  std::thread thread;
};

struct Listener {
  Listener(const std::string& name, const std::shared_ptr<Transport>& network)
      : bus(test_bus(name), network) {
    bus.subscribe<graph_t>("GRAPH", Policy::kKeepAll, [this](const graph_t& m) {
      for (const graph_node_t& node : m.nodes) {
        T_map_base[node.id] = *from_message(node.T_map_base);
        (m.complete != 0 ? by_complete : by_change).insert(node.id);
      }
    });
  }
  template <class Condition>
  bool soon(Condition condition) {  // five minutes
    for (int i = 0; i < 60'000 && !condition(); ++i) {
      while (bus.handle(1)) {
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return condition();
  }
  Bus bus;
  std::map<std::int64_t, SE3> T_map_base;
  std::set<std::int64_t> by_complete, by_change;
};

SE3 truth(int i) {
  const double a = 2.0 * M_PI * i / kPerRound;
  return from_xyz_rpy(3.0 * std::sin(a), 3.0 * (1.0 - std::cos(a)), 0, 0, 0, a);
}

void drive(Bus* bus) {
  RobotModel robot;
  robot.has_camera = false;
  robot.has_lidar = true;
  bus->publish("ROBOT_MODEL", to_message(robot, 1000));
  for (int i = 0; i < kNodes; ++i) {
    lidar_node_t node{};
    node.utime = 1'000'000 + i * (20'000'000LL / kPerRound);
    node.id = i + 1;
    node.previous_id = i;
    node.T_odom_base = to_message(truth(i), node.utime);
    node.T_previous_base =
        to_message(i > 0 ? SE3(truth(i - 1).inverse() * truth(i)) : SE3::Identity(), node.utime);
    for (int k = 0; k < 36; k += 7) node.covariance[k] = 1e-6;
    bus->publish("LIDAR_NODE", node);
    if (i % 50 == 49) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void late_ones_have_it_all_and_a_restart_carries_the_same_nodes(bool renewed) {
  const auto network = std::make_shared<Transport>("memq://");
  const std::string journal =
      (std::filesystem::path(testing::TempDir()) / ("live_graph_" + std::to_string(getpid())))
          .string();
  std::filesystem::remove(journal);
  Listener world("world", network);
  std::string before;
  {
    Service service(journal, network);
    ASSERT_TRUE(world.soon([&] { return service.bus->status().state == status_t::RUNNING; }));
    drive(&world.bus);
    ASSERT_TRUE(world.soon([&] { return world.T_map_base.size() == kNodes; }));
    world.by_change.clear();
    EXPECT_TRUE(world.soon([&] { return world.by_change.size() == kNodes; })) << "in slices";

    Listener late("late", network);
    EXPECT_TRUE(late.soon([&] { return late.by_complete.size() == kNodes; })) << "at once";
    before = service.says();
    if (renewed) service.renew_journal();
  }
  EXPECT_EQ(before.find("(0 carried"), std::string::npos) << before;
  const auto T_before = world.T_map_base;
  world.by_complete.clear();
  Service again(journal, network);
  ASSERT_TRUE(world.soon([&] { return world.by_complete.size() == kNodes; }));
  world.soon([&] { return again.says() == before; });
  EXPECT_EQ(again.says(), before);
  for (const auto& [id, T] : T_before)
    EXPECT_LT(local(T, world.T_map_base.at(id)).norm(), 0.006) << id;
  std::filesystem::remove(journal);
}

TEST(LiveGraph, LateOnesHaveItAllAndARestartCarriesTheSameNodes) {
  late_ones_have_it_all_and_a_restart_carries_the_same_nodes(false);
}

TEST(LiveGraph, AndFromAJournalThatWasWrittenAnew) {
  late_ones_have_it_all_and_a_restart_carries_the_same_nodes(true);
}

}  // namespace
}  // namespace fusion_slam
