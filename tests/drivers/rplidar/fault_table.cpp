// Prints what the driver says and does about each fault: a Markdown table. Takes about three
// minutes; not a test, because it measures time.
#include <chrono>
#include <cstdio>
#include <iostream>
#include <set>
#include <string>

#include "tests/drivers/rplidar/rig.hpp"

namespace {

using fusion_slam::RplidarRig;
using fusion_slam::VirtualFault;
using Clock = std::chrono::steady_clock;

constexpr auto kIll = std::chrono::milliseconds(2500);
constexpr auto kAfter = std::chrono::milliseconds(4000);

double ms(Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); }

// The distinct things said, without what differs from time to time.
std::string said(const RplidarRig::Diary& diary, std::size_t from, const std::string& port) {
  std::string text;
  std::set<std::string> seen;
  for (std::size_t i = from; i < diary.size(); ++i) {
    std::string line = diary[i].text;
    if (line.empty() || diary[i].well) continue;
    for (std::size_t at = line.find(port); at != std::string::npos; at = line.find(port))
      line.replace(at, port.size(), "PORT");
    if (!seen.insert(line.substr(0, 24)).second) continue;
    text += (text.empty() ? "" : "<br>") + line;
  }
  return text.empty() ? "nothing" : text;
}

void row(fusion_slam::VirtualFault fault, const std::string& mode, const std::string& model) {
  fusion_slam::VirtualWorld world = fusion_slam::virtual_room(18, 360);
  world.rate_hz = 7.0;
  RplidarRig rig(model, world);
  rig.config().scan_mode = mode;
  rig.plug_in();
  rig.start();
  if (!rig.wait_for_turns(7)) {
    std::printf("| %s | %s | never scanned |\n", to_string(fault), mode.c_str());
    return;
  }
  const std::size_t from = rig.now();
  rig.device().set_fault(fault);
  std::this_thread::sleep_for(kIll);
  const auto healed = Clock::now();
  rig.device().set_fault(VirtualFault::kNone);
  std::this_thread::sleep_for(kAfter);
  rig.stop();
  const auto diary = rig.diary();
  int during = 0;
  int after = 0;
  int wrong = 0;
  double first_ms = -1.0;
  for (std::size_t i = from; i < diary.size(); ++i) {
    const auto& entry = diary[i];
    if (!entry.text.empty()) continue;
    wrong += entry.wrong_beams > 0 ? 1 : 0;
    if (entry.when < healed) {
      ++during;
      continue;
    }
    ++after;
    if (first_ms < 0.0) first_ms = ms(entry.when - healed);
  }
  std::printf("| %s | %s | %s | %d | %d | %.0f ms | %d |\n", to_string(fault), mode.c_str(),
              said(diary, from, rig.port().string()).c_str(), during, wrong, first_ms, after);
  std::fflush(stdout);
}

}  // namespace

int main() {
  std::printf("Each fault for %.1f s at 7 turns/s; then %.1f s well.\n\n", ms(kIll) / 1e3,
              ms(kAfter) / 1e3);
  std::printf(
      "| fault | scan | what the driver said | turns published meanwhile | turns with a wrong beam "
      "| "
      "next turn after the end | turns after |\n|---|---|---|---|---|---|---|\n");
  for (const VirtualFault fault : fusion_slam::virtual_faults())
    for (const std::string mode : {"standard", "express", "dense"})
      row(fault, mode, mode == "dense" ? "s2" : "a1");
  return 0;
}
