#include "libs/log_export/carmen_export.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "libs/maps/atomic_file.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr double kNoReturnM = 81.91;
constexpr double kDegree = M_PI / 180.0;
constexpr const char* kHost = "fusion-slam";

float reading(float range_m, const LidarModel& lidar) {
  const bool hit = std::isfinite(range_m) && range_m >= lidar.range_min_m &&
                   range_m <= lidar.range_max_m && range_m > 0.0F;
  return hit ? range_m : static_cast<float>(kNoReturnM);
}

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, " %.6f", value);
  return text;
}

std::string readings(const std::vector<float>& ranges_m) {
  std::string text = " " + std::to_string(ranges_m.size());
  char one[24];
  for (const float r : ranges_m) {
    std::snprintf(one, sizeof one, " %.3f", static_cast<double>(r));
    text += one;
  }
  return text;
}

std::string pose(const SE2& p) { return number(p.x) + number(p.y) + number(p.yaw); }

// The log's clock starts at its first event, as CARMEN's logger's does.
std::string times(std::int64_t utime_us, std::int64_t start_us) {
  return " " + seconds_text(utime_us) + " " + kHost + " " + seconds_text(utime_us - start_us) +
         "\n";
}

class CarmenWriter {
 public:
  CarmenWriter(const std::filesystem::path& log, const CarmenExportOptions& options)
      : models_(read_models(log)), options_(options) {}

  void handle(const LogEvent& event) {
    if (event.channel == "ODOMETRY") on_odometry(event);
    if (event.channel == "LIDAR") on_lidar(event);
  }

  std::string finish(const std::filesystem::path& log) {
    if (scans_.empty())
      throw ExportError(log.string() + ": holds no usable LIDAR sweep; CARMEN logs are for lasers");
    start_us_ = scans_.front().utime_us;
    if (!odometry_.empty()) start_us_ = std::min(start_us_, odometry_.begin()->first);
    std::multimap<std::int64_t, std::string> lines;
    for (auto it = odometry_.begin(); it != odometry_.end(); ++it)
      lines.emplace(it->first, odometry_line(it));
    for (const LaserScan& scan : scans_) {
      const auto [utime_us, line] = scan_line(scan);
      lines.emplace(utime_us, line);
    }
    std::string text = "# CARMEN log of " + log.filename().string() + " by fusion-slam export\n";
    for (const auto& [utime_us, line] : lines) text += line;
    summary.written["sweeps"] = static_cast<std::int64_t>(scans_.size());
    summary.written["odometry poses"] = static_cast<std::int64_t>(odometry_.size());
    return text;
  }

  ExportSummary summary;

 private:
  using Odometry = std::map<std::int64_t, SE2>;

  void on_odometry(const LogEvent& event) {
    const auto message = decode_event<bot_core::pose_t>(event);
    const auto T_odom_base = message ? from_message(*message) : std::nullopt;
    if (T_odom_base)
      odometry_[message->utime] = to_se2(*T_odom_base);
    else
      ++summary.skipped["ODOMETRY: not a pose"];
  }
  void on_lidar(const LogEvent& event) {
    const auto message = decode_event<bot_core::planar_lidar_t>(event);
    std::string why = "LIDAR: not a message of its type";
    const auto scan = message ? from_message(*message, &why) : std::nullopt;
    if (scan && scan->ranges_m.size() >= 2 && scan->radstep != 0.0)
      scans_.push_back(*scan);
    else
      ++summary.skipped[why];
  }

