// Plays a recorded session into the viewer's state on a thread of its own: play, pause, speed,
// seek. Begins at the end, which is what people open a finished run for. Item "player" of
// Topic::kTime says where it is. Any thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "viz/web/protocol.hpp"
#include "viz/web/viewer_state.hpp"

namespace fusion_slam {

class Player {
 public:
  Player(std::filesystem::path log, ItemStore& store, ViewerState& state);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  // A request of kind kReplay. Returns at once.
  void handle(const Request& request);
  bool failed() const;

 private:
  void work();
  void play(class SessionReplay& session);
  void tell(const SessionReplay& session);
  void tell_loading(double fraction);

  const std::filesystem::path log_;
  ItemStore& store_;
  ViewerState& state_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  bool playing_ = false;
  bool failed_ = false;
  double speed_ = 1.0;
  std::optional<double> seek_s_;
  std::int64_t position_us_ = 0;
  std::thread thread_;  // last: uses the others
};

}  // namespace fusion_slam
