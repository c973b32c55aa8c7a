#include "viz/web/session_replay.hpp"

#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "libs/eventlog/writer.hpp"
#include "libs/grid/fused_tile.hpp"
#include "libs/messages/convert.hpp"
#include "libs/octree/octomap_tile.hpp"

namespace fusion_slam {
namespace {

template <class Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

// 20 s of a session: ODOMETRY at 10 Hz, tiles that change, POSE, STATUS.
class SessionReplayTest : public ::testing::Test {
 protected:
  SessionReplayTest() {
    std::string folder = ::testing::TempDir() + "/session_replay_XXXXXX";
    directory_ = mkdtemp(folder.data());
    log_ = directory_ / "session.lcmlog";
    std::mt19937 random(1);
    LogWriter writer(log_);
    for (int i = 0; i < 200; ++i) {
      const std::int64_t utime_us = 1'000'000'000 + i * 100'000;
      const auto write = [&](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
        writer.write(5'000'000 + i, channel, bytes);  // logged faster than real time
        events_.push_back({0, 0, utime_us, channel, bytes});
      };
      write("ODOMETRY", encoded(to_pose_message(SE3::Identity(), utime_us)));
      pose_estimate_t pose{};
      pose.utime = utime_us;
      pose.seq = i + 1;
      pose.T_frame_base = to_message(make_pose({0.1 * i, 0.0, 0.0}, 1.0, 0.0, 0.0, 0.0), utime_us);
      pose.T_reference_base = pose.T_frame_base;
      write("POSE", encoded(pose));
      FusedCells cells;
      cells.probability[random() % 4096] = 255;
      const TileKey key{0, static_cast<int>(random() % 4), 0, 0};
      write("GRID_FUSED",
            encoded(to_message(encode_fused_tile(key, cells, 0.05, i + 1, utime_us))));
      VoxelCells voxels;
      voxels.fill(kUnknownVoxel);
      voxels[random() % voxels.size()] = 20;
      write("OCTOMAP",
            encoded(to_message(encode_octomap_tile(key, voxels, 0.05, i + 1, utime_us))));
    }
    writer.close();
  }
  ~SessionReplayTest() override { std::filesystem::remove_all(directory_); }

  // What the map shows when every event up to a moment is applied, one after another.
  std::map<std::string, std::string> slow_map(std::int64_t utime_us) const {
    ItemStore store;
    ViewerState state(store);
    for (const LogEvent& event : events_)
      if (event.timestamp_us <= utime_us) apply_event(event, state);
    return map_of(store);
  }
  static std::map<std::string, std::string> map_of(const ItemStore& store) {
    std::map<std::string, std::string> map;
    Cursor cursor;
    const auto wanted = TopicSet()
                            .set(static_cast<std::size_t>(Topic::kGridFused))
                            .set(static_cast<std::size_t>(Topic::kOctomap))
                            .set(static_cast<std::size_t>(Topic::kPose));
    for (const Item& item : store.next(&cursor, wanted, 1 << 30))
      if (item.payload)
        map[std::string(1, static_cast<char>('a' + static_cast<int>(item.topic))) + item.key] =
            *item.payload;
    return map;
  }
  static bool go_on(double) { return true; }

  std::filesystem::path directory_;
  std::filesystem::path log_;
  std::vector<LogEvent> events_;
};

TEST_F(SessionReplayTest, AnyMomentIsWhatAllEventsUntilThenMake) {
  SessionReplay session(log_, go_on);
  EXPECT_EQ(session.first_us(), 1'000'000'000);
  EXPECT_EQ(session.last_us(), 1'019'900'000);
  ItemStore store;
  ViewerState state(store);
  for (const double t : {19.9, 3.0, 3.1, 12.0, 11.9, 0.0, 19.9}) {
    const auto utime_us = session.first_us() + static_cast<std::int64_t>(1e6 * t);
    session.go_to(utime_us, state);
    EXPECT_EQ(map_of(store), slow_map(utime_us)) << t << " s";
  }
}

TEST_F(SessionReplayTest, AJumpLeavesOutWhatIsReplaced) {
  SessionReplay session(log_, go_on);
  ItemStore store;
  ViewerState state(store);
  session.go_to(session.last_us(), state);
  EXPECT_LT(session.applied(), session.events() - 200);
}

TEST_F(SessionReplayTest, DamageIsSaidAndTheRestIsShown) {
  const auto size = std::filesystem::file_size(log_);
  std::filesystem::resize_file(log_, size - 10);
  SessionReplay session(log_, go_on);
  EXPECT_FALSE(session.damage().empty());
  EXPECT_EQ(session.events(), events_.size() - 1);
}

TEST_F(SessionReplayTest, AFileWithNothingToShowIsRefusedWithAReason) {
  const auto other = directory_ / "other.lcm";
  {
    LogWriter writer(other);
    writer.write(1, "SOMETHING_ELSE", {1, 2, 3, 4, 5, 6, 7, 8, 9});
    writer.close();
  }
  EXPECT_THROW(SessionReplay(other, go_on), std::runtime_error);
}

TEST_F(SessionReplayTest, DamagedMessagesAreLeftOut) {
  LogEvent event = events_[0];
  event.data.resize(event.data.size() - 3);
  ItemStore store;
  ViewerState state(store);
  EXPECT_FALSE(apply_event(event, state));
  event.channel = "KEYFRAME";  // of another type
  EXPECT_FALSE(apply_event(event, state));
}

}  // namespace
}  // namespace fusion_slam
