// The program in private networks: broken in several ways, and mended by the commands that it
// prints itself.
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/libs/netcheck/private_network.hpp"

namespace fusion_slam {
namespace {

const std::string kDoctor = std::string(FS_BINARY_DIR) + "/bin/doctor";

// What doctor --json says after `script`, by name of the check; empty when private networks are not
// permitted.
std::map<std::string, nlohmann::json> doctor_after(const std::string& script,
                                                   const std::string& options = "") {
  const auto result = in_private_network(script + kDoctor + " --json " + options);
  std::map<std::string, nlohmann::json> by_name;
  if (!result) return by_name;
  const nlohmann::json list = nlohmann::json::parse(result->output, nullptr, false);
  EXPECT_TRUE(list.is_array()) << result->output;
  for (const auto& entry : list) by_name[entry["name"]] = entry;
  return by_name;
}

#define FS_NEEDS_PRIVATE_NETWORK(results) \
  if ((results).empty())                  \
  GTEST_SKIP() << "skipped: a private network (unshare --net) is not permitted here"

TEST(Doctor, says_that_there_is_no_route) {
  auto checks = doctor_after("");
  FS_NEEDS_PRIVATE_NETWORK(checks);
  EXPECT_EQ(checks["route"]["state"], "fault");
  EXPECT_EQ(checks["route"]["command"],
            "ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo");
  EXPECT_EQ(checks.count("loopback"), 0U);

  checks = doctor_after("ip link set lo up\n");
  EXPECT_EQ(checks["route"]["command"],
            "ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo");
}

TEST(Doctor, says_that_the_multicast_flag_is_off) {
  auto checks = doctor_after(with_multicast() + "ip link set lo multicast off\n");
  FS_NEEDS_PRIVATE_NETWORK(checks);
  // A fault only where the kernel then really keeps messages back.
  EXPECT_NE(checks["route"]["state"], "good");
  EXPECT_EQ(checks["route"]["command"], "ip link set lo multicast on");
}

TEST(Doctor, its_own_commands_mend_the_network) {
  auto checks = doctor_after(kDoctor + " --commands | grep \"^ip \" | sh\n");
  FS_NEEDS_PRIVATE_NETWORK(checks);
  EXPECT_EQ(checks["route"]["state"], "good") << checks["route"];
  EXPECT_EQ(checks["loopback"]["state"], "good") << checks["loopback"];
  EXPECT_EQ(checks["reach"]["state"], "good") << checks["reach"];
}

TEST(Doctor, says_when_the_route_keeps_messages_here_against_the_ttl) {
  auto checks = doctor_after(with_multicast(), "--lcm-url \"udpm://239.1.1.1:7000?ttl=1\"");
  FS_NEEDS_PRIVATE_NETWORK(checks);
  EXPECT_EQ(checks["reach"]["state"], "warning");
}

TEST(Doctor, says_what_buffer_the_kernel_grants) {
  auto checks = doctor_after(with_multicast(), "--lcm-url \"udpm://?recv_buf_size=100000\"");
  FS_NEEDS_PRIVATE_NETWORK(checks);
  EXPECT_EQ(checks["receive buffer"]["state"], "fault");
  EXPECT_THAT(checks["receive buffer"]["found"].get<std::string>(),
              testing::HasSubstr("granted 100000"));
  EXPECT_EQ(checks["large messages"]["state"], "fault");  // 400 kB do not fit 100 kB
}

TEST(Doctor, returns_0_without_fault_1_with_one_2_for_wrong_usage) {
  EXPECT_EQ(run_shell(kDoctor + " --help").exit_code, 0);
  EXPECT_EQ(run_shell(kDoctor + " --no-such-option").exit_code, 2);
  EXPECT_EQ(run_shell(kDoctor + " --lcm-url memq://").exit_code, 2);
  const auto broken = in_private_network(kDoctor);
  if (!broken) GTEST_SKIP() << "skipped: a private network (unshare --net) is not permitted here";
  EXPECT_EQ(broken->exit_code, 1);
  const auto mended = in_private_network(with_multicast() + kDoctor);
  const bool has_fault =
      mended->output.find("FAULT") != std::string::npos;  // of this machine: rmem_max, programs
  EXPECT_EQ(mended->exit_code, has_fault ? 1 : 0) << mended->output;
}

}  // namespace
}  // namespace fusion_slam
