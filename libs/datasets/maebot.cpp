#include "libs/datasets/maebot.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "libs/eventlog/reader.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint64_t kLaserScan = 0x89dc5b879a5056cf;
constexpr std::uint64_t kMotorFeedback = 0x8dc5a028fca42ff9;
constexpr std::uint64_t kPose = 0x1f317af1246276ac;
// Before the year 2000 or after 2100: the first pose of a recording has a time that was never set.
constexpr std::int64_t kEarliestUs = 946'684'800'000'000;
constexpr std::int64_t kLatestUs = 4'102'444'800'000'000;

// Big-endian numbers off a byte string; after its end every number is 0 and ok() is false.
class BigEndian {
 public:
  explicit BigEndian(const std::vector<std::uint8_t>& bytes) : bytes_(bytes) {}
  std::uint64_t take(std::size_t n) {
    if (bytes_.size() - at_ < n) {
      ok_ = false;
      at_ = bytes_.size();
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; ok_ && i < n; ++i) value = (value << 8) | bytes_[at_++];
    return value;
  }
  std::int64_t i64() { return static_cast<std::int64_t>(take(8)); }
  std::int32_t i32() { return static_cast<std::int32_t>(static_cast<std::uint32_t>(take(4))); }
  float f32() {
    const auto bits = static_cast<std::uint32_t>(take(4));
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::vector<float> floats(std::size_t n) {
    std::vector<float> values(n);
    for (float& v : values) v = f32();
    return values;
  }
  bool ok() const { return ok_; }
  std::size_t left() const { return bytes_.size() - at_; }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

bool time_ok(std::int64_t utime_us) { return utime_us > kEarliestUs && utime_us < kLatestUs; }

// Why the sweep is not usable; empty when it is.
std::string parse_sweep(BigEndian* in, MaebotSweep* sweep) {
  sweep->utime_us = in->i64();
  const std::int32_t n = in->i32();
  if (n < 0 || in->left() != static_cast<std::size_t>(n) * 20) return "length does not fit";
  const auto count = static_cast<std::size_t>(n);
  sweep->ranges_m = in->floats(count);
  sweep->thetas_rad = in->floats(count);
  sweep->times_us.resize(count);
  for (std::int64_t& t : sweep->times_us) t = in->i64();
  sweep->intensities = in->floats(count);
  if (count < 8) return "fewer than 8 beams";
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(sweep->thetas_rad[i]) || std::abs(sweep->thetas_rad[i]) > 100.0F)
      return "an angle is not a number";
    if (!time_ok(sweep->times_us[i])) return "time stamp was never set";
  }
  return time_ok(sweep->utime_us) ? "" : "time stamp was never set";
}

// Appends in order of time.
template <typename T>
std::string append(T item, std::int64_t utime_us, std::vector<T>* list) {
  if (!time_ok(utime_us)) return "time stamp was never set";
  if (!list->empty() && utime_us <= list->back().utime_us) return "time stamp does not increase";
  list->push_back(std::move(item));
  return "";
}

std::string add_known(std::uint64_t fingerprint, BigEndian* in, MaebotLog* log) {
  if (fingerprint == kLaserScan) {
    MaebotSweep sweep;
    std::string why = parse_sweep(in, &sweep);
    if (!why.empty()) return why;
    const std::int64_t utime_us = sweep.utime_us;
    return append(std::move(sweep), utime_us, &log->sweeps);
  }
  if (fingerprint == kMotorFeedback) {
    WheelTicks ticks;
    ticks.utime_us = in->i64();
    ticks.left = in->i32();
    ticks.right = in->i32();
    return in->ok() ? append(ticks, ticks.utime_us, &log->encoders) : "length does not fit";
  }
  MaebotPose pose;
  pose.utime_us = in->i64();
  pose.pose.x = in->f32();
  pose.pose.y = in->f32();
  pose.pose.yaw = in->f32();
  if (!in->ok()) return "length does not fit";
  if (!std::isfinite(pose.pose.x + pose.pose.y + pose.pose.yaw)) return "not a number";
  pose.pose.yaw = wrap_angle(pose.pose.yaw);
  return append(pose, pose.utime_us, &log->poses);
}

