#include "libs/datasets/carmen.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr std::int64_t kMaxBeams = 100'000;

// Reads words off a line; after the first word that does not fit every further read gives 0 and
// ok() stays false.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view word() {
    const std::string_view word = next_word(&rest_);
    if (word.empty()) fail("line ends early");
    return word;
  }
  double number() {
    const auto value = parse_number(word());
    if (!value) fail("not a number");
    return value.value_or(0.0);
  }
  std::int64_t count() {
    const auto value = parse_integer(word());
    if (!value || *value < 0 || *value > kMaxBeams) fail("number of readings is not usable");
    return ok() ? *value : 0;
  }
  std::int64_t time_us() {
    const auto value = parse_seconds_us(word());
    if (!value) fail("time stamp is not a number");
    return value.value_or(0);
  }
  SE2 pose() {
    SE2 p;
    p.x = number();
    p.y = number();
    p.yaw = wrap_angle(number());
    return p;
  }
  std::vector<float> readings() {
    const std::int64_t n = count();
    std::vector<float> values;
    // A reading takes at least two characters: a count beyond the line is damage, not a reason to
    // allocate.
    if (static_cast<std::size_t>(n) > rest_.size()) fail("line ends early");
    for (std::int64_t i = 0; i < n && ok(); ++i)
      values.push_back(static_cast<float>(std::clamp(number(), -1e9, 1e9)));
    return values;
  }
  void fail(const char* why) {
    if (why_.empty()) why_ = why;
  }
  bool ok() const { return why_.empty(); }
  const std::string& why() const { return why_; }

 private:
  std::string_view rest_;
  std::string why_;
};

double deg(double degrees) { return degrees * M_PI / 180.0; }

// FLASER names no angles. CARMEN's lasers are SICK LMS/PLS: 180 degrees at 1 or 0.5 degree, or 100
// at 0.25, from right to left; an even count means that the last beam was left out. Other counts
// are spread over 180 degrees.
void sick_angles(std::size_t n, LaserScan* scan) {
  const bool last_missing = n == 180 || n == 360 || n == 400;
  const double fov = (n == 400 || n == 401) ? deg(100.0) : M_PI;
  const auto steps = static_cast<double>(last_missing ? n : n - 1);
  scan->rad0 = -0.5 * fov;
  scan->radstep = fov / steps;
}

bool sane(const SE2& p) {
  return std::abs(p.x) < 1e7 && std::abs(p.y) < 1e7;  // kilometres by the thousand are damage
}

CarmenScan parse_flaser(Words* words) {
  CarmenScan s;
  s.scan.ranges_m = words->readings();
  if (words->ok() && s.scan.ranges_m.size() < 2) words->fail("fewer than 2 readings");
  if (words->ok()) sick_angles(s.scan.ranges_m.size(), &s.scan);
  s.laser_pose = words->pose();
  s.odom_pose = words->pose();
  s.scan.utime_us = words->time_us();
  return s;
}

CarmenScan parse_raw_or_robot_laser(Words* words, bool robot) {
  CarmenScan s;
  words->number();  // laser type
  s.scan.rad0 = words->number();
  const double fov = words->number();
  s.scan.radstep = words->number();
  for (int i = 0; i < 3; ++i) words->number();  // maximum range, accuracy, remission mode
  s.scan.ranges_m = words->readings();
  s.scan.intensities = words->readings();
  const std::size_t n = s.scan.ranges_m.size();
  if (words->ok() && n < 2) words->fail("fewer than 2 readings");
  if (words->ok() && s.scan.radstep == 0.0) s.scan.radstep = fov / static_cast<double>(n - 1);
  if (words->ok() && (s.scan.radstep == 0.0 || std::abs(s.scan.radstep) > M_PI ||
                      std::abs(s.scan.rad0) > 4.0 * M_PI))
    words->fail("angles are not usable");
  if (s.scan.intensities.size() != n) s.scan.intensities.clear();
  if (robot) {
    s.laser_pose = words->pose();
    s.odom_pose = words->pose();
    for (int i = 0; i < 5; ++i) words->number();  // speeds and safety distances
  }
  s.scan.utime_us = words->time_us();
  return s;
}

// One list a kind: a log may hold the same sweep as RAWLASER1, ROBOTLASER1 and FLASER.
enum Kind { kRobotLaser, kFlaser, kRawLaser, kKinds };

struct Parser {
  CarmenLog log;
  std::vector<CarmenScan> scans[kKinds];

