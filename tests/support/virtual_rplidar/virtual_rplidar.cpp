#include "tests/support/virtual_rplidar/virtual_rplidar.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "libs/clock/clock.hpp"

namespace fusion_slam {
namespace {

constexpr double kSlowHz = 0.8;
constexpr double kMishaps = 30.0;  // a second
constexpr double kFullLine = 1.05;
constexpr double kUsualPeriod_s = 500e-6;
constexpr auto kMostOnTheLine = std::chrono::milliseconds(100);
constexpr auto kBoot = std::chrono::milliseconds(300);
const char kBootText[] = "RP LIDAR System.\r\nFirmware Ver 1.29 - rc9, HW Ver 7\r\nModel: 18\r\n";

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(s));
}

}  // namespace

const char* to_string(VirtualFault fault) {
  static const char* const kNames[] = {"none",   "noise",  "loss",       "checksum",  "stall",
                                       "unplug", "health", "descriptor", "slow-motor"};
  return kNames[static_cast<int>(fault)];
}

std::vector<VirtualFault> virtual_faults() {
  std::vector<VirtualFault> all;
  for (int i = 1; i <= static_cast<int>(VirtualFault::kSlowMotor); ++i)
    all.push_back(static_cast<VirtualFault>(i));
  return all;
}

VirtualFault virtual_fault(const std::string& name) {
  for (const VirtualFault fault : virtual_faults())
    if (name == to_string(fault)) return fault;
  throw std::invalid_argument("no fault " + name);
}

VirtualRplidar::VirtualRplidar(VirtualRplidarOptions options)
    : options_(std::move(options)), model_(virtual_model(options_.model)), random_(options_.seed) {
  if (options_.world.turns.empty()) throw std::invalid_argument("a world without turns");
  if (options_.rate_hz <= 0.0) options_.rate_hz = options_.world.rate_hz;
  double n = 0.0;
  for (const VirtualTurn& turn : options_.world.turns) {
    first_sample_.push_back(n);
    n += static_cast<double>(turn.samples.size());
  }
  first_sample_.push_back(n);
  natural_period_s_ = static_cast<double>(options_.world.turns.size()) / (options_.rate_hz * n);
  // No more than the line carries: where the world has more, samples are passed over.
  standard_period_s_ =
      natural_period_s_ > kFullLine * 50.0 / model_.baud ? natural_period_s_ : kUsualPeriod_s;
  if (model_.has_board) motor_pwm_ = 0;
  plug_in();
  measured_until_ = Clock::now();
  if (options_.begin_us != 0)
    measured_until_ += std::chrono::microseconds(options_.begin_us - wall_us());
  boots_until_ = Clock::now();
  thread_ = std::thread([this] { run(); });
}

VirtualRplidar::~VirtualRplidar() {
  stop_ = true;
  thread_.join();
  unplug();
}

void VirtualRplidar::plug_in() {
  master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0)
    throw std::runtime_error("no pseudo-terminal");
  const std::string name = ptsname(master_);
  slave_ = open(name.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  tcgetattr(slave_, &settings);
  cfmakeraw(&settings);  // no echo
  tcsetattr(slave_, TCSANOW, &settings);
  std::filesystem::remove(options_.link);
  std::filesystem::create_symlink(name, options_.link);
}

void VirtualRplidar::unplug() {
  if (master_ < 0) return;
  std::error_code ignored;
  std::filesystem::remove(options_.link, ignored);
  close(slave_);
  close(master_);
  master_ = slave_ = -1;
}

void VirtualRplidar::set_fault(VirtualFault fault) {
  const std::lock_guard<std::mutex> lock(mutex_);
  enter_fault(fault);
}

void VirtualRplidar::enter_fault(VirtualFault fault) {
  if (fault == fault_) return;
  if (fault_ == VirtualFault::kUnplug) {
    plug_in();
    in_.clear();
    boots_until_ = Clock::now();
  }
  fault_ = fault;
  if (fault == VirtualFault::kUnplug || fault == VirtualFault::kStall) out_.clear();
  if (fault == VirtualFault::kUnplug) unplug();
  if (fault == VirtualFault::kHealth) protection_stop_ = true;
  if (fault == VirtualFault::kUnplug || fault == VirtualFault::kHealth ||
      fault == VirtualFault::kDescriptor)
    scanning_ = false;
}

