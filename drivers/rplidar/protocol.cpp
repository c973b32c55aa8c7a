#include "drivers/rplidar/protocol.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace fusion_slam {
namespace {

constexpr std::uint8_t kStart = 0xA5;
constexpr std::uint8_t kAnswerStart = 0x5A;
constexpr std::uint8_t kHasPayload = 0x80;

std::string hex(std::uint8_t byte) {
  char text[8];
  std::snprintf(text, sizeof text, "%02X", byte);
  return text;
}

}  // namespace

const char* to_string(RplidarCommand command) {
  switch (command) {
    case RplidarCommand::kScan:
      return "SCAN";
    case RplidarCommand::kStop:
      return "STOP";
    case RplidarCommand::kReset:
      return "RESET";
    case RplidarCommand::kGetInfo:
      return "GET_INFO";
    case RplidarCommand::kGetHealth:
      return "GET_HEALTH";
    case RplidarCommand::kGetSampleRate:
      return "GET_SAMPLERATE";
    case RplidarCommand::kExpressScan:
      return "EXPRESS_SCAN";
    case RplidarCommand::kGetConf:
      return "GET_LIDAR_CONF";
    case RplidarCommand::kSetMotorPwm:
      return "SET_MOTOR_PWM";
    case RplidarCommand::kGetAccessoryBoard:
      return "GET_ACC_BOARD_FLAG";
  }
  return "request";
}

std::vector<std::uint8_t> encode_request(RplidarCommand command,
                                         const std::vector<std::uint8_t>& payload) {
  std::vector<std::uint8_t> bytes = {kStart, static_cast<std::uint8_t>(command)};
  if ((bytes[1] & kHasPayload) == 0) return bytes;
  bytes.push_back(static_cast<std::uint8_t>(payload.size()));
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  std::uint8_t checksum = 0;
  for (const std::uint8_t byte : bytes) checksum ^= byte;
  bytes.push_back(checksum);
  return bytes;
}

std::optional<AnswerDescriptor> decode_descriptor(const std::uint8_t* b) {
  if (b[0] != kStart || b[1] != kAnswerStart) return std::nullopt;
  const std::uint32_t word = b[2] | (static_cast<std::uint32_t>(b[3]) << 8) |
                             (static_cast<std::uint32_t>(b[4]) << 16) |
                             (static_cast<std::uint32_t>(b[5]) << 24);
  return AnswerDescriptor{word & 0x3FFFFFFFU, static_cast<std::uint8_t>(word >> 30), b[6]};
}

std::string to_string(const AnswerDescriptor& d) {
  return "type 0x" + hex(d.type) + ", " + std::to_string(d.length_bytes) + " bytes, " +
         (d.send_mode == 0   ? "one packet"
          : d.send_mode == 1 ? "many packets"
                             : "reserved send mode");
}

bool is_answer_to(RplidarCommand command, const AnswerDescriptor& d) {
  const auto is = [&](std::uint8_t type, std::uint32_t length_bytes, std::uint8_t send_mode) {
    return d.type == type && d.length_bytes == length_bytes && d.send_mode == send_mode;
  };
  switch (command) {
    case RplidarCommand::kScan:
      return is(0x81, 5, 1);
    case RplidarCommand::kExpressScan:
      return is(0x82, 84, 1) || is(0x85, 84, 1);
    case RplidarCommand::kGetInfo:
      return is(0x04, 20, 0);
    case RplidarCommand::kGetHealth:
      return is(0x06, 3, 0);
    case RplidarCommand::kGetSampleRate:
      return is(0x15, 4, 0);
    case RplidarCommand::kGetConf:
      return d.type == 0x20 && d.send_mode == 0 && d.length_bytes >= 4 && d.length_bytes <= 260;
    case RplidarCommand::kGetAccessoryBoard:
      return is(0xFF, 4, 0);
    case RplidarCommand::kStop:
    case RplidarCommand::kReset:
    case RplidarCommand::kSetMotorPwm:
      break;
  }
  return false;
}

bool RplidarInfo::firmware_at_least(int major, int minor) const {
  return std::pair<int, int>(firmware_major, firmware_minor) >= std::pair(major, minor);
}

RplidarInfo decode_info(const std::array<std::uint8_t, 20>& packet) {
  RplidarInfo info;
  info.model = packet[0];
  info.firmware_minor = packet[1];
  info.firmware_major = packet[2];
  info.hardware = packet[3];
  std::copy(packet.begin() + 4, packet.end(), info.serial.begin());
  return info;
}

std::string to_string(const RplidarInfo& info) {
  static const char* const kSeries[] = {"", "A1", "A2", "A3", "C1", "", "S1", "S2", "S3"};
  const auto series = static_cast<std::size_t>(info.series());
  std::string text = "RPLIDAR ";
  if (series < std::size(kSeries) && *kSeries[series] != '\0')
    text += std::string(kSeries[series]) + "M" + std::to_string(info.model & 0x0F);
  else
    text += "of model " + std::to_string(info.model);
  char firmware[16];
  std::snprintf(firmware, sizeof firmware, "%d.%02d", info.firmware_major, info.firmware_minor);
  text += std::string(", firmware ") + firmware + ", hardware " + std::to_string(info.hardware) +
          ", serial ";
  for (const std::uint8_t byte : info.serial) text += hex(byte);
  return text;
}

RplidarHealth decode_health(const std::array<std::uint8_t, 3>& packet) {
  return {packet[0], static_cast<std::uint16_t>(packet[1] | (packet[2] << 8))};
}

RplidarSampleRate decode_sample_rate(const std::array<std::uint8_t, 4>& packet) {
  return {static_cast<std::uint16_t>(packet[0] | (packet[1] << 8)),
          static_cast<std::uint16_t>(packet[2] | (packet[3] << 8))};
}

std::vector<std::uint8_t> encode_conf_request(RplidarConf entry,
                                              std::optional<std::uint16_t> mode) {
  const auto number = static_cast<std::uint32_t>(entry);
  std::vector<std::uint8_t> payload;
  for (int shift = 0; shift < 32; shift += 8)
    payload.push_back(static_cast<std::uint8_t>(number >> shift));
  if (mode) {
    payload.push_back(static_cast<std::uint8_t>(*mode & 0xFF));
    payload.push_back(static_cast<std::uint8_t>(*mode >> 8));
  }
  return encode_request(RplidarCommand::kGetConf, payload);
}

std::optional<std::vector<std::uint8_t>> decode_conf(RplidarConf entry,
                                                     const std::vector<std::uint8_t>& packet) {
  if (packet.size() < 4 || little_endian(packet, 4) != static_cast<std::uint32_t>(entry))
    return std::nullopt;
  return std::vector<std::uint8_t>(packet.begin() + 4, packet.end());
}

std::uint32_t little_endian(const std::vector<std::uint8_t>& bytes, std::size_t n_bytes) {
  std::uint32_t value = 0;
  if (bytes.size() < n_bytes) return 0;
  for (std::size_t i = 0; i < n_bytes && i < 4; ++i)
    value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
  return value;
}

}  // namespace fusion_slam
