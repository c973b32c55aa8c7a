// Packets and turns: golden bytes, round trips through the virtual device's own encoder, and
// damage.
#include "drivers/rplidar/scan_parser.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/drivers/rplidar/turns.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

TEST(ScanPackets, AGoldenNode) {
  // quality 15, first of a turn; 123.5 degrees = 7904 / 64; 1.25 m = 5000 / 4 mm.
  const Bytes bytes = {15 << 2 | 1, 0xC1, 0x3D, 0x88, 0x13};
  const auto node = decode_node(bytes.data());
  ASSERT_TRUE(node);
  EXPECT_TRUE(node->turn_begins);
  EXPECT_EQ(node->quality, 15);
  EXPECT_DOUBLE_EQ(node->angle_deg, 123.5);
  EXPECT_DOUBLE_EQ(node->range_m, 1.25);
  for (const auto& [byte, bit] : {std::pair(0, 0), std::pair(0, 1), std::pair(1, 0)}) {
    Bytes wrong = bytes;
    wrong[static_cast<std::size_t>(byte)] ^= static_cast<std::uint8_t>(1 << bit);
    EXPECT_FALSE(decode_node(wrong.data()));
  }
}

TEST(ScanPackets, AGoldenExpressCapsule) {
  Bytes bytes(84, 0);
  bytes[2] = 0x80;  // 90 degrees = 5760 / 64 = 0x1680, S set
  bytes[3] = 0x96;
  bytes[4] = 0xA2;  // 1000 mm << 2 | d1 >> 4 = 0x0FA2, d1 = 0x2F
  bytes[5] = 0x0F;
  bytes[6] = 0x40;  // 2000 mm << 2 | d2 >> 4 = 0x1F40, d2 = 0x04
  bytes[7] = 0x1F;
  bytes[8] = 0x4F;
  std::uint8_t sum = 0;
  for (std::size_t i = 2; i < bytes.size(); ++i) sum ^= bytes[i];
  bytes[0] = static_cast<std::uint8_t>(0xA0 | (sum & 0x0F));
  bytes[1] = static_cast<std::uint8_t>(0x50 | (sum >> 4));
  const auto capsule = decode_capsule(ScanFormat::kExpress, bytes.data());
  ASSERT_TRUE(capsule);
  EXPECT_TRUE(capsule->scan_begins);
  EXPECT_DOUBLE_EQ(capsule->start_deg, 90.0);
  ASSERT_EQ(capsule->samples.size(), 32U);
  EXPECT_DOUBLE_EQ(capsule->samples[0].range_m, 1.0);
  EXPECT_DOUBLE_EQ(capsule->samples[0].parallax_deg, 0x2F / 8.0);
  EXPECT_DOUBLE_EQ(capsule->samples[1].range_m, 2.0);
  EXPECT_DOUBLE_EQ(capsule->samples[1].parallax_deg, 0.5);
  EXPECT_DOUBLE_EQ(capsule->samples[31].range_m, 0.0);
}

TEST(ScanPackets, EverySingleBitMattersInACapsule) {
  std::vector<wire::Sample> samples;
  for (int i = 0; i < 40; ++i) samples.push_back({100.0 + i, 99.0 + i, 0.5 + 0.1 * i, 0, false});
  for (const ScanFormat format : {ScanFormat::kExpress, ScanFormat::kDense}) {
    const Bytes good = format == ScanFormat::kExpress ? wire::express_capsule(samples, false)
                                                      : wire::dense_capsule(samples, false);
    ASSERT_EQ(good.size(), packet_bytes(format));
    ASSERT_TRUE(decode_capsule(format, good.data()));
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      Bytes wrong = good;
      wrong[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      EXPECT_FALSE(decode_capsule(format, wrong.data())) << bit;
    }
  }
}

class EveryFormat : public testing::TestWithParam<ScanFormat> {};
INSTANTIATE_TEST_SUITE_P(Formats, EveryFormat,
                         testing::Values(ScanFormat::kStandard, ScanFormat::kExpress,
                                         ScanFormat::kDense),
                         [](const auto& info) { return std::string(to_string(info.param)); });

