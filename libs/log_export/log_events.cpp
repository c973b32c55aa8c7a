#include "libs/log_export/log_events.hpp"

#include <cinttypes>
#include <cstdio>

#include "libs/messages/models.hpp"

namespace fusion_slam {

LogModels read_models(const std::filesystem::path& log) {
  LogReader reader(log);
  LogEvent event;
  std::optional<RobotModel> robot;
  std::optional<CameraModel> camera;
  std::string why = "there is no ROBOT_MODEL";
  const auto wants_more = [&] { return !robot || (robot->has_camera && !camera); };
  while (wants_more() && (reader.next(&event) || reader.resync())) {
    if (event.channel == "ROBOT_MODEL" && !robot) {
      if (const auto message = decode_event<robot_model_t>(event))
        robot = from_message(*message, &why);
    } else if (event.channel == "CAMERA_MODEL" && !camera) {
      std::string ignored;
      if (const auto message = decode_event<camera_model_t>(event))
        camera = from_message(*message, &ignored);
    }
    event.channel.clear();  // resync() leaves the last event as it was
  }
  if (!robot)
    throw ExportError(log.string() + ": " + why +
                      "; export works on logs of `fusion-slam import`, `simulate` or our drivers");
  return {*robot, camera};
}

void for_each_event(const std::filesystem::path& log,
                    const std::function<void(const LogEvent&)>& handle,
                    const std::function<void(double)>& progress) {
  LogReader reader(log);
  LogEvent event;
  int shown = -1;
  for (;;) {
    if (reader.next(&event))
      handle(event);
    else if (!reader.resync())
      break;
    const double share =
        static_cast<double>(reader.offset_bytes()) / static_cast<double>(reader.size_bytes());
    if (progress && static_cast<int>(100.0 * share) != shown) {
      shown = static_cast<int>(100.0 * share);
      progress(share);
    }
  }
}

std::string seconds_text(std::int64_t utime_us) {
  const std::int64_t seconds = utime_us / 1'000'000, rest = utime_us % 1'000'000;
  char text[48];
  std::snprintf(text, sizeof text, "%s%" PRId64 ".%06" PRId64, utime_us < 0 ? "-" : "",
                seconds < 0 ? -seconds : seconds, rest < 0 ? -rest : rest);
  return text;
}

std::string summary_text(const ExportSummary& summary) {
  std::string text;
  for (const auto& [what, count] : summary.written)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + what;
  text += "\n";
  for (const auto& [why, count] : summary.skipped)
    text += "  left out: " + std::to_string(count) + " " + why + "\n";
  return text;
}

}  // namespace fusion_slam
