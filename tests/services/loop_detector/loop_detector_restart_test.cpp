// loop_detector is killed and started again: its journal, written anew, gives it what it knew.
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "fusion_slam/status_t.hpp"
#include "libs/bus/transport.hpp"
#include "libs/journal/journal.hpp"
#include "libs/messages/models.hpp"
#include "services/loop_detector/loop_detector_process.hpp"
#include "tests/services/loop_detector/keyframe_message.hpp"
#include "tests/services/loop_detector/made_up_places.hpp"
#include "tests/support/test_bus.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

// One life of the world: the models, keyframes, and what the loop detector says of them.
class World {
 public:
  World() {
    fs::remove(journal_);
    robot_.has_camera = true;
    robot_.has_lidar = false;
    robot_.planar = false;
    bus_.subscribe<loop_candidate_t>(
        "LOOP_CANDIDATE", Policy::kKeepAll,
        [this](const loop_candidate_t& m) { found_[m.to_id] = m.from_id; });
    start();
    bus_.publish("CAMERA_MODEL", to_message(camera_, 1000));
    bus_.publish("ROBOT_MODEL", to_message(robot_, 1000));
    EXPECT_TRUE(until([&] { return handled("CAMERA_MODEL") > 0 && handled("ROBOT_MODEL") > 0; }));
  }
  ~World() {
    stop();
    fs::remove(journal_);
  }
  // Keyframe `id` looks at a place of that number; all stand where they are believed to.
  void see(int id, int place) {
    LoopKeyframe keyframe =
        keyframe_at(id, see_place(make_place(static_cast<unsigned>(place), 200), camera_,
                                  SE3::Identity(), static_cast<unsigned>(id)));
    keyframe_t message = message_of(keyframe);
    message.previous_id = id - 1;
    to_message(Matrix6d(Matrix6d::Identity() * 1e-6), message.covariance);
    bus_.publish("KEYFRAME", message);
    ++seen_;
    EXPECT_TRUE(until([&] { return handled("KEYFRAME") >= seen_; }));
  }
  void reset(int id) {  // when this keyframe was the newest
    command_t command{};
    command.utime = id * 1'000'000;
    command.verb = "reset";
    bus_.publish("COMMAND", command);
    EXPECT_TRUE(until([&] { return handled("COMMAND") >= 1; }));
  }
  void start() {
    BusOptions options = test_bus("loop_detector");
    options.journal = journal_;
    detector_ = std::make_unique<Bus>(options, network_);
    process_ = std::make_unique<LoopDetectorProcess>(*detector_);
    seen_ = 0;
    thread_ = std::thread([this] { detector_->run(); });
    EXPECT_TRUE(until([&] { return detector_->status().state == status_t::RUNNING; }));
  }
  void stop() {
    if (!detector_) return;
    detector_->stop();
    if (thread_.joinable()) thread_.join();
    process_.reset();
    detector_.reset();
    while (bus_.handle(20)) {
    }
  }
  void renew_journal() {
    detector_->stop();
    thread_.join();
    EXPECT_TRUE(detector_->renew_journal());
  }
  // The keyframe `id`, which sees that place, is taken for one that looks like keyframe `from`.
  bool finds(int id, int place, int from) {
    see(id, place);
    return until([&] { return found_.count(id) > 0; }) && found_.at(id) == from;
  }
  bool finds_nothing(int id, int place) {
    see(id, place);
    while (bus_.handle(50)) {
    }
    return found_.count(id) == 0;
  }
  int states_in_journal() const {
    int n = 0;
    read_journal(journal_, [&n](const LogEvent& event) { n += event.channel == "LOOP_STATE"; });
    return n;
  }
  std::string state() const { return detector_->status().state_text; }
  std::string error() const { return detector_->status().last_error; }

 private:
  std::int64_t handled(const std::string& channel) const {
    const auto all = detector_->processed();
    const auto it = all.find(channel);
    return it == all.end() ? 0 : it->second;
  }
  bool until(const std::function<bool()>& is_so) {
    for (int i = 0; i < 6000; ++i) {
      if (is_so()) return true;
      bus_.handle(5);
    }
    return false;
  }

  fs::path journal_ =
      fs::temp_directory_path() / ("loop_detector_restart." + std::to_string(getpid()) + ".lcmlog");
  CameraModel camera_;
  RobotModel robot_;
  std::shared_ptr<Transport> network_ = std::make_shared<Transport>("memq://");
  Bus bus_{test_bus("visual_odometry", Mode::kThroughput), network_};
  std::unique_ptr<Bus> detector_;
  std::unique_ptr<LoopDetectorProcess> process_;
  std::thread thread_;
  std::int64_t seen_ = 0;
  std::map<std::int64_t, std::int64_t> found_;
};

constexpr int kPlaces = 25;

void drive(World* world, int n = kPlaces) {
  for (int id = 1; id <= n; ++id) world->see(id, id);
}

TEST(LoopDetectorRestart, APlaceOfBeforeIsKnownAgain) {
  for (const int lives : {1, 2, 3}) {
    World world;
    drive(&world);
    for (int i = 1; i < lives; ++i) {
      world.renew_journal();  // the second time by a process that has only read it
      world.stop();
      world.start();
    }
    EXPECT_TRUE(world.finds(kPlaces + 1, 3, 3)) << lives;
    EXPECT_EQ(world.state().substr(0, 12), "26 keyframes");
    EXPECT_EQ(world.error(), "");
  }
}

TEST(LoopDetectorRestart, WhatCameAfterTheJournalWasWrittenAnewIsKnownToo) {
  World world;
  drive(&world);
  world.renew_journal();
  world.stop();
  world.start();
  for (int id = kPlaces + 1; id <= 2 * kPlaces; ++id) world.see(id, id);
  world.stop();
  world.start();
  EXPECT_TRUE(world.finds(2 * kPlaces + 1, 3, 3));
  EXPECT_TRUE(world.finds(2 * kPlaces + 2, kPlaces + 5, kPlaces + 5));
}

// Long enough for a state to be written now and then.
TEST(LoopDetectorRestart, ALongDriveIsKnownFromItsStates) {
  World world;
  drive(&world, 270);
  world.stop();
  EXPECT_EQ(world.states_in_journal(), 4) << "one every 60 keyframes";
  world.start();
  EXPECT_TRUE(world.finds(271, 3, 3));
  EXPECT_TRUE(world.finds(272, 255, 255)) << "what came after the state";
  EXPECT_EQ(world.state().substr(0, 13), "272 keyframes");
}

TEST(LoopDetectorRestart, AfterAResetThePlacesOfBeforeAreForgotten) {
  for (const bool renewed : {false, true}) {
    World world;
    drive(&world);
    world.reset(kPlaces);
    for (int id = kPlaces + 1; id <= 2 * kPlaces; ++id) world.see(id, id);
    if (renewed) world.renew_journal();
    world.stop();
    world.start();
    EXPECT_TRUE(world.finds_nothing(2 * kPlaces + 1, 3));
    EXPECT_TRUE(world.finds(2 * kPlaces + 2, kPlaces + 5, kPlaces + 5));
    EXPECT_EQ(world.error(), "");
  }
}

}  // namespace
}  // namespace fusion_slam
