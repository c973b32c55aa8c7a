#include "libs/schema/parser.hpp"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "odd/empty_t.hpp"
#include "odd/inner_t.hpp"
#include "tests/libs/schema/odd_tree.hpp"

namespace fusion_slam {

const Schema& odd_schema() {
  static const Schema schema = [] {
    std::ostringstream text;
    text << std::ifstream(FS_ODD_LCM).rdbuf();
    return Schema(LcmFiles{{"odd.lcm", text.str()}});
  }();
  return schema;
}

namespace {

std::string error_of(const std::string& text) {
  try {
    Schema schema(LcmFiles{{"x.lcm", text}});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(Parser, reads_everything_the_grammar_has) {
  const LcmType* tree = odd_schema().find("odd.tree_t");
  ASSERT_NE(tree, nullptr);
  ASSERT_EQ(tree->members.size(), 9U);
  EXPECT_EQ(tree->members[1].name, "m");
  EXPECT_EQ(tree->members[1].primitive, LcmPrimitive::kInt16);
  ASSERT_EQ(tree->members[3].dimensions.size(), 3U);
  EXPECT_EQ(tree->members[3].dimensions[1].fixed_count, 2);
  EXPECT_EQ(tree->members[3].dimensions[0].length_member, 0);
  EXPECT_EQ(tree->members[4].nested, odd_schema().find("odd.inner_t"));
  EXPECT_EQ(tree->members[5].dimensions[0].fixed_count, 4);
  EXPECT_EQ(tree->members[7].nested, tree);
  ASSERT_EQ(tree->constants.size(), 2U);
  EXPECT_EQ(tree->constants[0].value, "-1");
  EXPECT_EQ(tree->constants[1].name, "B");
  EXPECT_EQ(tree->min_size_bytes, 2U + 2 + 4 + 8);
  EXPECT_FALSE(tree->starts_with_utime);
}

TEST(Parser, fingerprints_of_odd_types_are_lcm_gens) {
  EXPECT_EQ(odd_schema().find("odd.tree_t")->fingerprint,
            static_cast<std::uint64_t>(odd::tree_t::getHash()));
  EXPECT_EQ(odd_schema().find("odd.inner_t")->fingerprint,
            static_cast<std::uint64_t>(odd::inner_t::getHash()));
  EXPECT_EQ(odd_schema().find("odd.empty_t")->fingerprint,
            static_cast<std::uint64_t>(odd::empty_t::getHash()));
}

TEST(Parser, says_file_line_and_what_is_wrong) {
  using testing::HasSubstr;
  using testing::StartsWith;
  EXPECT_THAT(error_of("package a;\nstruct b_t {\n  int32_t n\n}"),
              StartsWith("x.lcm:4: expected `;` but found `}`"));
  EXPECT_THAT(error_of("struct a_t { int32_t x; "), HasSubstr("expected a member's type"));
  EXPECT_THAT(error_of("struct a_t { float x[n]; int32_t n; }"),
              HasSubstr("declared before the array"));
  EXPECT_THAT(error_of("struct a_t { float n; float x[n]; }"), HasSubstr("integer member"));
  EXPECT_THAT(error_of("struct a_t { float x[0]; }"), HasSubstr("not a positive 32 bit number"));
  EXPECT_THAT(error_of("struct a_t { float x[99999999999999999999]; }"),
              HasSubstr("not a positive"));
  EXPECT_THAT(error_of("struct a_t { float x; byte x; }"), HasSubstr("declared twice"));
  EXPECT_THAT(error_of("struct a_t { b_t x; }"), HasSubstr("there is no type b_t"));
  EXPECT_THAT(error_of("struct a_t { } struct a_t { }"), HasSubstr("defined twice"));
  EXPECT_THAT(error_of("enum a_t { A }"),
              HasSubstr("expected `package` or `struct` but found `enum`"));
  EXPECT_THAT(error_of("struct a_t { /* never"), HasSubstr("never ends"));
  EXPECT_THAT(error_of("struct a_t { int32_t $; }"), HasSubstr("unexpected character"));
  EXPECT_THAT(error_of("struct a..b { }"), HasSubstr("the struct's name"));
  EXPECT_EQ(error_of(""), "");
  EXPECT_EQ(error_of("struct a_t { const double C = 1.5e-3, D = -2; }"), "");
}

TEST(Parser, refuses_nesting_that_would_take_for_ever) {
  std::string text = "struct t0_t { }\n";
  for (int i = 1; i < 64; ++i) {
    const std::string inner = "t" + std::to_string(i - 1) + "_t";
    text += "struct t" + std::to_string(i) + "_t { " + inner + " a; " + inner + " b; }\n";
  }
  EXPECT_THAT(error_of(text), testing::HasSubstr("nested too deeply"));
}

TEST(Schema, a_type_without_finite_encoding_never_fits) {
  const Schema schema(LcmFiles{{"x.lcm", "struct a_t { a_t self; }"}});
  EXPECT_GE(schema.find("a_t")->min_size_bytes, std::size_t{INT32_MAX});
}

TEST(Schema, knows_which_types_begin_with_utime_and_seq) {
  EXPECT_TRUE(builtin_schema().find("fusion_slam.tile_t")->continues_with_seq);
  EXPECT_TRUE(builtin_schema().find("bot_core.pose_t")->starts_with_utime);
  EXPECT_FALSE(builtin_schema().find("bot_core.pose_t")->continues_with_seq);
  EXPECT_FALSE(builtin_schema().find("fusion_slam.graph_node_t")->starts_with_utime);
  EXPECT_EQ(builtin_schema().find("fusion_slam.no_such_t"), nullptr);
  EXPECT_EQ(builtin_schema().find(std::uint64_t{1}), nullptr);
}

}  // namespace
}  // namespace fusion_slam
