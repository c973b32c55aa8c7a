#include <cstdio>
#include <ctime>
#include <iostream>

#include "libs/map_directory/map_reader.hpp"
#include "logplayer/map/commands.hpp"

namespace fusion_slam {
namespace {

std::string utc(std::int64_t utime_us) {
  const std::time_t seconds = static_cast<std::time_t>(utime_us / 1'000'000);
  std::tm parts{};
  char text[64] = "an unknown time";
  if (gmtime_r(&seconds, &parts) != nullptr)
    std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts);
  return text;
}

}  // namespace

std::string describe(const MapSummary& s) {
  char text[800];
  std::snprintf(
      text, sizeof text,
      "a map by %s%s%s of %s, %.3g m cells\n"
      "  %lld session%s, from %s to %s, %.1f m driven\n"
      "  %lld keyframes (%lld with images), %lld LiDAR nodes in %lld submaps, %lld loops closed\n"
      "  grid: %s, %.1f m2 free\n",
      s.has_lidar ? "LiDAR" : "", s.has_lidar && s.has_camera ? " and " : "",
      s.has_camera ? "camera" : "", s.robot.substr(0, 80).c_str(), s.resolution_m,
      static_cast<long long>(s.sessions), s.sessions == 1 ? "" : "s", utc(s.first_utime_us).c_str(),
      utc(s.last_utime_us).c_str(), s.path_length_m, static_cast<long long>(s.keyframes),
      static_cast<long long>(s.images), static_cast<long long>(s.lidar_nodes),
      static_cast<long long>(s.submaps), static_cast<long long>(s.loops),
      s.grid.empty() ? "none" : s.grid.c_str(), s.free_area_m2);
  return text;
}

int show_map(const MapOptions& options) {
  const MapReader reader(options.map);
  std::cout << options.map.string() << ": " << describe(reader.summary()) << "  format "
            << reader.manifest().format << ", every file whole:\n";
  for (const auto& [name, file] : reader.manifest().files) {
    char line[200];
    std::snprintf(line, sizeof line, "    %-22s %12lld bytes\n", name.substr(0, 100).c_str(),
                  static_cast<long long>(file.size_bytes));
    std::cout << line;
  }
  return 0;
}

}  // namespace fusion_slam
