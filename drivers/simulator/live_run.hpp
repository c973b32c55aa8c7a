// A simulated run at the pace of the real clock, as drivers of real sensors would publish it.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "drivers/simulator/simulation.hpp"

namespace fusion_slam {

// When the machine is too slow, camera frames are left out at the source and counted: a frame goes
// out at most half a period after its time, or never. Each frame's rendering is begun ahead of its
// time; one that could not be ready, by the time that the ones before it took, is not begun.
class LiveRun {
 public:
  using Publish = std::function<void(const std::string& channel, const Bytes& bytes)>;
  // `publish` is called from two threads: one for CAMERA, one for all else.
  LiveRun(Simulation& simulation, int threads, Publish publish);

  // Renders a little for practice, then begins: utime of the start is the wall clock's. Returns at
  // the end of the run or after stop(). Once only.
  void run();
  void stop();  // any thread

  struct Progress {
    bool started = false;
    double time_s = 0.0;  // of the run
    std::int64_t frames_published = 0;
    std::int64_t frames_dropped = 0;
  };
  Progress progress() const;  // any thread

 private:
  std::int64_t now_us() const;
  bool wait_until(std::int64_t utime_us);  // false: stopped
  void render_frames();                    // of each worker
  void publish_frames();
  void publish_others();
  // mutex_ held: whether frame k would be ready in time when begun now.
  bool in_time(std::size_t k, std::int64_t now_us) const;

  Simulation& simulation_;
  int threads_;
  Publish publish_;
  std::int64_t half_period_us_;
  std::int64_t epoch_us_ = 0;
  std::int64_t steady_start_us_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::vector<Due> frames_;
  std::size_t next_ = 0;                               // frame to be begun
  std::size_t published_ = 0;                          // frames done with, one way or the other
  double cost_us_ = 0.0;                               // of a frame, lately
  std::map<std::size_t, std::optional<Bytes>> ready_;  // nothing: left out
  Progress progress_;
};

}  // namespace fusion_slam
