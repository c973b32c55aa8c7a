// dense_mapper is killed and started again: its journal gives it the map, and images only of what
// is open.
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "libs/bus/transport.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/clock/clock.hpp"
#include "libs/journal/journal.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "services/dense_mapper/dense_mapper_process.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using Content = std::map<TileKey, std::vector<std::uint8_t>>;

constexpr int kKeyframes = 13;

// One life of the world: models, keyframes, graph, and what dense_mapper says of them.
class World {
 public:
  explicit World(const fs::path& journal) : journal_(journal) {
    robot_.T_base_camera.linear() = optical_to_body();
    robot_.T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.35);
    start();
    bus_.publish("CAMERA_MODEL", to_message(camera_, 1000));
    bus_.publish("ROBOT_MODEL", to_message(robot_, 1000));
    EXPECT_TRUE(until([&] { return handled("CAMERA_MODEL") > 0 && handled("ROBOT_MODEL") > 0; }));
  }
  ~World() { kill(); }

  void see(int id) {
    keyframe_image_t image{};
    image.utime = id * 1'000'000;
    image.id = id;
    image.images = to_message(render_room(pose(id) * robot_.T_base_camera, camera_, image.utime));
    bus_.publish("KEYFRAME_IMAGE", image);
    ++images_;
    EXPECT_TRUE(until([&] { return handled("KEYFRAME_IMAGE") >= images_; }));
    tell_graph(id);
  }
  void tell_graph(int n) {
    graph_t graph{};
    graph.utime = n * 1'000'000;
    graph.n_parts = 1;
    graph.complete = 1;
    for (int id = 1; id <= n; ++id) {
      graph.nodes.emplace_back();
      graph.nodes.back().kind = graph_node_t::KEYFRAME;
      graph.nodes.back().id = id;
      graph.nodes.back().utime = id * 1'000'000;
      graph.nodes.back().T_map_base = to_message(pose(id), id * 1'000'000);
    }
    graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
    bus_.publish("GRAPH", graph);
    ++graphs_;
    EXPECT_TRUE(until([&] { return handled("GRAPH") >= graphs_; }));
  }
  void finish() {
    command_t command{};
    command.utime = 1'000'000'000;
    command.verb = "finish";
    bus_.publish("COMMAND", command);
    EXPECT_TRUE(until([&] { return handled("COMMAND") >= 1; }));
  }
  // What was composed while the journal was read is offered by the index, which comes once a
  // second.
  bool becomes(const std::map<std::string, Content>& expected) {
    return until([&] { return maps() == expected; });
  }
  void kill() {
    if (!mapper_) return;
    mapper_->stop();
    if (thread_.joinable()) thread_.join();
    process_.reset();
    mapper_.reset();
    while (bus_.handle(20)) {
    }
  }
  void start() {
    // Revisions begin with the second: those of the next life must be newer.
    while (wall_us() / 1'000'000 <= started_s_)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    started_s_ = wall_us() / 1'000'000;
    BusOptions options = test_bus("dense_mapper");
    options.journal = journal_;
    mapper_ = std::make_unique<Bus>(options, network_);
    process_ = std::make_unique<DenseMapperProcess>(*mapper_);
    images_ = graphs_ = 0;
    octomap_.clear(), cloud_.clear(), grid_.clear();
    thread_ = std::thread([this] { mapper_->run(); });
    EXPECT_TRUE(until([&] { return mapper_->status().state == status_t::RUNNING; }));
  }
  void renew_journal() {
    mapper_->stop();
    thread_.join();
    EXPECT_TRUE(mapper_->renew_journal());
  }
  std::string state() const { return mapper_->status().state_text; }
  std::string error() const { return mapper_->status().last_error; }
  using Maps = std::map<std::string, Content>;
  void listen() {
    while (bus_.handle(100)) {
    }
  }
  Maps maps() const { return {{"OCTOMAP", octomap_}, {"CLOUD", cloud_}, {"GRID_VISUAL", grid_}}; }

 private:
  static SE3 pose(int id) {
    return from_xyz_rpy(0.02 * (id % 5), 0.03 * (id % 3), 0.0, 0.0, 0.0, 0.06 * (id % 4));
  }
  std::int64_t handled(const std::string& channel) const {
    const auto counts = mapper_->processed();
    const auto it = counts.find(channel);
    return it == counts.end() ? 0 : it->second;
  }
  bool until(const std::function<bool()>& done) {
    for (int i = 0; i < 120'000 && !done(); ++i) bus_.handle(1);
    return done();
  }
  void keep(const Tile& tile, Content* content) {
    if (tile.encoding == TileEncoding::kEmpty)
      content->erase(tile.key);
    else
      (*content)[tile.key] = tile.data;
  }

  fs::path journal_;
  RobotModel robot_;
  CameraModel camera_ = small_camera();
  std::shared_ptr<Transport> network_ = std::make_shared<Transport>("memq://");
  Bus bus_{test_bus("world", Mode::kThroughput), network_};
  Content octomap_, cloud_, grid_;
  TileReceiver octomap_in_{bus_, "OCTOMAP", [this](const Tile& t) { keep(t, &octomap_); }};
  TileReceiver cloud_in_{bus_, "CLOUD", [this](const Tile& t) { keep(t, &cloud_); }};
  TileReceiver grid_in_{bus_, "GRID_VISUAL", [this](const Tile& t) { keep(t, &grid_); }};
  std::unique_ptr<Bus> mapper_;
  std::unique_ptr<DenseMapperProcess> process_;
  std::thread thread_;
  std::int64_t started_s_ = 0;
  std::int64_t images_ = 0;
  std::int64_t graphs_ = 0;
};

