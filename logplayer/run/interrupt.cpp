#include "logplayer/run/interrupt.hpp"

#include <csignal>

namespace fusion_slam {
namespace {

volatile std::sig_atomic_t count = 0;

void on_interrupt(int) { count = count + 1; }

}  // namespace

void watch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // The terminal was closed; under nohup that is to be ignored.
  struct sigaction before {};
  sigaction(SIGHUP, nullptr, &before);
  if (before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

int interrupts() { return count; }

}  // namespace fusion_slam
