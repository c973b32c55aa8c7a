// The driver on a virtual device, over a pseudo-terminal: models, faults, ports.
#include "drivers/rplidar/driver.hpp"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/rplidar/port_finder.hpp"
#include "tests/drivers/rplidar/rig.hpp"
#include "tests/support/virtual_rplidar/timetable.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

VirtualWorld room() {
  VirtualWorld world = virtual_room(18, 360);
  world.rate_hz = 12.0;
  return world;
}

int wrong_beams(const RplidarRig::Diary& diary) {
  int n = 0;
  for (const auto& entry : diary) n += entry.wrong_beams;
  return n;
}

class EveryModel : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Models, EveryModel, testing::ValuesIn(virtual_model_names()),
                         [](const auto& info) {
                           std::string name = info.param;
                           for (char& c : name)
                             if (c == '-' || c == '.') c = '_';
                           return name;
                         });

TEST_P(EveryModel, ScansAndStops) {
  RplidarRig rig(GetParam(), room());
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_turns(3));
  EXPECT_TRUE(rig.device().scanning());
  EXPECT_EQ(rig.device().motor_pwm(), GetParam() == "a2" ? 660 : -1);
  rig.stop();
  EXPECT_EQ(wrong_beams(rig.diary()), 0);
  EXPECT_EQ(rig.device().bad_requests(), 0);
  // The device reads STOP and PWM 0 in its own time.
  const int still = GetParam() == "a2" ? 0 : -1;
  for (int i = 0; i < 500 && (rig.device().scanning() || rig.device().motor_pwm() != still); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(rig.device().scanning());
  EXPECT_EQ(rig.device().motor_pwm(), still);
}

void survives(VirtualFault fault, const std::string& said) {
  SCOPED_TRACE(to_string(fault));
  RplidarRig rig("a1", room());
  rig.plug_in();
  rig.start();
  EXPECT_TRUE(rig.wait_for_turns(2));
  const std::size_t before = rig.now();
  rig.device().set_fault(fault);
  EXPECT_TRUE(rig.wait_for_text(said, before));
  rig.device().set_fault(VirtualFault::kNone);
  const std::size_t after = rig.now();
  EXPECT_TRUE(rig.wait_for_turns(4, after));
  rig.stop();
  EXPECT_EQ(wrong_beams(rig.diary()), 0);
}

// All at once: each is mostly waiting.
TEST(Driver, NamesAndSurvivesEveryFault) {
  const std::map<VirtualFault, std::string> said = {
      {VirtualFault::kNoise, "turn dropped"},
      {VirtualFault::kLoss, "turn dropped"},
      {VirtualFault::kChecksum, "turn dropped"},
      {VirtualFault::kStall, "went silent"},
      {VirtualFault::kUnplug, "unplugged"},
      {VirtualFault::kHealth, "protection stop (health 2, error code 32775)"},
      {VirtualFault::kDescriptor, "a wrong descriptor (type 0x37"},
      {VirtualFault::kSlowMotor, "the motor"}};
  EXPECT_EQ(said.size(), virtual_faults().size());
  std::vector<std::thread> patients;
  for (const auto& [fault, text] : said)
    patients.emplace_back([f = fault, t = text] { survives(f, t); });
  for (std::thread& patient : patients) patient.join();
}

TEST(Driver, SaysOnceWhyAndThenForHowLong) {
  RplidarRig rig("a1", room());
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_turns(1));
  const std::size_t before = rig.now();
  rig.device().set_fault(VirtualFault::kUnplug);
  ASSERT_TRUE(rig.wait_for_text("there is no port", before));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  rig.device().set_fault(VirtualFault::kNone);
  ASSERT_TRUE(rig.wait_for_text("again after", before));
  int said = 0;
  for (const auto& entry : rig.diary())
    said += entry.text.find("there is no port") != std::string::npos ? 1 : 0;
  EXPECT_EQ(said, 1);
}