TEST_P(EveryFormat, TurnsAreWhatTheDeviceMeasured) {
  const VirtualWorld world = virtual_room(18, 360);
  ScanParser parser(GetParam(), kPeriod_s, kByte_s);
  const auto turns = parse(&parser, encode(world, GetParam()), 100);
  // The first turn begins before we listen, the last is not confirmed.
  ASSERT_GE(turns.size(), 15U);
  for (const Revolution& turn : turns) {
    EXPECT_EQ(wrong_beams(turn, world), 0);
    EXPECT_NEAR(static_cast<double>(turn.measurements.size()), 360.0, 1.0);
    EXPECT_NEAR(turn.period_s, 360 * kPeriod_s, 2 * kPeriod_s);
    EXPECT_EQ(turn.has_quality, GetParam() == ScanFormat::kStandard);
  }
  EXPECT_EQ(parser.counters().bad_packets, 0);
  EXPECT_EQ(parser.counters().skipped_bytes, 0);
}

TEST_P(EveryFormat, TheSameInWhateverPiecesTheBytesCome) {
  const Bytes bytes = encode(virtual_room(5, 360), GetParam());
  ScanParser whole(GetParam(), kPeriod_s, kByte_s);
  const auto expected = parse(&whole, bytes, bytes.size());
  for (const std::size_t chunk : {1, 7, 83, 1000}) {
    ScanParser parser(GetParam(), kPeriod_s, kByte_s);
    const auto turns = parse(&parser, bytes, chunk);
    ASSERT_EQ(turns.size(), expected.size());
    for (std::size_t t = 0; t < turns.size(); ++t) {
      ASSERT_EQ(turns[t].measurements.size(), expected[t].measurements.size());
      for (std::size_t i = 0; i < turns[t].measurements.size(); ++i) {
        EXPECT_EQ(turns[t].measurements[i].angle_deg, expected[t].measurements[i].angle_deg);
        EXPECT_EQ(turns[t].measurements[i].range_m, expected[t].measurements[i].range_m);
      }
    }
  }
}

TEST_P(EveryFormat, TimesAreThoseOfTheMeasurement) {
  ScanParser parser(GetParam(), kPeriod_s, kByte_s);
  const auto turns = parse(&parser, encode(virtual_room(10, 360), GetParam()), 1, GetParam());
  const auto packet_us = 1e6 * kByte_s * static_cast<double>(packet_bytes(GetParam()));
  for (std::size_t t = 2; t < turns.size(); ++t) {
    // parse() sends what was measured up to then at once, and the clock takes the line's delay off.
    const auto& first = turns[t].measurements.front();
    const double number =
        std::round(static_cast<double>(first.utime_us - kBegin_us) / (1e6 * kPeriod_s));
    EXPECT_NEAR(static_cast<double>(first.utime_us - kBegin_us), number * 1e6 * kPeriod_s,
                packet_us);
    EXPECT_EQ(std::lround(number) % 360, 0) << "turns begin at multiples of 360 samples";
    for (std::size_t i = 1; i < turns[t].measurements.size(); ++i)
      EXPECT_NEAR(static_cast<double>(turns[t].measurements[i].utime_us -
                                      turns[t].measurements[i - 1].utime_us),
                  1e6 * kPeriod_s, 3.0);
  }
}

TEST_P(EveryFormat, DamageCostsItsTurnAndNoOther) {
  const VirtualWorld world = virtual_room(18, 360);
  const Bytes clean = encode(world, GetParam());
  const std::size_t middle = clean.size() / 2 + 11;
  for (const int n_changed : {-3, -1, 1, 2, 7}) {
    Bytes bytes = clean;
    const auto at = bytes.begin() + static_cast<std::ptrdiff_t>(middle);
    if (n_changed < 0) bytes.erase(at, at - n_changed);
    if (n_changed > 0) bytes.insert(at, static_cast<std::size_t>(n_changed), 0x5C);
    ScanParser parser(GetParam(), kPeriod_s, kByte_s);
    const auto turns = parse(&parser, bytes, 100);
    EXPECT_GE(turns.size(), 14U) << n_changed;
    EXPECT_GE(parser.counters().damaged, 1) << n_changed;
    EXPECT_LE(parser.counters().damaged, 2) << n_changed;
    for (const Revolution& turn : turns) EXPECT_EQ(wrong_beams(turn, world), 0) << n_changed;
  }
}

TEST_P(EveryFormat, BeginsInTheMiddleAndSurvivesRubbish) {
  const VirtualWorld world = virtual_room(6, 360);
  const Bytes clean = encode(world, GetParam());
  std::mt19937 random(7);
  Bytes bytes;
  for (int i = 0; i < 3000; ++i) bytes.push_back(static_cast<std::uint8_t>(random()));
  for (std::size_t i = 333; i < clean.size(); ++i) bytes.push_back(clean[i]);
  ScanParser parser(GetParam(), kPeriod_s, kByte_s);
  const auto turns = parse(&parser, bytes, 64);
  EXPECT_GE(turns.size(), 2U);
  for (const Revolution& turn : turns) EXPECT_EQ(wrong_beams(turn, world), 0);
}

