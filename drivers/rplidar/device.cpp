#include "drivers/rplidar/device.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "drivers/rplidar/answer_parser.hpp"

namespace fusion_slam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kAfterStopMs = 20;  // the document: "at least 1 ms"; a packet under way takes 7 ms
constexpr std::uint16_t kMotorPwm = 660;  // what Slamtec's own tools use, about 10 turns/s on an A2
constexpr std::uint32_t kMostModes = 16;

void pause(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

template <std::size_t N>
std::array<std::uint8_t, N> fixed(const std::vector<std::uint8_t>& packet) {
  std::array<std::uint8_t, N> result{};
  std::copy_n(packet.begin(), std::min(N, packet.size()), result.begin());
  return result;
}

std::optional<ScanFormat> format_of(std::uint32_t answer_type) {
  switch (answer_type) {
    case 0x81:
      return ScanFormat::kStandard;
    case 0x82:
      return ScanFormat::kExpress;
    case 0x85:
      return ScanFormat::kDense;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::vector<std::uint8_t> RplidarDevice::ask(RplidarCommand command,
                                             const std::vector<std::uint8_t>& request) {
  port_.write(request);
  AnswerParser parser(command);
  std::array<std::uint8_t, 512> bytes{};
  const auto deadline = Clock::now() + std::chrono::milliseconds(answer_timeout_ms_);
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) break;
    const std::size_t n = port_.read(bytes.data(), bytes.size(), static_cast<int>(left));
    if (!parser.add(bytes.data(), n)) continue;
    descriptor_ = parser.descriptor();
    rest_ = parser.rest();
    return descriptor_.send_mode == 0 ? parser.packet() : std::vector<std::uint8_t>();
  }
  throw DeviceError(std::string("no answer to ") + to_string(command) + " within " +
                    std::to_string(answer_timeout_ms_) + " ms; came: " + parser.seen());
}

RplidarInfo RplidarDevice::info() {
  return decode_info(
      fixed<20>(ask(RplidarCommand::kGetInfo, encode_request(RplidarCommand::kGetInfo))));
}

RplidarHealth RplidarDevice::health() {
  return decode_health(
      fixed<3>(ask(RplidarCommand::kGetHealth, encode_request(RplidarCommand::kGetHealth))));
}

std::optional<std::vector<std::uint8_t>> RplidarDevice::conf(RplidarConf entry,
                                                             std::optional<std::uint16_t> mode) {
  return decode_conf(entry, ask(RplidarCommand::kGetConf, encode_conf_request(entry, mode)));
}

std::vector<ScanMode> RplidarDevice::modes_by_conf() {
  const auto count = conf(RplidarConf::kModeCount);
  if (!count) throw DeviceError("GET_LIDAR_CONF was answered with another entry");
  std::vector<ScanMode> modes;
  const std::uint32_t n = std::min(little_endian(*count, 2), kMostModes);
  for (std::uint16_t id = 0; id < n; ++id) {
    const auto type = conf(RplidarConf::kModeAnswerType, id);
    const auto period = conf(RplidarConf::kModeUsPerSample, id);
    const auto name = conf(RplidarConf::kModeName, id);
    if (!type || !period || !name)
      throw DeviceError("GET_LIDAR_CONF was answered with another entry");
    const auto format = format_of(little_endian(*type, 1));
    const double period_s = little_endian(*period, 4) / 256.0 * 1e-6;
    if (!format || period_s < 1e-5 || period_s > 0.01) continue;
    const auto end = std::find(name->begin(), name->end(), 0);
    modes.push_back(
        {std::string(name->begin(), end), *format, static_cast<std::uint8_t>(id), period_s});
  }
  return modes;
}

std::vector<ScanMode> RplidarDevice::scan_modes(const RplidarInfo& info) {
  // The firmware of C1 and S models counts from 1.00 and has always known GET_LIDAR_CONF.
  if (info.series() >= 4 || info.firmware_at_least(1, 24)) {
    auto modes = modes_by_conf();
    if (!modes.empty()) return modes;
  }
  if (!info.firmware_at_least(1, 17)) return {ScanMode{}};
  const RplidarSampleRate rate = decode_sample_rate(fixed<4>(
      ask(RplidarCommand::kGetSampleRate, encode_request(RplidarCommand::kGetSampleRate))));
  if (rate.standard_us < 10 || rate.express_us < 10)
    throw DeviceError("GET_SAMPLERATE was answered with " + std::to_string(rate.standard_us) +
                      " and " + std::to_string(rate.express_us) + " us: that can't be");
  return {{"Standard", ScanFormat::kStandard, 0, rate.standard_us * 1e-6},
          {"Express", ScanFormat::kExpress, 0, rate.express_us * 1e-6}};
}

std::vector<std::uint8_t> RplidarDevice::start_scan(const ScanMode& mode) {
  if (mode.format == ScanFormat::kStandard) {
    ask(RplidarCommand::kScan, encode_request(RplidarCommand::kScan));
  } else {
    ask(RplidarCommand::kExpressScan,
        encode_request(RplidarCommand::kExpressScan, {mode.id, 0, 0, 0, 0}));
    if (format_of(descriptor_.type) != mode.format)
      throw DeviceError("EXPRESS_SCAN was answered in another format than asked for: " +
                        to_string(descriptor_));
  }
  return rest_;
}

void RplidarDevice::stop() {
  port_.write(encode_request(RplidarCommand::kStop));
  pause(kAfterStopMs);
  port_.discard_input();
}

void RplidarDevice::reset() { port_.write(encode_request(RplidarCommand::kReset)); }

void RplidarDevice::set_motor(bool on, const RplidarInfo& info) {
  const bool hangs_on_dtr = info.series() <= 1;
  port_.set_dtr(!on && hangs_on_dtr);
  if (info.series() != 2 && info.series() != 3) return;
  try {
    const auto flags = ask(RplidarCommand::kGetAccessoryBoard,
                           encode_request(RplidarCommand::kGetAccessoryBoard, {0, 0, 0, 0}));
    if ((flags.at(0) & 1U) == 0) return;
  } catch (const DeviceError&) {
    return;  // wired without the board: whoever did that drives the motor
  }
  const std::uint16_t pwm = on ? kMotorPwm : 0;
  port_.write(encode_request(RplidarCommand::kSetMotorPwm, {static_cast<std::uint8_t>(pwm & 0xFF),
                                                            static_cast<std::uint8_t>(pwm >> 8)}));
}

ScanMode choose_mode(const std::vector<ScanMode>& modes, const std::string& wish) {
  const ScanMode* best = nullptr;
  std::string offered;
  for (const ScanMode& mode : modes) {
    offered += (offered.empty() ? "" : ", ") + mode.name + " (" + to_string(mode.format) + ")";
    if (wish != "auto" && wish != to_string(mode.format)) continue;
    if (best == nullptr || mode.sample_period_s < best->sample_period_s) best = &mode;
  }
  if (best == nullptr)
    throw DeviceError("it has no " + wish + " scan; it offers " + offered +
                      ": change scan_mode, or leave it at auto");
  return *best;
}

}  // namespace fusion_slam
