#include "drivers/rplidar/driver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <map>
#include <thread>
#include <utility>

#include "drivers/rplidar/port_finder.hpp"
#include "libs/clock/clock.hpp"

namespace fusion_slam {
namespace {

constexpr int kReadMs = 20;
constexpr int kBootingMs = 80;    // a device that boots is asked often
constexpr int kMostFailures = 8;  // then other speeds and ports get their chance
constexpr std::int64_t kDroppedReport_us = 1'000'000;  // at most one report in this time
constexpr int kSlowRestarts =
    3;  // a slow motor is told to turn again after so many times no_turn_ms
constexpr double kBitsPerByte = 10.0;  // start and stop bit

std::string one_digit(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "a1" of "RPLIDAR A1M8, firmware ...".
std::string series_of(const RplidarInfo& info) {
  const std::string text = to_string(info);
  return lower(text.substr(std::string("RPLIDAR ").size(), 2));
}

}  // namespace

struct RplidarDriver::Watch {
  Us begin_us = 0;
  Us last_byte_us = 0;
  Us last_turn_us = 0;
  bool samples_came = false;
  std::int64_t damage = 0;       // bytes and turns that did not fit, up to the last look
  std::int64_t turn_damage = 0;  // the same at the last whole turn
  std::int64_t damaged_turns = 0;
};

RplidarDriver::RplidarDriver(RplidarConfig config, RplidarEvents events)
    : config_(std::move(config)), events_(std::move(events)) {}

RplidarDriver::~RplidarDriver() = default;

void RplidarDriver::run(const std::atomic<bool>& stop) {
  trouble_since_us_ = steady_us();
  while (!stop) {
    try {
      if (!port_) open_port();
      bring_up();
      scan(stop);
    } catch (const PortError& error) {
      port_.reset();
      trouble(error.what(), false);
    } catch (const DeviceError& error) {
      const std::string where = port_ ? port_->path() + ": " : "";
      if (!identified_ || ++failures_ >= kMostFailures) {
        port_.reset();
        ++attempt_;
        failures_ = 0;
      }
      trouble(where + error.what(), false);
    }
    for (int waited = 0; waited < config_.retry_ms && !stop; waited += 10)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  shut_down();
}

// The likely speed first, and again between any two others.
std::vector<int> RplidarDriver::bauds() const {
  if (config_.baud != 0) return {config_.baud};
  static const std::map<std::string, std::vector<int>> by_model = {
      {"", {115200, 256000, 460800, 1000000}},
      {"a1", {115200}},
      {"a2", {115200, 256000}},
      {"a3", {256000}},
      {"c1", {460800}},
      {"s1", {256000}},
      {"s2", {1000000}},
      {"s3", {1000000}}};
  const auto found = by_model.find(lower(config_.model));
  const std::vector<int>& all = found == by_model.end() ? by_model.at("") : found->second;
  const int first = known_baud_ != 0 ? known_baud_ : all.front();
  std::vector<int> order = {first};
  for (const int baud : all)
    if (baud != first) order.insert(order.end(), {baud, first});
  if (order.size() > 1) order.pop_back();
  return order;
}

void RplidarDriver::open_port() {
  identified_ = false;
  const std::vector<std::string> paths = ports_to_try(config_.port);
  if (paths.empty())
    throw PortError((config_.port.empty()
                         ? "no adapter of an RPLidar (CP210x, 10C4:EA60) is plugged in"
                         : "no port matches " + config_.port) +
                    "; " + describe_ports(serial_ports()) + "; name the port if it is another one");
  const std::vector<int> speeds = bauds();
  const auto n_speeds = static_cast<int>(speeds.size());
  const int which = attempt_ % (n_speeds * static_cast<int>(paths.size()));
  const std::string& path = paths[static_cast<std::size_t>(which / n_speeds)];
  try {
    port_ = std::make_unique<SerialPort>(path, speeds[static_cast<std::size_t>(which % n_speeds)]);
  } catch (const PortError&) {
    // The next port at once; the same one at the speed that is likeliest.
    attempt_ = paths.size() > 1 ? (which / n_speeds + 1) * n_speeds : 0;
    throw;
  }
}

void RplidarDriver::bring_up() {
  RplidarDevice device(*port_);
  port_->set_dtr(false);
  if (restart_asked_.exchange(false)) {
    device.reset();
    await_boot();
  }
  device.stop();
  try {
    info_ = device.info();
  } catch (const DeviceError& error) {
    if (identified_) throw;
    throw DeviceError(std::string("no RPLidar answers at ") + std::to_string(port_->baud()) +
                      " baud (" + error.what() + "); is it powered, is it the right port?");
  }
  if (!config_.model.empty() && lower(config_.model) != series_of(info_))
    throw DeviceError("it is a " + to_string(info_) + ", not a " + config_.model +
                      ": change the model in the configuration, or name another port");
  identified_ = true;
  known_baud_ = port_->baud();
  attempt_ = 0;
  check_health(&device);
  mode_ = choose_mode(device.scan_modes(info_), config_.scan_mode);
  device.set_motor(true, info_);
  first_bytes_ = device.start_scan(mode_);
  if (events_.on_mode) events_.on_mode(info_, mode_);
}

// An error stays until a RESET after its cause has gone.
void RplidarDriver::check_health(RplidarDevice* device) {
  for (int resets = 0;; ++resets) {
    const RplidarHealth health = device->health();
    if (health.status == 0) return;
    const std::string code = "error code " + std::to_string(health.error_code);
    if (health.status == 1) {
      trouble("the device warns of its health (" + code + "); it still scans", true);
      return;
    }
    const std::string why = "the device is in protection stop (health " +
                            std::to_string(health.status) + ", " + code +
                            "); RESET sent. If it stays: is the turning part blocked?";
    if (resets == 2) throw DeviceError(why);
    trouble(port_->path() + ": " + why, false);
    device->reset();
    await_boot();
  }
}

void RplidarDriver::await_boot() {
  RplidarDevice booting(*port_, kBootingMs);
  const Us deadline_us = steady_us() + config_.boot_ms * 1000LL;
  std::this_thread::sleep_for(std::chrono::milliseconds(kReadMs));
  for (;;) {
    try {
      booting.info();
      return;
    } catch (const DeviceError&) {
      if (steady_us() > deadline_us) throw;
    }
  }
}

void RplidarDriver::scan(const std::atomic<bool>& stop) {
  ScanParser parser(mode_.format, mode_.sample_period_s, kBitsPerByte / port_->baud());
  std::vector<Revolution> turns;
  std::array<std::uint8_t, 4096> bytes{};
  Watch watch;
  watch.begin_us = watch.last_byte_us = watch.last_turn_us = steady_us();
  parser.add(first_bytes_.data(), first_bytes_.size(), watch.begin_us, &turns);
  while (!stop && !restart_asked_) {
    const std::size_t n = port_->read(bytes.data(), bytes.size(), kReadMs);
    const Us now_us = steady_us();
    if (n > 0) watch.last_byte_us = now_us;
    parser.add(bytes.data(), n, now_us, &turns);
    take_turns(&turns, now_us, &watch);
    supervise(parser, now_us, &watch);
  }
  if (restart_asked_) throw DeviceError("restart asked for");
}

void RplidarDriver::take_turns(std::vector<Revolution>* turns, Us now_us, Watch* watch) {
  const std::int64_t to_wall_us = wall_us() - steady_us();
  for (Revolution& turn : *turns) {
    watch->last_turn_us = now_us;
    if (turn.period_s > 1.0 / config_.slowest_hz) {
      motor_trouble("the motor turns too slowly, " + one_digit(1.0 / turn.period_s) +
                    " turns/s, and at least " + one_digit(config_.slowest_hz) + " are needed");
      continue;
    }
    watch->turn_damage = watch->damage;
    failures_ = 0;
    for (Measurement& m : turn.measurements) m.utime_us += to_wall_us;
    if (!scanning_) well(turn, now_us);
    if (events_.on_turn) events_.on_turn(turn);
  }
  turns->clear();
}

void RplidarDriver::supervise(const ScanParser& parser, Us now_us, Watch* watch) {
  const ScanParserCounters& seen = parser.counters();
  watch->samples_came = watch->samples_came || seen.samples > 0;
  watch->damage = seen.skipped_bytes + seen.bad_packets + seen.incomplete;
  if (!watch->samples_came && now_us - watch->begin_us > config_.first_sample_ms * 1000LL)
    throw DeviceError("no measurement within " + one_digit(config_.first_sample_ms * 1e-3) +
                      " s of the scan's start (" + std::to_string(seen.bytes) +
                      " bytes came); does the motor turn?");
  if (watch->samples_came && now_us - watch->last_byte_us > config_.silence_ms * 1000LL)
    throw DeviceError("the device went silent: nothing for " + std::to_string(config_.silence_ms) +
                      " ms");
  if (seen.damaged + seen.incomplete > watch->damaged_turns) {
    watch->damaged_turns = seen.damaged + seen.incomplete;
    if (scanning_ && now_us - last_dropped_us_ > kDroppedReport_us) {
      last_dropped_us_ = now_us;
      trouble("turn dropped: bytes on the line were lost or changed (so far " +
                  std::to_string(watch->damaged_turns) + " turns, " +
                  std::to_string(seen.bad_packets) + " bad packets, " +
                  std::to_string(seen.skipped_bytes) + " bytes that fit nothing)",
              true);
    }
  }
  if (now_us - watch->last_turn_us < config_.no_turn_ms * 1000LL || !watch->samples_came) return;
  if (watch->damage != watch->turn_damage)
    throw DeviceError("no whole turn for " + one_digit(config_.no_turn_ms * 1e-3) +
                      " s: " + std::to_string(seen.skipped_bytes) + " bytes fit no packet, " +
                      std::to_string(seen.damaged) + " turns damaged, " +
                      std::to_string(seen.incomplete) + " not whole");
  motor_trouble("the motor stands or turns too slowly, no whole turn for " +
                one_digit(config_.no_turn_ms * 1e-3) + " s");
  if (now_us - watch->last_turn_us > kSlowRestarts * config_.no_turn_ms * 1000LL)
    throw DeviceError("the motor still stands; starting it again");
}

void RplidarDriver::trouble(const std::string& why, bool scans) {
  if (!scans && scanning_) {
    scanning_ = false;
    trouble_since_us_ = steady_us();
    last_trouble_.clear();
  }
  if (!scans && why == last_trouble_) return;
  if (!scans) last_trouble_ = why;
  if (events_.on_trouble) events_.on_trouble(why, scans);
}

// Once, although the numbers in it change from turn to turn.
void RplidarDriver::motor_trouble(const std::string& why) {
  if (last_trouble_.rfind("the motor", 0) == 0) return;
  trouble(why + "; is its supply weak or the turning part blocked?", false);
}

void RplidarDriver::well(const Revolution& turn, Us now_us) {
  std::string text = "scanning: " + to_string(info_) + ", at " + port_->path() + ", " + mode_.name +
                     " (" + to_string(mode_.format) + "), " + one_digit(1.0 / turn.period_s) +
                     " turns/s of " + std::to_string(turn.measurements.size()) + " measurements";
  if (!last_trouble_.empty())
    text +=
        "; again after " + one_digit(static_cast<double>(now_us - trouble_since_us_) * 1e-6) + " s";
  scanning_ = true;
  last_trouble_.clear();
  if (events_.on_well) events_.on_well(text);
}

void RplidarDriver::shut_down() {
  if (!port_) return;
  try {
    RplidarDevice device(*port_);
    device.stop();
    if (identified_) device.set_motor(false, info_);
  } catch (const std::exception&) {
    // It is gone: nothing left to stop.
  }
  port_.reset();
}

}  // namespace fusion_slam
