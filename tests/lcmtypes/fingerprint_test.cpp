#include <gtest/gtest.h>

#include "all_types.hpp"
#include "libs/schema/schema.hpp"

namespace {

// What lcm-gen computed into the headers is what the schema computes from the texts.
TEST(Fingerprint, of_every_generated_type_is_the_schemas) {
  int n = 0;
#define FS_CHECK(package, type)                                                                 \
  {                                                                                             \
    const fusion_slam::LcmType* found = fusion_slam::builtin_schema().find(#package "." #type); \
    ASSERT_NE(found, nullptr) << #package "." #type;                                            \
    EXPECT_EQ(found->fingerprint, static_cast<std::uint64_t>(package::type::getHash()))         \
        << found->name;                                                                         \
    EXPECT_EQ(fusion_slam::builtin_schema().find(found->fingerprint), found) << found->name;    \
    ++n;                                                                                        \
  }
  FS_FOR_EACH_TYPE(FS_CHECK)
  EXPECT_EQ(static_cast<std::size_t>(n), fusion_slam::builtin_schema().types().size());
}

}  // namespace
