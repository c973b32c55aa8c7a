#include "logplayer/import/timeline.hpp"

#include <algorithm>
#include <tuple>

#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kMarginUs = 100'000;

bool is_frame(const TimelineEvent& event) {
  return event.kind == EventKind::kLidar || event.kind == EventKind::kCamera;
}

}  // namespace

void Timeline::add_pose(EventKind kind, const std::string& channel, std::int64_t utime_us,
                        const SE3& T) {
  events.push_back({utime_us, kind, [=](LogOutput& out) {
                      out.write(utime_us, channel, to_pose_message(T, utime_us));
                      return std::string();
                    }});
}

void Timeline::add_scan(const LaserScan& scan) {
  events.push_back({scan.utime_us, EventKind::kLidar, [scan](LogOutput& out) {
                      out.write(scan.utime_us, "LIDAR", to_message(scan));
                      return std::string();
                    }});
}

void Timeline::sort() {
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) {
    return std::tie(a.utime_us, a.kind) < std::tie(b.utime_us, b.kind);
  });
}

void Timeline::keep_frames(std::int64_t start, std::int64_t max_frames) {
  std::vector<std::int64_t> times;
  for (const TimelineEvent& event : events)
    if (is_frame(event)) times.push_back(event.utime_us);
  const auto n = static_cast<std::int64_t>(times.size());
  const std::int64_t first = std::min(start, n);
  const std::int64_t end = max_frames < n - first ? first + max_frames : n;
  if (first >= end) {
    events.clear();
    return;
  }
  const std::int64_t from_us = times[static_cast<std::size_t>(first)];
  const std::int64_t to_us = times[static_cast<std::size_t>(end - 1)];
  std::int64_t frame = 0;
  const auto outside = [&](const TimelineEvent& event) {
    if (is_frame(event)) {
      const std::int64_t index = frame++;
      return index < first || index >= end;
    }
    return event.utime_us < from_us - kMarginUs || event.utime_us > to_us + kMarginUs;
  };
  std::vector<TimelineEvent> kept;
  for (TimelineEvent& event : events)
    if (!outside(event)) kept.push_back(std::move(event));
  events = std::move(kept);
}

double median_rate_hz(const std::vector<std::int64_t>& utimes_us) {
  std::vector<std::int64_t> gaps;
  for (std::size_t i = 1; i < utimes_us.size(); ++i)
    gaps.push_back(utimes_us[i] - utimes_us[i - 1]);
  if (gaps.empty()) return 0.0;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle > 0 ? 1e6 / static_cast<double>(*middle) : 0.0;
}

}  // namespace fusion_slam