  SE2 odometry_at(std::int64_t utime_us) const {
    if (odometry_.empty()) return {};
    const auto after = odometry_.lower_bound(utime_us);
    if (after == odometry_.begin()) return after->second;
    const auto before = std::prev(after);
    if (after == odometry_.end()) return before->second;
    const double share = static_cast<double>(utime_us - before->first) /
                         static_cast<double>(after->first - before->first);
    const SE2 &a = before->second, &b = after->second;
    return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y),
            wrap_angle(a.yaw + share * wrap_angle(b.yaw - a.yaw))};
  }

  std::string odometry_line(Odometry::const_iterator at) const {
    double speed_m_s = 0.0, turn_rad_s = 0.0;
    if (at != odometry_.begin()) {
      const auto before = std::prev(at);
      const SE2 T = before->second.inverse() * at->second;
      const double dt_s = 1e-6 * static_cast<double>(at->first - before->first);
      speed_m_s = T.x / dt_s;
      turn_rad_s = T.yaw / dt_s;
    }
    return "ODOM" + pose(at->second) + number(speed_m_s) + number(turn_rad_s) + number(0.0) +
           times(at->first, start_us_);
  }

  std::pair<std::int64_t, std::string> scan_line(const LaserScan& scan) const {
    const auto n = static_cast<double>(scan.ranges_m.size());
    const FrontHalf front = options_.full_sweep ? FrontHalf{{}, 0.5 * (n - 1.0)}
                                                : front_half(scan, models_.robot.lidar);
    const std::int64_t utime_us =
        scan.utime_us + std::llround(1e6 * front.middle_beam * models_.robot.lidar.beam_period_s);
    const SE2 T_odom_base = odometry_at(utime_us);
    const SE2 T_odom_lidar = T_odom_base * to_se2(models_.robot.T_base_lidar);
    if (!options_.full_sweep)
      return {utime_us, "FLASER" + readings(front.ranges_m) + pose(T_odom_lidar) +
                            pose(T_odom_base) + times(utime_us, start_us_)};
    std::vector<float> ranges;
    for (const float r : scan.ranges_m) ranges.push_back(reading(r, models_.robot.lidar));
    double first = scan.rad0;
    if (scan.radstep < 0.0) {
      std::reverse(ranges.begin(), ranges.end());
      first += (n - 1.0) * scan.radstep;
    }
    const double step = std::fabs(scan.radstep);
    return {utime_us, "ROBOTLASER1 0" + number(first) + number((n - 1.0) * step) + number(step) +
                          number(models_.robot.lidar.range_max_m) +
                          number(models_.robot.lidar.sigma_m) + " 0" + readings(ranges) + " 0" +
                          pose(T_odom_lidar) + pose(T_odom_base) + number(0.0) + number(0.0) +
                          number(0.0) + number(0.0) + number(0.0) + times(utime_us, start_us_)};
  }

  LogModels models_;
  CarmenExportOptions options_;
  std::int64_t start_us_ = 0;
  Odometry odometry_;
  std::vector<LaserScan> scans_;
};

// Whether FLASER readers would find the scan's own angles: -90 degrees, as many steps as fill 180.
bool is_front_half(const LaserScan& scan) {
  const auto n = static_cast<double>(scan.ranges_m.size());
  const bool last_missing = n == 180.0 || n == 360.0;
  const double step = M_PI / (last_missing ? n : n - 1.0);
  return n >= 180.0 && n <= 721.0 && n != 400.0 && n != 401.0 &&
         std::fabs(scan.rad0 + 0.5 * M_PI) < 1e-4 && std::fabs(scan.radstep - step) < 1e-6;
}

}  // namespace

FrontHalf front_half(const LaserScan& scan, const LidarModel& lidar) {
  FrontHalf front;
  const auto n = static_cast<int>(scan.ranges_m.size());
  if (is_front_half(scan)) {
    for (const float r : scan.ranges_m) front.ranges_m.push_back(reading(r, lidar));
    front.middle_beam = 0.5 * (n - 1);
    return front;
  }
  const int steps = std::fabs(scan.radstep) > 0.75 * kDegree ? 180 : 360;
  int used = 0;
  for (int k = 0; k <= steps; ++k) {
    const double angle = -0.5 * M_PI + k * M_PI / steps;
    float value = static_cast<float>(kNoReturnM);
    for (const double turn : {0.0, 2.0 * M_PI, -2.0 * M_PI}) {
      const auto beam = std::lround((angle + turn - scan.rad0) / scan.radstep);
      if (beam < 0 || beam >= n) continue;
      value = reading(scan.ranges_m[static_cast<std::size_t>(beam)], lidar);
      front.middle_beam += static_cast<double>(beam);
      ++used;
      break;
    }
    front.ranges_m.push_back(value);
  }
  if (used > 0) front.middle_beam /= used;
  return front;
}

ExportSummary export_carmen(const std::filesystem::path& log, const std::filesystem::path& file,
                            const CarmenExportOptions& options,
                            const std::function<void(double)>& progress) {
  CarmenWriter writer(log, options);
  for_each_event(
      log, [&](const LogEvent& event) { writer.handle(event); }, progress);
  const std::string text = writer.finish(log);
  write_file_atomically(file, text);
  return writer.summary;
}

}  // namespace fusion_slam