class DenseMapperRestart : public testing::Test {
 protected:
  void SetUp() override { remove(); }
  void TearDown() override { remove(); }
  void remove() const {
    fs::remove(journal_);
    fs::remove(journal_.string() + "_undisturbed");
  }
  std::map<std::string, Content> undisturbed() const {
    World world(journal_.string() + "_undisturbed");
    for (int id = 1; id <= kKeyframes; ++id) world.see(id);
    world.finish();
    World::Maps before;
    while (before != world.maps()) {  // until nothing comes any more
      before = world.maps();
      world.listen();
    }
    return before;
  }
  std::map<std::string, int> records() const {
    std::map<std::string, int> n;
    read_journal(journal_, [&](const LogEvent& event) { ++n[event.channel]; });
    return n;
  }
  fs::path journal_ =
      fs::path(testing::TempDir()) / ("dense_mapper_journal_" + std::to_string(getpid()));
};

TEST_F(DenseMapperRestart, TheMapIsWhatItWouldHaveBeenByteForByte) {
  const auto expected = undisturbed();
  ASSERT_FALSE(expected.at("OCTOMAP").empty());
  ASSERT_FALSE(expected.at("GRID_VISUAL").empty());
  for (const bool renewed : {false, true}) {
    remove();
    World world(journal_);
    for (int id = 1; id <= 8; ++id) world.see(id);
    if (renewed) world.renew_journal();
    world.kill();
    if (renewed) {
      EXPECT_EQ(records()["KEYFRAME_IMAGE"], 3) << "of the open submap";
      EXPECT_EQ(records()["CAMERA_MODEL"], 1);
    }
    world.start();
    world.tell_graph(8);
    EXPECT_EQ(world.state().substr(0, 18), "8 keyframes mapped") << renewed;
    for (int id = 9; id <= kKeyframes; ++id) world.see(id);
    EXPECT_EQ(world.error(), "") << renewed;
    world.finish();
    EXPECT_TRUE(world.becomes(expected)) << renewed;
  }
}

}  // namespace
}  // namespace fusion_slam
