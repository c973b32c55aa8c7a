#include "libs/schema/walk.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "bot_core/planar_lidar_t.hpp"
#include "tests/libs/schema/encode.hpp"
#include "tests/libs/schema/odd_tree.hpp"

namespace fusion_slam {
namespace {

struct Seen {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, std::string> strings;
  std::vector<std::string> order;
};

Seen walked(const LcmType& type, const std::vector<std::uint8_t>& bytes) {
  Seen seen;
  const auto error = walk(type, bytes.data(), bytes.size(), [&](const LcmField& field) {
    seen.order.push_back(field.path);
    if (field.member->primitive == LcmPrimitive::kString) {
      seen.strings[field.path] = string_value(field);
      return;
    }
    std::vector<double>& values = seen.numbers[field.path];
    for (std::int64_t i = 0; i < field.count; ++i) values.push_back(real_value(field, i));
  });
  EXPECT_EQ(error, std::nullopt);
  return seen;
}

TEST(Walk, yields_each_run_of_values_in_the_messages_order) {
  const std::vector<std::uint8_t> bytes = encoded(odd_tree());
  Seen seen = walked(*odd_schema().find("odd.tree_t"), bytes);
  EXPECT_EQ(seen.order[0], "n");
  EXPECT_EQ(seen.order[2], "matrix[0]");
  EXPECT_EQ(seen.numbers["matrix[1]"], std::vector<double>(3, 1.5));
  EXPECT_EQ(seen.numbers["cube[1][1]"], std::vector<double>(3, -2.0));
  EXPECT_EQ(seen.strings["inner[2][0].name"], "first");
  EXPECT_EQ(seen.strings["inner[0][1].words[1]"], "word");
  EXPECT_EQ(seen.numbers["inner[0][1].last"], std::vector<double>{-3});
  EXPECT_EQ(seen.numbers["hex_sized"], std::vector<double>(4, 200));  // a byte has no sign
  EXPECT_EQ(seen.numbers["children[1].n"], std::vector<double>{3});
  EXPECT_EQ(seen.numbers["children[1].matrix[2]"], std::vector<double>(2, 1.5));
}

TEST(Walk, reads_the_numbers_that_were_written) {
  bot_core::planar_lidar_t scan{};
  scan.utime = std::numeric_limits<std::int64_t>::min();
  scan.nranges = 3;
  scan.ranges = {0.25F, -1e30F, std::numeric_limits<float>::infinity()};
  scan.radstep = -0.5F;
  const LcmType& type = *builtin_schema().find("bot_core.planar_lidar_t");
  std::int64_t utime = 0;
  std::vector<double> ranges;
  double radstep = 0;
  const std::vector<std::uint8_t> bytes = encoded(scan);
  EXPECT_EQ(walk(type, bytes.data(), bytes.size(),
                 [&](const LcmField& field) {
                   if (field.path == "utime") utime = integer_value(field);
                   if (field.path == "radstep") radstep = real_value(field);
                   if (field.path != "ranges") return;
                   EXPECT_EQ(field.size_bytes, 12U);
                   for (std::int64_t i = 0; i < field.count; ++i)
                     ranges.push_back(real_value(field, i));
                 }),
            std::nullopt);
  EXPECT_EQ(utime, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(ranges, (std::vector<double>{0.25, static_cast<double>(-1e30F), INFINITY}));
  EXPECT_EQ(radstep, -0.5);
}

}  // namespace
}  // namespace fusion_slam
