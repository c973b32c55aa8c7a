#include "logplayer/run/progress.hpp"

#include <cmath>
#include <cstdio>

#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr int kBarWidth = 40;

std::string bar(double fraction) {
  const int filled = static_cast<int>(std::lround(fraction * kBarWidth));
  return "[" + std::string(static_cast<std::size_t>(filled), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - filled), '.') + "]";
}

}  // namespace

Progress::Progress()
    : terminal_(isatty(STDERR_FILENO) != 0), started_(Clock::now()), last_(started_) {}

void Progress::show(double fraction, double log_s, const std::map<std::string, status_t>& processes,
                    bool last) {
  const auto now = Clock::now();
  const double wall_s = std::chrono::duration<double>(now - started_).count();
  const auto period =
      terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10'000);
  if (!last && now - last_ < period) return;
  last_ = now;
  if (terminal_ && lines_drawn_ > 0) std::fprintf(stderr, "\x1b[%zuA", lines_drawn_);
  std::fprintf(stderr, "%s %5.1f %%  log %.1f s  wall %.1f s  %.1fx%s\n", bar(fraction).c_str(),
               100.0 * fraction, log_s, wall_s, log_s / std::max(wall_s, 1e-3),
               terminal_ ? "\x1b[K" : "");
  lines_drawn_ = 1;
  if (!terminal_) return;
  for (const auto& [name, status] : processes) {
    std::fprintf(
        stderr,
        "  %-16s latency %7.2f ms (p95 %7.2f)  queue %4d  cpu %6.1f s  %4lld MB  %s\x1b[K\n",
        name.c_str(), status.latency_ms_median, status.latency_ms_p95, status.queue, status.cpu_s,
        static_cast<long long>(status.peak_rss_bytes >> 20),
        status.state_text.substr(0, 40).c_str());
    ++lines_drawn_;
  }
}

void Progress::finish() {
  if (lines_drawn_ > 0) std::fflush(stderr);
  lines_drawn_ = 0;
}

}  // namespace fusion_slam
