// Messages of an LCM log, checked before they are decoded, and what their exporters share.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "libs/camera/camera_model.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/robot/robot_model.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {

// A log that can't be exported, or a place that can't be written to. what() names the file and what
// to do.
struct ExportError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The message of an event; nothing when its bytes are not one of this type.
template <class Message>
std::optional<Message> decode_event(const LogEvent& event) {
  const LcmType* type = peek_type(event.data.data(), event.data.size());
  if (type == nullptr || type->fingerprint != static_cast<std::uint64_t>(Message::getHash()) ||
      check(*type, event.data.data(), event.data.size()))
    return std::nullopt;
  Message message;
  const int n = message.decode(event.data.data(), 0, static_cast<int>(event.data.size()));
  if (n < 0) return std::nullopt;
  return message;
}

// The first ROBOT_MODEL and CAMERA_MODEL of a log: where its sensors sit.
struct LogModels {
  RobotModel robot;
  std::optional<CameraModel> camera;
};
// Throws ExportError when there is no usable ROBOT_MODEL: then no pose of the log can be
// interpreted.
LogModels read_models(const std::filesystem::path& log);

// Calls `handle` for every event of the named channels, in the order of the log; damaged places are
// jumped over. progress (may be empty): share of the file read, 0 to 1, about a hundred times.
void for_each_event(const std::filesystem::path& log,
                    const std::function<void(const LogEvent&)>& handle,
                    const std::function<void(double)>& progress);

// "1700000000.033333": microseconds as decimal seconds, nothing lost.
std::string seconds_text(std::int64_t utime_us);

struct ExportSummary {
  std::map<std::string, std::int64_t> written;  // what, and how many
  std::map<std::string, std::int64_t> skipped;  // why, and how many
};

// For people: "12 poses, 3 scans", and a line each of what was left out; ends with a line's end.
std::string summary_text(const ExportSummary& summary);

}  // namespace fusion_slam