TEST(ScanParser, AMissingCapsuleIsNoticed) {
  const VirtualWorld world = virtual_room(18, 360);
  Bytes bytes = encode(world, ScanFormat::kExpress);
  bytes.erase(bytes.begin() + 84 * 50, bytes.begin() + 84 * 51);
  ScanParser parser(ScanFormat::kExpress, kPeriod_s, kByte_s);
  const auto turns = parse(&parser, bytes, 84);
  EXPECT_EQ(parser.counters().bad_packets, 1);
  EXPECT_GE(parser.counters().damaged, 1);
  for (const Revolution& turn : turns) EXPECT_EQ(wrong_beams(turn, world), 0);
}

TEST(ScanParser, NodesThatAFullBufferSwallowedAreNoticed) {
  Bytes bytes = encode(virtual_room(18, 360), ScanFormat::kStandard);
  const auto begin = bytes.begin() + 5 * 360 * 9 + 5 * 100;
  bytes.erase(begin, begin + 5 * 35);  // 35 degrees: less than parallax may jump
  ScanParser parser(ScanFormat::kStandard, kPeriod_s, kByte_s);
  const auto turns = parse(&parser, bytes, 100);
  EXPECT_EQ(parser.counters().bad_packets, 0);
  for (const Revolution& turn : turns) EXPECT_EQ(turn.measurements.size(), 360U);
  EXPECT_GE(turns.size(), 14U);
}

TEST(ScanParser, AStandingMotorMakesNoTurnAndNoHeap) {
  ScanParser parser(ScanFormat::kStandard, kPeriod_s, kByte_s);
  const Bytes first = wire::standard_node({0.0, 0.0, 1.0, 40, true});
  const Bytes node = wire::standard_node({5.0, 5.0, 1.0, 40, false});
  std::vector<Revolution> turns;
  parser.add(first.data(), first.size(), kBegin_us, &turns);
  for (int i = 0; i < 100'000; ++i)
    parser.add(node.data(), node.size(), kBegin_us + i * 500, &turns);
  EXPECT_TRUE(turns.empty());
  EXPECT_LT(parser.pending(), 40'000U);
}

TEST(ScanParser, ATurnCutShortIsNotHandedOut) {
  VirtualWorld world = virtual_room(6, 360);
  auto& samples = world.turns[3].samples;
  samples.resize(250);  // the next turn's flag comes 110 degrees early
  ScanParser parser(ScanFormat::kStandard, kPeriod_s, kByte_s);
  const auto turns = parse(&parser, encode(world, ScanFormat::kStandard), 50);
  EXPECT_GE(parser.counters().incomplete + parser.counters().damaged, 1);
  for (const Revolution& turn : turns) EXPECT_GT(turn.measurements.size(), 300U);
}

// The angles of a real A1: near objects are moved by parallax, 25 degrees back and forth.
TEST(ScanParser, ARealRecordingComesThroughWhole) {
  FS_RECORDING(log, "lidar/lcm-maebot-empty/empty_environment.log");
  const VirtualWorld world = read_virtual_world(log);
  ScanParser parser(ScanFormat::kStandard, kPeriod_s, kByte_s);
  const auto turns = parse(&parser, encode(world, ScanFormat::kStandard), 64);
  EXPECT_EQ(parser.counters().bad_packets, 0);
  EXPECT_EQ(parser.counters().incomplete, 0);
  ASSERT_GE(turns.size() + 2, world.turns.size());
  const std::size_t first = world.turns.size() - 1 - turns.size();  // the last is never confirmed
  for (std::size_t t = 0; t < turns.size(); ++t) {
    const auto& expected = world.turns[t + first].samples;
    ASSERT_EQ(turns[t].measurements.size(), expected.size()) << t;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const Measurement& m = turns[t].measurements[i];
      EXPECT_NEAR(std::remainder(m.angle_deg - expected[i].angle_deg, 360.0), 0.0, 0.5 / 64 + 1e-6);
      EXPECT_NEAR(m.range_m, expected[i].range_m, 0.126e-3);
      EXPECT_EQ(m.quality, expected[i].quality);
    }
  }
}

}  // namespace
}  // namespace fusion_slam
