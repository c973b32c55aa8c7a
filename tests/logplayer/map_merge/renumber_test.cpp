#include "logplayer/map_merge/renumber.hpp"

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "tests/libs/map_directory/session_log.hpp"

namespace fusion_slam {
namespace {

template <class Message>
LogEvent event_of(const char* channel, const Message& message) {
  LogEvent event;
  event.timestamp_us = 5;
  event.channel = channel;
  event.data.resize(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(event.data.data(), 0, static_cast<int>(event.data.size()));
  return event;
}

Offsets offsets() {
  Offsets offsets;
  offsets.keyframe = 100;
  offsets.lidar_node = 1000;
  offsets.landmark = 10'000;
  offsets.time_us = 7;
  offsets.seq = {{"KEYFRAME", 50}, {"CONSTRAINT", 60}};
  return offsets;
}

TEST(Renumber, Keyframes) {
  keyframe_t m{};
  m.utime = 1, m.seq = 2, m.id = 3, m.previous_id = 0;
  m.n = 2;
  m.u_px = m.v_px = m.depth_m = m.angle_rad = m.depth_sigma_m = {0, 0};
  m.octave = {0, 0};
  m.landmark_id = {4, 0};
  m.n_refined = 1;
  m.refined_id = {2};
  m.T_previous_refined.resize(1);
  const LogEvent moved = renumbered(event_of("KEYFRAME", m), offsets());
  EXPECT_EQ(moved.timestamp_us, 12);
  const auto n = decode<keyframe_t>(moved);
  ASSERT_TRUE(n);
  EXPECT_EQ(n->utime, 8);
  EXPECT_EQ(n->seq, 52);
  EXPECT_EQ(n->id, 103);
  EXPECT_EQ(n->previous_id, 0);  // none stays none
  EXPECT_EQ(n->landmark_id, (std::vector<std::int64_t>{10'004, 0}));
  EXPECT_EQ(n->refined_id, std::vector<std::int64_t>{102});
}

TEST(Renumber, NodesPosesConstraintsTiles) {
  const auto node =
      decode<lidar_node_t>(renumbered(event_of("LIDAR_NODE", node_of(2, 0)), offsets()));
  ASSERT_TRUE(node);
  EXPECT_EQ(node->id, 1002);
  EXPECT_EQ(node->previous_id, 1001);
  const auto pose =
      decode<pose_estimate_t>(renumbered(event_of("LIDAR_POSE", pose_of(2)), offsets()));
  ASSERT_TRUE(pose);
  EXPECT_EQ(pose->reference_id, 1002);
  constraint_t c{};
  c.from_kind = graph_node_t::KEYFRAME, c.from_id = 1;
  c.to_kind = graph_node_t::LIDAR, c.to_id = 2;
  const auto constraint = decode<constraint_t>(renumbered(event_of("CONSTRAINT", c), offsets()));
  ASSERT_TRUE(constraint);
  EXPECT_EQ(constraint->from_id, 101);
  EXPECT_EQ(constraint->to_id, 1002);
  EXPECT_EQ(constraint->seq, 60);
  const auto tile = decode<tile_t>(
      renumbered(event_of("SUBMAP", to_message(grid_tile({3, 0, 0, 0}, 1, 0.5))), offsets()));
  ASSERT_TRUE(tile);
  EXPECT_EQ(tile->submap_id, 1003);
  EXPECT_EQ(offsets().moved({NodeKind::kLidar, 5}).id, 1005);
  EXPECT_EQ(offsets().moved({NodeKind::kKeyframe, 5}).id, 105);
}

TEST(Renumber, LargestIdsAndNumbers) {
  Offsets largest;
  note_largest(event_of("LIDAR_NODE", node_of(7, 0)), &largest);
  note_largest(event_of("LIDAR_NODE", node_of(3, 0)), &largest);
  EXPECT_EQ(largest.lidar_node, 7);
  EXPECT_EQ(largest.keyframe, 0);
  EXPECT_EQ(largest.seq.at("LIDAR_NODE"), 7);
  EXPECT_EQ(largest.time_us, 0);
}

}  // namespace
}  // namespace fusion_slam
