// What the bus costs a message between two processes: from publish() to the handler, over LCM's UDP
// multicast, with the decoder guard, sequence numbers and queues; beside LCM alone, the same bytes.
// In a network of its own:
//   unshare --net sh -c 'ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo;
//                        build/release/bin/bus_hop_bench'
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "fusion_slam/journal_note_t.hpp"
#include "libs/bus/bus.hpp"
#include "libs/bus/transport.hpp"
#include "libs/clock/clock.hpp"

namespace {

using fusion_slam::journal_note_t;
constexpr int kPeriod_ms = 20;

journal_note_t message_of(int size_bytes) {
  journal_note_t message{};
  message.utime = fusion_slam::steady_us();
  message.size_bytes = size_bytes;
  message.data.resize(static_cast<std::size_t>(size_bytes), 7);
  return message;
}

fusion_slam::BusOptions options(const char* process) {
  fusion_slam::BusOptions options;
  options.process = process;
  options.merge_wait_us = 0;
  return options;
}

void report(const char* what, int size_bytes, std::vector<std::int64_t> us, int sent) {
  std::sort(us.begin(), us.end());
  if (us.empty()) return void(std::printf("%s: nothing arrived\n", what));
  std::printf("%-9s %7d bytes: %zu of %d, median %.3f ms, p95 %.3f, worst %.3f\n", what, size_bytes,
              us.size(), sent, 1e-3 * static_cast<double>(us[us.size() / 2]),
              1e-3 * static_cast<double>(us[us.size() * 95 / 100]),
              1e-3 * static_cast<double>(us.back()));
}

// The other process: waits until the listener is there, then speaks.
template <class Publish>
void speak(int n, int size_bytes, Publish publish) {
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  for (int i = 0; i < n; ++i) {
    publish(message_of(size_bytes));
    std::this_thread::sleep_for(std::chrono::milliseconds(kPeriod_ms));
  }
}

void measure_bus(int n, int size_bytes) {
  const pid_t speaker = fork();
  if (speaker == 0) {
    fusion_slam::Bus bus(options("speaker"));
    speak(n, size_bytes, [&](const journal_note_t& m) { bus.publish("HOP", m); });
    _exit(0);
  }
  fusion_slam::Bus bus(options("listener"));
  std::vector<std::int64_t> us;
  bus.subscribe<journal_note_t>("HOP", fusion_slam::Policy::kKeepAll, [&](const journal_note_t& m) {
    us.push_back(fusion_slam::steady_us() - m.utime);
  });
  while (waitpid(speaker, nullptr, WNOHANG) == 0) bus.handle(50);
  report("bus", size_bytes, us, n);
}

void measure_lcm(int n, int size_bytes) {
  const pid_t speaker = fork();
  if (speaker == 0) {
    fusion_slam::Transport lcm("");
    speak(n, size_bytes,
          [&](const journal_note_t& m) { lcm.publish("HOP", fusion_slam::bus_detail::encode(m)); });
    _exit(0);
  }
  std::vector<std::int64_t> us;
  {
    fusion_slam::Transport lcm("");
    const auto token =
        lcm.subscribe("HOP", [&](const std::string&, const std::uint8_t* bytes, std::size_t size) {
          const auto m = fusion_slam::bus_detail::decode<journal_note_t>(bytes, size);
          us.push_back(fusion_slam::steady_us() - m.utime);
        });
    waitpid(speaker, nullptr, 0);
  }
  report("LCM alone", size_bytes, us, n);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Time from publish() to the handler of another process", "bus_hop_bench");
  int n = 300;
  app.add_option("--messages", n, "of each size")->check(CLI::Range(1, 100'000));
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  for (const int size_bytes : {100, 10'000, 100'000, 300'000}) {
    measure_bus(n, size_bytes);
    measure_lcm(n, size_bytes);
  }
}
