// Requests and answers against the examples of Slamtec's document, byte for byte.
#include "drivers/rplidar/protocol.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/rplidar/answer_parser.hpp"
#include "drivers/rplidar/device.hpp"

namespace fusion_slam {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

TEST(Protocol, RequestsAreThoseOfTheDocument) {
  EXPECT_THAT(encode_request(RplidarCommand::kStop), ElementsAre(0xA5, 0x25));
  EXPECT_THAT(encode_request(RplidarCommand::kReset), ElementsAre(0xA5, 0x40));
  EXPECT_THAT(encode_request(RplidarCommand::kScan), ElementsAre(0xA5, 0x20));
  EXPECT_THAT(encode_request(RplidarCommand::kGetInfo), ElementsAre(0xA5, 0x50));
  EXPECT_THAT(encode_request(RplidarCommand::kGetHealth), ElementsAre(0xA5, 0x52));
  EXPECT_THAT(encode_request(RplidarCommand::kGetSampleRate), ElementsAre(0xA5, 0x59));
  EXPECT_THAT(encode_request(RplidarCommand::kExpressScan, {0, 0, 0, 0, 0}),
              ElementsAre(0xA5, 0x82, 0x05, 0, 0, 0, 0, 0, 0x22));
  EXPECT_THAT(encode_request(RplidarCommand::kSetMotorPwm, {0x94, 0x02}),
              ElementsAre(0xA5, 0xF0, 0x02, 0x94, 0x02, 0xA5 ^ 0xF0 ^ 0x02 ^ 0x94 ^ 0x02));
  EXPECT_THAT(encode_conf_request(RplidarConf::kModeName, 3),
              ElementsAre(0xA5, 0x84, 6, 0x7F, 0, 0, 0, 3, 0, 0xA5 ^ 0x84 ^ 6 ^ 0x7F ^ 3));
}

TEST(Protocol, DescriptorsAreThoseOfTheDocument) {
  const auto is = [](RplidarCommand command, const Bytes& bytes) {
    const auto descriptor = decode_descriptor(bytes.data());
    return descriptor && is_answer_to(command, *descriptor);
  };
  EXPECT_TRUE(is(RplidarCommand::kGetInfo, {0xA5, 0x5A, 0x14, 0, 0, 0, 0x04}));
  EXPECT_TRUE(is(RplidarCommand::kGetHealth, {0xA5, 0x5A, 0x03, 0, 0, 0, 0x06}));
  EXPECT_TRUE(is(RplidarCommand::kGetSampleRate, {0xA5, 0x5A, 0x04, 0, 0, 0, 0x15}));
  EXPECT_TRUE(is(RplidarCommand::kScan, {0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x81}));
  EXPECT_TRUE(is(RplidarCommand::kExpressScan, {0xA5, 0x5A, 0x54, 0, 0, 0x40, 0x82}));
  EXPECT_TRUE(is(RplidarCommand::kExpressScan, {0xA5, 0x5A, 0x54, 0, 0, 0x40, 0x85}));
  EXPECT_FALSE(is(RplidarCommand::kExpressScan, {0xA5, 0x5A, 0x84, 0, 0, 0x40, 0x84}));
  EXPECT_FALSE(is(RplidarCommand::kScan, {0xA5, 0x5A, 0x05, 0, 0, 0, 0x81}));  // one packet only
  EXPECT_FALSE(is(RplidarCommand::kGetInfo, {0xA5, 0x5B, 0x14, 0, 0, 0, 0x04}));
}

TEST(Protocol, InfoHealthAndRate) {
  std::array<std::uint8_t, 20> packet{0x18, 29, 1, 7, 0xC0, 0x01};
  const RplidarInfo info = decode_info(packet);
  EXPECT_EQ(to_string(info),
            "RPLIDAR A1M8, firmware 1.29, hardware 7, serial C001" + std::string(28, '0'));
  EXPECT_TRUE(info.firmware_at_least(1, 24));
  EXPECT_FALSE(info.firmware_at_least(2, 0));
  EXPECT_EQ(decode_health({2, 0x07, 0x80}).error_code, 0x8007);
  const RplidarSampleRate rate = decode_sample_rate({0xFC, 0x01, 0xFA, 0x00});
  EXPECT_EQ(rate.standard_us, 508);
  EXPECT_EQ(rate.express_us, 250);
  packet[0] = 0x5F;
  EXPECT_THAT(to_string(decode_info(packet)), HasSubstr("model 95"));
}

TEST(Protocol, ConfEchoesItsEntry) {
  const auto value = decode_conf(RplidarConf::kModeUsPerSample, {0x71, 0, 0, 0, 0x00, 0xFA, 0, 0});
  ASSERT_TRUE(value);
  EXPECT_EQ(little_endian(*value, 4), 64000U);  // the document's example: 250 us
  EXPECT_FALSE(decode_conf(RplidarConf::kModeName, {0x71, 0, 0, 0, 1}));
  EXPECT_FALSE(decode_conf(RplidarConf::kModeName, {0x7F, 0}));
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

const Bytes kHealthAnswer = {0xA5, 0x5A, 0x03, 0, 0, 0, 0x06, 0, 0, 0};

TEST(AnswerParser, FindsTheAnswerByteByByteAmongOtherThings) {
  const Bytes chance = {0xA5, 0x5A, 0x99, 0x99, 0x99, 0x99, 0xA5};  // scan data that looks like one
  const Bytes text = {'R', 'P', ' ', 'L', 'I', 'D', 'A', 'R'};
  const Bytes all = joined({text, chance, kHealthAnswer, {1, 2, 3}});
  for (std::size_t chunk = 1; chunk <= all.size(); ++chunk) {
    AnswerParser parser(RplidarCommand::kGetHealth);
    bool whole = false;
    Bytes after;
    for (std::size_t i = 0; i < all.size(); i += chunk) {
      const std::size_t n = std::min(chunk, all.size() - i);
      if (whole) break;
      whole = parser.add(&all[i], n);
    }
    ASSERT_TRUE(whole) << chunk;
    EXPECT_THAT(parser.packet(), ElementsAre(0, 0, 0));
  }
}

TEST(AnswerParser, WhatFollowsAScansDescriptorIsKept) {
  AnswerParser parser(RplidarCommand::kScan);
  const Bytes bytes = {0xA5, 0x5A, 5, 0, 0, 0x40, 0x81, 0x3E, 0x01};
  ASSERT_TRUE(parser.add(bytes.data(), bytes.size()));
  EXPECT_THAT(parser.rest(), ElementsAre(0x3E, 0x01));
}

TEST(AnswerParser, SaysWhatCameInstead) {
  AnswerParser nothing(RplidarCommand::kGetInfo);
  EXPECT_EQ(nothing.seen(), "nothing");
  AnswerParser other(RplidarCommand::kGetInfo);
  EXPECT_FALSE(other.add(kHealthAnswer.data(), kHealthAnswer.size()));
  EXPECT_EQ(other.seen(), "a wrong descriptor (type 0x06, 3 bytes, one packet)");
  AnswerParser noise(RplidarCommand::kGetInfo);
  EXPECT_FALSE(noise.add(kHealthAnswer.data() + 1, 9));
  EXPECT_EQ(noise.seen(), "9 bytes without a descriptor");
  AnswerParser cut(RplidarCommand::kGetHealth);
  EXPECT_FALSE(cut.add(kHealthAnswer.data(), 8));
  EXPECT_EQ(cut.seen(), "the descriptor but not the data behind it");
}

TEST(ScanMode, TheFastestOfTheWishedFormat) {
  const std::vector<ScanMode> modes = {{"Standard", ScanFormat::kStandard, 0, 5e-4},
                                       {"Express", ScanFormat::kExpress, 1, 2.5e-4}};
  EXPECT_EQ(choose_mode(modes, "auto").name, "Express");
  EXPECT_EQ(choose_mode(modes, "standard").name, "Standard");
  try {
    choose_mode(modes, "dense");
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("Standard (standard), Express (express)"));
  }
}

}  // namespace
}  // namespace fusion_slam
