#include "libs/schema/guard.hpp"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "all_types.hpp"
#include "libs/schema/big_endian.hpp"
#include "tests/libs/schema/encode.hpp"
#include "tests/libs/schema/odd_tree.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

template <class Message>
const LcmType& type_of() {
  return *builtin_schema().find(static_cast<std::uint64_t>(Message::getHash()));
}

std::string reason(const LcmType& type, const std::vector<std::uint8_t>& bytes) {
  return check(type, bytes.data(), bytes.size()).value_or("");
}

// A tile of `size` bytes whose length member says `claimed`.
std::vector<std::uint8_t> tile_bytes(int size, std::int32_t claimed) {
  tile_t tile{};
  tile.size_bytes = size;
  tile.data.assign(static_cast<std::size_t>(size), 7);
  std::vector<std::uint8_t> bytes = encoded(tile);
  write_big_endian(static_cast<std::uint32_t>(claimed), 4,
                   bytes.data() + bytes.size() - static_cast<std::size_t>(size) - 4);
  return bytes;
}

TEST(Guard, accepts_what_encoders_write) {
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(120, 120)), "");
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(0, 0)), "");
  EXPECT_EQ(reason(*odd_schema().find("odd.tree_t"), encoded(odd_tree())), "");
#define FS_EMPTY(package, type) \
  EXPECT_EQ(reason(type_of<package::type>(), encoded(package::type{})), "");
  FS_FOR_EACH_TYPE(FS_EMPTY)
}

TEST(Guard, refuses_impossible_lengths_with_the_reason) {
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(120, 2'000'000'000)),
            "fusion_slam.tile_t.data: length 2000000000 needs more than the 120 bytes left");
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(120, 121)),
            "fusion_slam.tile_t.data: length 121 needs more than the 120 bytes left");
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(120, -1)),
            "fusion_slam.tile_t.data: length -1 is negative");
  EXPECT_EQ(reason(type_of<tile_t>(), tile_bytes(120, 119)),
            "fusion_slam.tile_t: 1 bytes are left over behind the last member");
}

TEST(Guard, refuses_foreign_short_and_truncated_messages) {
  const std::vector<std::uint8_t> whole = tile_bytes(40, 40);
  EXPECT_THAT(reason(type_of<status_t>(), whole), HasSubstr("fingerprint 0x"));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    EXPECT_NE(
        reason(type_of<tile_t>(), {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)}),
        "")
        << n;
  }
  EXPECT_EQ(reason(type_of<tile_t>(), {whole.begin(), whole.begin() + 10}),
            "fusion_slam.tile_t.utime: needs 8 bytes, 2 are left");
}

TEST(Guard, refuses_bad_strings) {
  command_t command{};
  command.target = "fuser";
  const std::vector<std::uint8_t> good = encoded(command);
  const std::size_t length_at = 8 + 8 + 8;
  const auto with = [&](std::uint32_t length, std::uint8_t last) {
    std::vector<std::uint8_t> bytes = good;
    write_big_endian(length, 4, bytes.data() + length_at);
    bytes[length_at + 4 + 5] = last;
    return reason(type_of<command_t>(), bytes);
  };
  EXPECT_EQ(with(6, 0), "");
  EXPECT_EQ(with(0, 0),
            "fusion_slam.command_t.target: string length 0 (with its NUL) is not positive");
  EXPECT_THAT(with(0xFFFFFFFF, 0), HasSubstr("string length -1"));
  EXPECT_EQ(with(6, 'x'), "fusion_slam.command_t.target: string of 6 bytes doesn't end with NUL");
  EXPECT_THAT(with(0x7FFFFFFF, 0), HasSubstr("needs more than"));
}

