// Listens to a run like any viewer and collects what its results are made of.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "libs/bus/bus.hpp"
#include "libs/bus/tile_channel.hpp"
#include "libs/eventlog/event.hpp"
#include "libs/session/session_collector.hpp"

namespace fusion_slam {

// What LOCALIZATION said, of a run on a saved map.
struct LocalizationSummary {
  std::string state;                    // the last: UNKNOWN, CANDIDATE or LOCALIZED, and why
  std::int64_t localized_utime_us = 0;  // when the robot was first found; 0: never
  std::int64_t times_lost = 0;          // LOCALIZED before, not any more
};

class Listener {
 public:
  explicit Listener(std::shared_ptr<Transport> transport);
  ~Listener();

  // Of the replay's own thread: events it has played.
  void sensor_event(const LogEvent& event);

  // True when everything that was published on the channels listened to is collected.
  bool has_all(const std::map<std::string, std::int64_t>& counts) const;

  LocalizationSummary localization() const;

  // Writes what there is. Call after the processes were told to finish.
  SessionResult write(const std::filesystem::path& out);

 private:
  Bus bus_;
  void on_localization(const pose_estimate_t& message);

  mutable std::mutex mutex_;  // of collector_ and localization_
  LocalizationSummary localization_;
  bool localized_ = false;
  SessionCollector collector_;
  std::vector<std::unique_ptr<TileReceiver>> tiles_;
  std::thread thread_;
};

}  // namespace fusion_slam
