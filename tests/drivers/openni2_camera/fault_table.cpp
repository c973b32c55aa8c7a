// Prints what the driver says and does about each fault: a Markdown table. Takes about a minute;
// not a test, because it measures time.
#include <chrono>
#include <cstdio>
#include <set>
#include <string>
#include <thread>

#include "tests/drivers/openni2_camera/rig.hpp"

namespace {

using fusion_slam::CameraFault;
using fusion_slam::CameraRig;
using Clock = std::chrono::steady_clock;

constexpr auto kIll = std::chrono::milliseconds(2500);
constexpr auto kAfter = std::chrono::milliseconds(3000);

double ms(Clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); }

bool whole(const fusion_slam::FramePair& pair, const fusion_slam::RigScene& scene) {
  return cv::countNonZero(pair.colour.image.reshape(1) != scene.colour_bgr.reshape(1)) == 0 &&
         cv::countNonZero(pair.depth.image != scene.registered_mm) == 0;
}

// The distinct things said.
std::string said(const CameraRig::Diary& diary, std::size_t from) {
  std::string text;
  std::set<std::string> seen;
  for (std::size_t i = from; i < diary.size(); ++i) {
    const std::string& line = diary[i].text;
    if (line.empty() || line.rfind("running:", 0) == 0) continue;
    if (seen.insert(line.substr(0, 40)).second) text += (text.empty() ? "" : "<br>") + line;
  }
  return text.empty() ? "nothing" : text;
}

void row(CameraFault fault) {
  CameraRig rig;
  rig.plug_in();
  rig.start();
  if (!rig.wait_for_pairs(30)) {
    std::printf("| %s | never ran |\n", to_string(fault));
    return;
  }
  const std::size_t from = rig.now();
  rig.feed().set_fault(fault);
  if (fault == CameraFault::kBusy) rig.driver().restart();  // it shows only when it is opened
  std::this_thread::sleep_for(kIll);
  const auto healed = Clock::now();
  rig.feed().set_fault(CameraFault::kNone);
  std::this_thread::sleep_for(kAfter);
  rig.stop();
  const auto diary = rig.diary();
  int during = 0;
  int wrong = 0;
  double first_ms = -1.0;
  for (std::size_t i = from; i < diary.size(); ++i) {
    if (!diary[i].text.empty()) continue;
    wrong += whole(diary[i].pair, rig.scene()) ? 0 : 1;
    if (diary[i].when < healed)
      ++during;
    else if (first_ms < 0.0)
      first_ms = ms(diary[i].when - healed);
  }
  std::printf("| %s | %s | %d | %d | %.0f |\n", to_string(fault), said(diary, from).c_str(), during,
              wrong, first_ms);
  std::fflush(stdout);
}

}  // namespace

int main() {
  std::printf("Each fault for %.1f s at 30 frames/s; then %.1f s well.\n\n", ms(kIll) / 1e3,
              ms(kAfter) / 1e3);
  std::printf(
      "| fault | what the driver said | frames during it | wrong ones | next frame after it, ms |\n"
      "|---|---|---|---|---|\n");
  for (const CameraFault fault : fusion_slam::camera_faults()) row(fault);
  return 0;
}