void VirtualRplidar::run() {
  while (!stop_) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (master_ >= 0) read_requests();
      measure();
      transmit();
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void VirtualRplidar::read_requests() {
  sending_from_ = Clock::now();
  std::uint8_t bytes[256];
  const ssize_t n = read(master_, bytes, sizeof bytes);
  if (n <= 0 || fault_ == VirtualFault::kStall || Clock::now() < boots_until_) return;
  in_.insert(in_.end(), bytes, bytes + n);
  while (take_request()) {
  }
}

bool VirtualRplidar::take_request() {
  const auto start = std::find(in_.begin(), in_.end(), 0xA5);
  in_.erase(in_.begin(), start);
  if (in_.size() < 2) return false;
  const std::uint8_t command = in_[1];
  Bytes payload;
  std::size_t size = 2;
  if ((command & 0x80) != 0) {
    if (in_.size() < 3 || in_.size() < 4U + in_[2]) return false;
    size = 4U + in_[2];
    payload.assign(in_.begin() + 3, in_.begin() + 3 + in_[2]);
    std::uint8_t sum = 0;
    for (std::size_t i = 0; i < size; ++i) sum ^= in_[i];
    if (sum != 0) {
      ++bad_requests_;
      in_.erase(in_.begin());
      return true;
    }
  }
  in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(size));
  answer(command, payload);
  return true;
}

void VirtualRplidar::answer(std::uint8_t command, const Bytes& payload) {
  if (command != 0xF0) scanning_ = false;  // any request ends a scan
  const auto us = [](double s) { return static_cast<unsigned>(std::lround(s * 1e6)); };
  const unsigned standard_us = us(standard_period_s_);
  const unsigned express_us = us(standard_period_s_ / 2.0);
  switch (command) {
    case 0x25:
      return;
    case 0x40:
      boots_until_ = Clock::now() + kBoot;
      if (fault_ != VirtualFault::kHealth) protection_stop_ = false;
      in_.clear();
      send(Bytes(kBootText, kBootText + sizeof kBootText - 1));
      return;
    case 0x50:
      return send_answer(wire::info(model_), 0x04);
    case 0x52:
      if (protection_stop_) return send_answer({2, 0x07, 0x80}, 0x06);
      return send_answer({0, 0, 0}, 0x06);
    case 0x59:
      if (!model_.has_rates) break;
      return send_answer(
          {static_cast<std::uint8_t>(standard_us), static_cast<std::uint8_t>(standard_us >> 8),
           static_cast<std::uint8_t>(express_us), static_cast<std::uint8_t>(express_us >> 8)},
          0x15);
    case 0x84:
      if (!model_.has_conf || payload.size() < 4) break;
      return answer_conf(payload);
    case 0xFF:
      return send_answer({static_cast<std::uint8_t>(model_.has_board ? 1 : 0), 0, 0, 0}, 0xFF);
    case 0xF0:
      if (model_.has_board && payload.size() == 2) motor_pwm_ = payload[0] | (payload[1] << 8);
      return;
    case 0x20:
      return start_scan(0x81);
    case 0x82:
      if (!model_.has_rates || payload.size() != 5) break;
      return start_scan(model_.has_conf && payload[0] != 0 ? wire::answer_type(model_, payload[0])
                                                           : 0x82);
    default:
      break;
  }
  ++bad_requests_;
}

void VirtualRplidar::answer_conf(const Bytes& payload) {
  const std::uint32_t entry = payload[0] | (payload[1] << 8) | (payload[2] << 16);
  const unsigned mode = payload.size() >= 6 ? payload[4] | (payload[5] << 8U) : 0U;
  const Bytes value = wire::conf(model_, entry, mode, standard_period_s_, standard_period_s_ / 2.0);
  if (value.empty()) return;
  Bytes packet(payload.begin(), payload.begin() + 4);
  packet.insert(packet.end(), value.begin(), value.end());
  send_answer(packet, 0x20);
}

void VirtualRplidar::send_answer(const Bytes& payload, std::uint8_t type) {
  const bool wrong = fault_ == VirtualFault::kDescriptor;
  Bytes bytes = wire::descriptor(static_cast<std::uint32_t>(payload.size()), false,
                                 wrong ? type ^ 0x33 : type);
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  send(bytes);
}

void VirtualRplidar::start_scan(std::uint8_t type) {
  if (protection_stop_ || (type != 0x81 && type != 0x82 && type != 0x85)) return;
  const bool wrong = fault_ == VirtualFault::kDescriptor;
  send(wire::descriptor(type == 0x81 ? 5 : 84, true, wrong ? type ^ 0x33 : type));
  scanning_ = !wrong;
  type_ = type;
  sample_period_s_ = type == 0x81 ? standard_period_s_ : standard_period_s_ / 2.0;
  capsule_.clear();
  first_packet_ = true;
}