// Angles without the jump from 2 pi to 0.
std::vector<double> unwrapped(const std::vector<float>& thetas_rad) {
  std::vector<double> result;
  result.reserve(thetas_rad.size());
  for (const float theta : thetas_rad)
    result.push_back(result.empty() ? theta : result.back() + wrap_angle(theta - result.back()));
  return result;
}

}  // namespace

bool add_maebot_event(const LogEvent& event, MaebotLog* log) {
  ++log->events;
  BigEndian in(event.data);
  const std::uint64_t fingerprint = in.take(8);
  if (fingerprint != kLaserScan && fingerprint != kMotorFeedback && fingerprint != kPose) {
    ++log->ignored[event.channel];
    return true;
  }
  const std::string why = add_known(fingerprint, &in, log);
  if (!why.empty()) log->skipped.add(event.offset_bytes, event.channel + ": " + why);
  return why.empty();
}

MaebotLog read_maebot(const std::filesystem::path& path) {
  LogReader reader(path);
  MaebotLog log;
  LogEvent event;
  for (;;) {
    while (reader.next(&event)) add_maebot_event(event, &log);
    if (!reader.damage()) break;
    log.skipped.add(
        reader.damage()->offset_bytes,
        "event log: " + std::string(reader.damage()->at_end ? "ends within an event" : "damaged"));
    if (!reader.resync()) break;
  }
  if (log.sweeps.empty())
    throw DatasetError(path.string() + ": none of its " + std::to_string(log.events) +
                       " events is a MAEBot laser scan (fingerprint 89dc5b879a5056cf); an LCM log "
                       "of other types needs no import");
  return log;
}

double MaebotLog::beam_period_s() const {
  std::vector<double> periods;
  for (const MaebotSweep& s : sweeps)
    periods.push_back(1e-6 * static_cast<double>(s.times_us.back() - s.times_us.front()) /
                      static_cast<double>(s.times_us.size() - 1));
  if (periods.empty()) return 0.0;
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

LaserScan to_laser_scan(const MaebotSweep& sweep) {
  const std::size_t n = sweep.ranges_m.size();
  const std::vector<double> theta = unwrapped(sweep.thetas_rad);
  const double step = 2.0 * M_PI / static_cast<double>(n);
  LaserScan scan;
  scan.utime_us = sweep.utime_us;
  scan.rad0 = -theta[0];
  scan.radstep = -step;
  scan.ranges_m.assign(n, 0.0F);
  scan.intensities.assign(n, 0.0F);
  // Two returns are of one surface when they differ by less than a wall does that is seen at 75
  // degrees from its normal.
  const double one_surface = step * std::tan(75.0 * M_PI / 180.0);
  const double reach = 1.5 * step;  // a gap of up to three beams is filled
  std::size_t i = 0;                // theta[i] <= wanted < theta[i + 1]
  for (std::size_t k = 0; k < n; ++k) {
    const double wanted = theta[0] + static_cast<double>(k) * step;
    while (i + 1 < n && theta[i + 1] <= wanted) ++i;
    const std::size_t j = std::min(i + 1, n - 1);
    const double before = wanted - theta[i];
    const double after = theta[j] - wanted;
    const std::size_t nearest = std::abs(after) < std::abs(before) ? j : i;
    if (std::min(std::abs(before), std::abs(after)) > reach) continue;
    const double a = sweep.ranges_m[i];
    const double b = sweep.ranges_m[j];
    const bool interpolate = a > 0.0 && b > 0.0 && before >= 0.0 && after > 0.0 &&
                             std::abs(a - b) < one_surface * std::min(a, b);
    scan.ranges_m[k] = interpolate ? static_cast<float>((a * after + b * before) / (before + after))
                                   : sweep.ranges_m[nearest];
    scan.intensities[k] = sweep.intensities[nearest];
  }
  return scan;
}

}  // namespace fusion_slam
