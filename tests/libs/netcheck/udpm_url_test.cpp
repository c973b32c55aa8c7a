#include "libs/netcheck/udpm_url.hpp"

#include <cstdlib>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

using testing::HasSubstr;

std::string error_of(const std::string& url) {
  try {
    parse_udpm_url(url);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(UdpmUrl, reads_each_part) {
  const UdpmUrl url =
      parse_udpm_url("udpm://239.1.2.3:1234?ttl=1&recv_buf_size=5000000&transmit_only=true");
  EXPECT_EQ(url.group, "239.1.2.3");
  EXPECT_EQ(url.port, 1234);
  EXPECT_EQ(url.ttl, 1);
  EXPECT_EQ(url.recv_buf_size_bytes, 5'000'000);
}

TEST(UdpmUrl, has_lcms_defaults) {
  for (const char* const text :
       {"udpm://", "udpm://239.255.76.67", "udpm://:7667", "udpm://?ttl=0"}) {
    const UdpmUrl url = parse_udpm_url(text);
    EXPECT_EQ(url.group, "239.255.76.67") << text;
    EXPECT_EQ(url.port, 7667) << text;
    EXPECT_EQ(url.ttl, 0) << text;
    EXPECT_EQ(url.recv_buf_size_bytes, 4 << 20) << text;
  }
}

TEST(UdpmUrl, takes_the_environments) {
  setenv("LCM_DEFAULT_URL", "udpm://239.9.9.9:99", 1);
  EXPECT_EQ(parse_udpm_url("").group, "239.9.9.9");
  EXPECT_EQ(parse_udpm_url("udpm://").group, "239.255.76.67");
  unsetenv("LCM_DEFAULT_URL");
  EXPECT_EQ(parse_udpm_url("").port, 7667);
}

TEST(UdpmUrl, says_what_is_wrong) {
  EXPECT_THAT(error_of("memq://"), HasSubstr("is no multicast"));
  EXPECT_THAT(error_of("udpm://10.0.0.1"), HasSubstr("is no multicast address"));
  EXPECT_THAT(error_of("udpm://name:7667"), HasSubstr("is no multicast address"));
  EXPECT_THAT(error_of("udpm://239.1.1.1:70000"),
              HasSubstr("port `70000` has to be a number from 1 to 65535"));
  EXPECT_THAT(error_of("udpm://?ttl=-1"), HasSubstr("ttl `-1`"));
  EXPECT_THAT(error_of("udpm://?recv_buf_size=2MB"), HasSubstr("recv_buf_size `2MB`"));
}

}  // namespace
}  // namespace fusion_slam