  void keep_scan(Kind kind, CarmenScan s, Words* words) {
    if (words->ok() &&
        ((s.laser_pose && !sane(*s.laser_pose)) || !sane(s.odom_pose.value_or(SE2{}))))
      words->fail("pose is not plausible");
    if (!words->ok()) return;
    s.line = log.lines;
    scans[kind].push_back(std::move(s));
  }

  void parse_line(std::string_view line) {
    const std::string_view keyword = next_word(&line);
    Words words(line);
    if (keyword.empty() || keyword.front() == '#') return;
    if (keyword == "FLASER") {
      keep_scan(kFlaser, parse_flaser(&words), &words);
    } else if (keyword == "ROBOTLASER1" || keyword == "RAWLASER1") {
      const bool robot = keyword == "ROBOTLASER1";
      keep_scan(robot ? kRobotLaser : kRawLaser, parse_raw_or_robot_laser(&words, robot), &words);
    } else if (keyword == "ODOM") {
      CarmenOdometry odometry;
      odometry.line = log.lines;
      odometry.pose = words.pose();
      for (int i = 0; i < 3; ++i) words.number();  // speeds, acceleration
      odometry.utime_us = words.time_us();
      if (words.ok() && !sane(odometry.pose)) words.fail("pose is not plausible");
      if (words.ok()) log.odometry.push_back(odometry);
    } else if (keyword == "PARAM") {
      const std::string name(words.word());
      const std::string value(words.word());
      if (words.ok()) log.params[name] = value;
    } else if (keyword == "NEFF") {
      ++log.neff_lines;
    } else {
      const bool name = keyword.size() <= 32 &&
                        keyword.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789") ==
                            std::string_view::npos;
      if (name)
        ++log.ignored[std::string(keyword)];
      else
        log.skipped.add(log.lines, "not a CARMEN message");
    }
    if (!words.ok()) log.skipped.add(log.lines, std::string(keyword) + ": " + words.why());
  }
};

}  // namespace

std::optional<double> CarmenLog::front_laser_offset_m() const {
  const auto param = params.find("robot_frontlaser_offset");
  return param == params.end() ? std::nullopt : parse_number(param->second);
}

std::vector<CarmenOdometry> CarmenLog::raw_odometry() const {
  if (poses_corrected()) return {};
  std::vector<CarmenOdometry> result;
  bool moves = false;
  for (const CarmenScan& s : scans) {
    if (!s.odom_pose) continue;
    result.push_back({s.line, s.scan.utime_us, *s.odom_pose});
    const SE2& first = result.front().pose;
    const SE2& p = *s.odom_pose;
    moves = moves || p.x != first.x || p.y != first.y || p.yaw != first.yaw;
  }
  if (moves || odometry.empty()) return result;
  result.clear();
  for (const CarmenOdometry& o : odometry)
    if (result.empty() || o.utime_us > result.back().utime_us) result.push_back(o);
  return result;
}

CarmenLog parse_carmen(std::string_view text) {
  Parser parser;
  std::string_view line;
  while (next_line(&text, &line)) {
    ++parser.log.lines;
    parser.parse_line(line);
  }
  CarmenLog& log = parser.log;
  for (int kind = 0; kind < kKinds; ++kind) {
    auto& scans = parser.scans[kind];
    if (scans.empty()) continue;
    if (!log.scans.empty()) {
      static const char* const kNames[] = {"ROBOTLASER1", "FLASER", "RAWLASER1"};
      log.ignored[kNames[kind]] += static_cast<std::int64_t>(scans.size());
      continue;
    }
    for (CarmenScan& s : scans) {
      if (log.scans.empty() || s.scan.utime_us > log.scans.back().scan.utime_us)
        log.scans.push_back(std::move(s));
      else
        log.skipped.add(s.line, "scan: time stamp does not increase");
    }
  }
  return std::move(parser.log);
}

CarmenLog read_carmen(const std::filesystem::path& path) {
  CarmenLog log = parse_carmen(read_text_file(path));
  if (!log.scans.empty()) return log;
  std::string message = path.string() + ": no usable FLASER, ROBOTLASER1 or RAWLASER1 line in " +
                        std::to_string(log.lines) + " lines";
  for (const auto& [reason, entry] : log.skipped.reasons())
    message += "; line " + std::to_string(entry.first_place) + ": " + reason;
  throw DatasetError(message + "; is this a CARMEN log?");
}

}  // namespace fusion_slam