double VirtualRplidar::step() const {
  if (motor_pwm_ == 0) return 0.0;
  const double usual = sample_period_s_ / natural_period_s_;
  return fault_ == VirtualFault::kSlowMotor ? usual * kSlowHz / options_.rate_hz : usual;
}

wire::Sample VirtualRplidar::next_sample() {
  const double n = first_sample_.back();
  if (position_ >= n) position_ = std::fmod(position_, n);
  const auto after = std::upper_bound(first_sample_.begin(), first_sample_.end(), position_);
  const auto which = static_cast<std::size_t>(after - first_sample_.begin()) - 1;
  const VirtualTurn& turn = options_.world.turns[which];
  const double in_turn = position_ - first_sample_[which];
  const auto i = std::min(static_cast<std::size_t>(in_turn + 1e-9), turn.samples.size() - 1);
  const VirtualSample& source = turn.samples[i];
  const double sample_deg = 360.0 / static_cast<double>(turn.samples.size());
  wire::Sample sample;
  sample.raw_deg = in_turn * sample_deg;
  sample.angle_deg = sample.raw_deg + source.angle_deg - static_cast<double>(i) * sample_deg;
  sample.range_m = source.range_m;
  sample.quality = source.quality;
  sample.first = static_cast<int>(which) != last_turn_;
  last_turn_ = static_cast<int>(which);
  position_ += step();
  return sample;
}

// The world goes on while nobody scans.
void VirtualRplidar::measure() {
  const auto now = Clock::now();
  while (measured_until_ + seconds(sample_period_s_) <= now) {
    measured_until_ += seconds(sample_period_s_);
    sending_from_ = measured_until_;
    const wire::Sample sample = next_sample();
    if (!scanning_ || motor_pwm_ == 0) continue;
    if (type_ == 0x81) {
      send_packet(wire::standard_node(sample));
      continue;
    }
    capsule_.push_back(sample);
    if (capsule_.size() < (type_ == 0x82 ? 32U : 40U)) continue;
    send_packet(type_ == 0x82 ? wire::express_capsule(capsule_, first_packet_)
                              : wire::dense_capsule(capsule_, first_packet_));
    first_packet_ = false;
    capsule_.clear();
  }
}

void VirtualRplidar::send_packet(Bytes packet) {
  const double packets_per_s = 1.0 / (sample_period_s_ * (type_ == 0x81   ? 1
                                                          : type_ == 0x82 ? 32
                                                                          : 40));
  const bool mishap = once_in(std::max(1.0, packets_per_s / kMishaps));
  const auto where = [&] { return static_cast<std::ptrdiff_t>(random_() % packet.size()); };
  if (fault_ == VirtualFault::kNoise && mishap) {
    Bytes noise(1 + random_() % 8);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random_());
    packet.insert(packet.begin() + where(), noise.begin(), noise.end());
  }
  if (fault_ == VirtualFault::kLoss && mishap) {
    const auto begin = packet.begin() + where();
    packet.erase(begin, begin + std::min<std::ptrdiff_t>(1 + random_() % 3, packet.end() - begin));
  }
  if (fault_ == VirtualFault::kChecksum && once_in(10.0)) {
    if (type_ == 0x81)
      packet[1] ^= 1;
    else
      packet[static_cast<std::size_t>(where())] ^= static_cast<std::uint8_t>(1U << (random_() % 8));
  }
  send(packet);
}

void VirtualRplidar::send(const Bytes& bytes) {
  if (master_ < 0 || fault_ == VirtualFault::kStall) return;
  if (line_free_ > Clock::now() + kMostOnTheLine) return;  // its buffer is full
  const double byte_s = 10.0 / model_.baud;
  line_free_ =
      std::max(line_free_, sending_from_) + seconds(byte_s * static_cast<double>(bytes.size()));
  out_.push_back({line_free_, bytes});
}

void VirtualRplidar::transmit() {
  const auto now = Clock::now();
  for (; !out_.empty() && out_.front().arrives <= now; out_.pop_front()) {
    const Bytes& bytes = out_.front().bytes;
    // A UART does not wait: what nobody takes is lost.
    if (master_ >= 0 && write(master_, bytes.data(), bytes.size()) < 0) continue;
  }
}

}  // namespace fusion_slam