TEST(Guard, names_the_place_inside_nested_types) {
  loop_candidate_t candidate{};
  candidate.n_stages = 2;
  candidate.stages.resize(2);
  std::vector<std::uint8_t> bytes = encoded(candidate);
  bytes[bytes.size() - 1] = 'x';  // the NUL of the last reason
  EXPECT_EQ(
      reason(type_of<loop_candidate_t>(), bytes),
      "fusion_slam.loop_candidate_t.stages[1].reason: string of 1 bytes doesn't end with NUL");
}

TEST(Guard, bounds_elements_that_take_no_bytes) {
  odd::tree_t tree = odd_leaf(0, 0);
  std::vector<std::uint8_t> bytes = encoded(tree);
  const LcmType& type = *odd_schema().find("odd.tree_t");
  EXPECT_EQ(reason(type, bytes), "");
  write_big_endian(30000, 2, bytes.data() + 8);  // matrix[30000][0] and nothing[30000]
  EXPECT_THAT(reason(type, bytes),
              HasSubstr("odd.tree_t.matrix: length 30000 x 0 is more than a message of this size"));
}

TEST(Guard, bounds_the_depth_of_types_that_hold_themselves) {
  odd::tree_t tree = odd_leaf(0, 0);
  for (int i = 0; i < 100; ++i) {
    odd::tree_t outer = odd_leaf(0, 0);
    outer.n_children = 1;
    outer.children.push_back(tree);
    tree = outer;
  }
  EXPECT_THAT(reason(*odd_schema().find("odd.tree_t"), encoded(tree)),
              HasSubstr("nested more than 64 deep"));
}

// What the guard lets through, the generated decoder reads to the last byte.
template <class Message>
void expect_decodes_when_accepted(const std::vector<std::uint8_t>& bytes, int* n_accepted) {
  if (check(type_of<Message>(), bytes.data(), bytes.size())) return;
  Message message;
  ASSERT_EQ(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  ++*n_accepted;
}

TEST(Guard, agrees_with_generated_decoders_on_random_damage) {
  std::mt19937 random(1);
  int n_accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    keyframe_t keyframe{};
    keyframe.n = 3;
    for (auto* values : {&keyframe.u_px, &keyframe.v_px, &keyframe.depth_m, &keyframe.angle_rad,
                         &keyframe.depth_sigma_m})
      values->resize(3);
    keyframe.octave.resize(3);
    keyframe.landmark_id.resize(3);
    std::vector<std::uint8_t> bytes = encoded(keyframe);
    for (int i = 0; i < 2; ++i)
      bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random() % 8);
    expect_decodes_when_accepted<keyframe_t>(bytes, &n_accepted);

    status_t status{};
    status.n_channels = 2;
    status.channels.resize(2);
    bytes = encoded(status);
    bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random() % 4);
    expect_decodes_when_accepted<status_t>(bytes, &n_accepted);
  }
  EXPECT_GT(n_accepted, 1000);
}

TEST(Peek, finds_utime_and_seq_without_decoding) {
  tile_t tile{};
  tile.utime = -5;
  tile.seq = 77;
  std::vector<std::uint8_t> bytes = encoded(tile);
  EXPECT_EQ(peek_utime(bytes.data(), bytes.size()), -5);
  EXPECT_EQ(peek_seq(bytes.data(), bytes.size()), 77);
  EXPECT_EQ(peek_type(bytes.data(), bytes.size()), &type_of<tile_t>());
  EXPECT_EQ(peek_utime(bytes.data(), 15), std::nullopt);
  EXPECT_EQ(peek_seq(bytes.data(), 23), std::nullopt);

  bot_core::pose_t pose{};
  pose.utime = 9;
  bytes = encoded(pose);
  EXPECT_EQ(peek_utime(bytes.data(), bytes.size()), 9);
  EXPECT_EQ(peek_seq(bytes.data(), bytes.size()), std::nullopt);
  bytes[0] ^= 1;
  EXPECT_EQ(peek_utime(bytes.data(), bytes.size()), std::nullopt);
  EXPECT_EQ(peek_type(bytes.data(), 7), nullptr);
}

}  // namespace
}  // namespace fusion_slam
