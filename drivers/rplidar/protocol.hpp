// Requests and single answers of Slamtec's serial protocol ("RPLIDAR Interface Protocol and
// Application Notes", rev. 1.1 of 2018 for A1 and A2 and rev. 2.1 of 2019 for A3; figure numbers
// are the latter's). Pure functions on bytes; all numbers little-endian.
//   request     A5 cmd [size payload... checksum]      checksum: XOR of all bytes before it
//   descriptor  A5 5A  30 bit answer length | 2 bit send mode  8 bit answer type
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fusion_slam {

enum class RplidarCommand : std::uint8_t {
  kScan = 0x20,
  kStop = 0x25,   // no answer
  kReset = 0x40,  // no answer; the device boots anew and may print a text
  kGetInfo = 0x50,
  kGetHealth = 0x52,
  kGetSampleRate = 0x59,  // firmware 1.17 and later
  kExpressScan = 0x82,    // firmware 1.17 and later
  kGetConf = 0x84,        // firmware 1.24 and later
  kSetMotorPwm = 0xF0,    // accessory board of A2 and A3; no answer
  kGetAccessoryBoard = 0xFF,
};

// "GET_INFO", as the protocol's document names it.
const char* to_string(RplidarCommand command);

// A request's bytes. `payload` goes with the commands from 0x80 on, at most 255 bytes.
std::vector<std::uint8_t> encode_request(RplidarCommand command,
                                         const std::vector<std::uint8_t>& payload = {});

constexpr std::size_t kDescriptorBytes = 7;

struct AnswerDescriptor {
  std::uint32_t length_bytes = 0;  // of one answer packet
  std::uint8_t send_mode = 0;      // 0 one packet, 1 packets until STOP
  std::uint8_t type = 0;
};
// Nothing when the bytes do not begin with A5 5A.
std::optional<AnswerDescriptor> decode_descriptor(const std::uint8_t* seven_bytes);
// "type 0x81, 5 bytes, many packets"
std::string to_string(const AnswerDescriptor& descriptor);

// What an answer must look like to be the answer to `command` (scans: any of the formats we read).
bool is_answer_to(RplidarCommand command, const AnswerDescriptor& descriptor);

struct RplidarInfo {
  std::uint8_t model = 0;  // high half: series, low half: M number
  std::uint8_t firmware_major = 0;
  std::uint8_t firmware_minor = 0;
  std::uint8_t hardware = 0;
  std::array<std::uint8_t, 16> serial{};

  int series() const { return model >> 4; }  // 1: A1, 2: A2, 3: A3, 4: C1, 6 on: S
  bool firmware_at_least(int major, int minor) const;
};
RplidarInfo decode_info(const std::array<std::uint8_t, 20>& packet);
// "RPLIDAR A1M8, firmware 1.29, hardware 7, serial 0123..."
std::string to_string(const RplidarInfo& info);

struct RplidarHealth {
  std::uint8_t status = 0;  // 0 good, 1 warning, 2 error: protection stop, no scan before RESET
  std::uint16_t error_code = 0;
};
RplidarHealth decode_health(const std::array<std::uint8_t, 3>& packet);

// Time of one measurement in us.
struct RplidarSampleRate {
  std::uint16_t standard_us = 0;
  std::uint16_t express_us = 0;
};
RplidarSampleRate decode_sample_rate(const std::array<std::uint8_t, 4>& packet);

// Entries of GET_LIDAR_CONF (section "Device configuration query command").
enum class RplidarConf : std::uint32_t {
  kModeCount = 0x70,
  kModeUsPerSample = 0x71,  // q8 us
  kModeAnswerType = 0x75,
  kTypicalMode = 0x7C,
  kModeName = 0x7F,
};
std::vector<std::uint8_t> encode_conf_request(RplidarConf entry,
                                              std::optional<std::uint16_t> mode = {});
// The entry's value: what follows the echoed entry number; nothing when another entry is echoed.
std::optional<std::vector<std::uint8_t>> decode_conf(RplidarConf entry,
                                                     const std::vector<std::uint8_t>& packet);
// 0 when it is shorter than `n_bytes`; at most 4.
std::uint32_t little_endian(const std::vector<std::uint8_t>& bytes, std::size_t n_bytes);

}  // namespace fusion_slam
