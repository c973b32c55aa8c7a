#include "viz/web/admission.hpp"

#include <gtest/gtest.h>

namespace fusion_slam {
namespace {

TEST(Admission, HostNames) {
  EXPECT_EQ(host_name_of("Robot.Local:8090"), "robot.local");
  EXPECT_EQ(host_name_of("192.168.0.7"), "192.168.0.7");
  EXPECT_EQ(host_name_of("[::1]:8090"), "::1");
  EXPECT_EQ(host_name_of("[::1"), "");
  EXPECT_EQ(host_name_of(""), "");
}

TEST(Admission, OnlyOurNamesAndAddresses) {
  const std::set<std::string> names{"robot", "robot.local"};
  for (const char* ours :
       {"localhost:8090", "127.0.0.1:8090", "10.0.0.4", "[::1]:8090", "ROBOT:8090", "robot.local"})
    EXPECT_TRUE(is_our_host(ours, names)) << ours;
  for (const char* other : {"", "evil.example", "evil.example:8090", "robot.evil.example",
                            "127.0.0.1.evil.example", "[", ":8090"})
    EXPECT_FALSE(is_our_host(other, names)) << other;
}

TEST(Admission, OnlyOurOwnPage) {
  EXPECT_TRUE(is_our_page("", "robot:8090"));
  EXPECT_TRUE(is_our_page("http://robot:8090", "robot:8090"));
  EXPECT_TRUE(is_our_page("https://Robot:8090", "robot:8090"));
  for (const char* other : {"http://robot", "http://robot:80901", "http://evil.example", "null",
                            "robot:8090", "ftp://robot:8090"})
    EXPECT_FALSE(is_our_page(other, "robot:8090")) << other;
}

}  // namespace
}  // namespace fusion_slam
