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

class Listener {
 public:
  explicit Listener(std::shared_ptr<Transport> transport);
  ~Listener();

  // Of the replay's own thread: events it has played.
  void sensor_event(const LogEvent& event);

  // True when everything that was published on the channels listened to is collected.
  bool has_all(const std::map<std::string, std::int64_t>& counts) const;

  // Writes what there is. Call after the processes were told to finish.
  SessionResult write(const std::filesystem::path& out);

 private:
  Bus bus_;
  std::mutex mutex_;  // of collector_
  SessionCollector collector_;
  std::vector<std::unique_ptr<TileReceiver>> tiles_;
  std::thread thread_;
};

}  // namespace fusion_slam
