// The fingerprints of types that others defined, calculated from their documented field lists by
// LCM's documented rule, independently of the .lcm files and of libs/schema.
#include <gtest/gtest.h>

#include "all_types.hpp"

namespace {

// Builds up the hash of one struct, member by member.
class Hand {
 public:
  // One value.
  Hand& one(const char* type, const char* name) { return member(type, name).dimensions(0); }
  // name[size], size being a number: mode 0.
  Hand& fixed(const char* type, const char* name, const char* size) {
    return member(type, name).dimensions(1).character(0).text(size);
  }
  // name[size], size being a member: mode 1.
  Hand& variable(const char* type, const char* name, const char* size) {
    return member(type, name).dimensions(1).character(1).text(size);
  }
  // The same for members of a struct's type: their type's name doesn't count, their type's hash is
  // added.
  Hand& nested(const Hand& type, const char* name) { return text(name).dimensions(0).add(type); }
  Hand& nested_variable(const Hand& type, const char* name, const char* size) {
    return text(name).dimensions(1).character(1).text(size).add(type);
  }

  std::int64_t value() const {
    const std::uint64_t sum = static_cast<std::uint64_t>(hash_) + nested_;
    return static_cast<std::int64_t>((sum << 1) + (sum >> 63));
  }

 private:
  Hand& member(const char* type, const char* name) { return text(name).text(type); }
  Hand& dimensions(int n) { return character(n); }
  Hand& add(const Hand& type) {
    nested_ += static_cast<std::uint64_t>(type.value());
    return *this;
  }
  Hand& text(const std::string& text) {
    character(static_cast<int>(text.size()));
    for (const char c : text) character(c);
    return *this;
  }
  Hand& character(int c) {
    const auto shifted = static_cast<std::int64_t>(static_cast<std::uint64_t>(hash_) << 8);
    hash_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(shifted ^ (hash_ >> 55)) +
                                      static_cast<std::uint64_t>(c));
    return *this;
  }

  std::int64_t hash_ = 0x12345678;
  std::uint64_t nested_ = 0;
};

TEST(HandCalculation, of_bot_core) {
  const Hand lidar = Hand()
                         .one("int64_t", "utime")
                         .one("int32_t", "nranges")
                         .variable("float", "ranges", "nranges")
                         .one("int32_t", "nintensities")
                         .variable("float", "intensities", "nintensities")
                         .one("float", "rad0")
                         .one("float", "radstep");
  EXPECT_EQ(bot_core::planar_lidar_t::getHash(), lidar.value());

  const Hand metadata =
      Hand().one("string", "key").one("int32_t", "n").variable("byte", "value", "n");
  EXPECT_EQ(bot_core::image_metadata_t::getHash(), metadata.value());

  const Hand image = Hand()
                         .one("int64_t", "utime")
                         .one("int32_t", "width")
                         .one("int32_t", "height")
                         .one("int32_t", "row_stride")
                         .one("int32_t", "pixelformat")
                         .one("int32_t", "size")
                         .variable("byte", "data", "size")
                         .one("int32_t", "nmetadata")
                         .nested_variable(metadata, "metadata", "nmetadata");
  EXPECT_EQ(bot_core::image_t::getHash(), image.value());

  const Hand images = Hand()
                          .one("int64_t", "utime")
                          .one("int32_t", "n_images")
                          .variable("int16_t", "image_types", "n_images")
                          .nested_variable(image, "images", "n_images");
  EXPECT_EQ(bot_core::images_t::getHash(), images.value());

  const Hand pose = Hand()
                        .one("int64_t", "utime")
                        .fixed("double", "pos", "3")
                        .fixed("double", "vel", "3")
                        .fixed("double", "orientation", "4")
                        .fixed("double", "rotation_rate", "3")
                        .fixed("double", "accel", "3");
  EXPECT_EQ(bot_core::pose_t::getHash(), pose.value());

  const Hand transform =
      Hand().one("int64_t", "utime").fixed("double", "trans", "3").fixed("double", "quat", "4");
  EXPECT_EQ(bot_core::rigid_transform_t::getHash(), transform.value());
}

TEST(HandCalculation, of_procman_lcm) {
  const Hand cmd = Hand()
                       .one("string", "command_id")
                       .one("string", "exec_str")
                       .one("string", "group")
                       .one("boolean", "auto_respawn")
                       .one("int8_t", "stop_signal")
                       .one("float", "stop_time_allowed");
  EXPECT_EQ(procman_lcm::cmd_t::getHash(), cmd.value());

  const Hand desired =
      Hand().nested(cmd, "cmd").one("int32_t", "desired_runid").one("boolean", "force_quit");
  EXPECT_EQ(procman_lcm::cmd_desired_t::getHash(), desired.value());

  const Hand status = Hand()
                          .nested(cmd, "cmd")
                          .one("int32_t", "pid")
                          .one("int32_t", "actual_runid")
                          .one("int32_t", "exit_code")
                          .one("float", "cpu_usage")
                          .one("int64_t", "mem_vsize_bytes")
                          .one("int64_t", "mem_rss_bytes");
  EXPECT_EQ(procman_lcm::cmd_status_t::getHash(), status.value());

  const Hand info = Hand()
                        .one("int64_t", "utime")
                        .one("string", "deputy_id")
                        .one("float", "cpu_load")
                        .one("int64_t", "phys_mem_total_bytes")
                        .one("int64_t", "phys_mem_free_bytes")
                        .one("int64_t", "swap_total_bytes")
                        .one("int64_t", "swap_free_bytes")
                        .one("int32_t", "ncmds")
                        .nested_variable(status, "cmds", "ncmds");
  EXPECT_EQ(procman_lcm::deputy_info_t::getHash(), info.value());

  const Hand orders = Hand()
                          .one("int64_t", "utime")
                          .one("string", "deputy_id")
                          .one("string", "sheriff_id")
                          .one("int32_t", "ncmds")
                          .nested_variable(desired, "cmds", "ncmds");
  EXPECT_EQ(procman_lcm::orders_t::getHash(), orders.value());

  const Hand discovery =
      Hand().one("int64_t", "utime").one("string", "transmitter_id").one("int64_t", "nonce");
  EXPECT_EQ(procman_lcm::discovery_t::getHash(), discovery.value());

  const Hand output = Hand()
                          .one("int64_t", "utime")
                          .one("string", "deputy_id")
                          .one("int16_t", "num_commands")
                          .variable("string", "command_ids", "num_commands")
                          .variable("string", "text", "num_commands");
  EXPECT_EQ(procman_lcm::output_t::getHash(), output.value());
}

}  // namespace