TEST(Driver, WaitsForTheDevice) {
  RplidarRig rig("a1", room());
  rig.start();
  ASSERT_TRUE(rig.wait_for_text("there is no port"));
  rig.plug_in();
  EXPECT_TRUE(rig.wait_for_turns(1));
}

TEST(Driver, FindsTheDeviceAmongPortsThatMatch) {
  RplidarRig rig("a1", room());
  rig.plug_in();
  VirtualRplidarOptions deaf;  // comes first by name, and answers nothing
  deaf.link = rig.port().parent_path() / "another-port";
  deaf.world = room();
  VirtualRplidar other(deaf);
  other.set_fault(VirtualFault::kStall);
  rig.config().port = (rig.port().parent_path() / "*port").string();
  rig.config().baud = 115200;
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("no RPLidar answers"));
  EXPECT_TRUE(rig.wait_for_turns(1));
  EXPECT_FALSE(other.scanning());
}

TEST(Driver, RefusesAnotherModel) {
  RplidarRig rig("a2", room());
  rig.config().model = "a1";
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_text("it is a RPLIDAR A2M8"));
  EXPECT_FALSE(rig.device().scanning());
}

TEST(Driver, NamesTheScansThereAre) {
  RplidarRig rig("a1", room());
  rig.config().scan_mode = "dense";
  rig.plug_in();
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("it has no dense scan; it offers Standard (standard)"));
}

TEST(Driver, LeavesAPortInUseAlone) {
  RplidarRig rig("a1", room());
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_turns(1));
  EXPECT_THROW(
      {
        try {
          SerialPort second(rig.port(), 115200);
        } catch (const PortError& error) {
          EXPECT_THAT(error.what(), HasSubstr("in use by another program"));
          throw;
        }
      },
      PortError);
  const std::size_t before = rig.now();
  EXPECT_TRUE(rig.wait_for_turns(2, before));
}

TEST(Driver, RestartsWhenAsked) {
  RplidarRig rig("a1", room());
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_turns(1));
  const std::size_t before = rig.now();
  rig.driver().restart();
  EXPECT_TRUE(rig.wait_for_text("restart asked for", before));
  EXPECT_TRUE(rig.wait_for_text("again after", before));
}

TEST(VirtualRplidar, ATimetableIsInOrder) {
  const auto changes = timetable({"unplug@5+1.5", "stall@1+2"});
  ASSERT_EQ(changes.size(), 4U);
  EXPECT_EQ(changes[0].fault, VirtualFault::kStall);
  EXPECT_DOUBLE_EQ(changes[1].at_s, 3.0);
  EXPECT_EQ(changes[2].fault, VirtualFault::kUnplug);
  EXPECT_EQ(changes[3].fault, VirtualFault::kNone);
  EXPECT_THROW(timetable({"stall"}), std::invalid_argument);
  EXPECT_THROW(timetable({"flood@1+2"}), std::invalid_argument);
}

TEST(SerialPort, AFileIsNoPort) {
  EXPECT_THROW(SerialPort("/dev/null", 115200), PortError);
  EXPECT_THROW(SerialPort("/no/such/port", 115200), PortError);
}

TEST(PortFinder, APathIsItselfAndAPatternWhatMatches) {
  EXPECT_EQ(ports_to_try("/dev/nothing-here"), std::vector<std::string>{"/dev/nothing-here"});
  EXPECT_TRUE(ports_to_try("/dev/nothing-here*").empty());
  EXPECT_EQ(ports_to_try("/dev/nul?"), std::vector<std::string>{"/dev/null"});
  EXPECT_EQ(describe_ports({}), "this machine has no serial port");
  EXPECT_EQ(describe_ports({{"/dev/ttyUSB0", "CP2102", true}, {"/dev/ttyS0", "", false}}),
            "ports here: /dev/ttyUSB0 (CP2102), /dev/ttyS0");
}

}  // namespace
}  // namespace fusion_slam
