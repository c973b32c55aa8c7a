#include "viz/web/commands.hpp"

#include <chrono>
#include <ctime>
#include <vector>

#include <unistd.h>

#include "libs/process/child.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

constexpr auto kSheriffPatience = std::chrono::seconds(60);

// map-20260131-134501: of the session's own time, so that a replay names it as the session would
// have.
std::filesystem::path folder_name(std::int64_t utime_us) {
  const auto seconds = static_cast<std::time_t>(utime_us / 1'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "map-%Y%m%d-%H%M%S", &utc);
  return text;
}

std::filesystem::path unused(const std::filesystem::path& folder) {
  std::filesystem::path candidate = folder;
  for (int n = 2; std::filesystem::exists(candidate); ++n)
    candidate = folder.string() + "-" + std::to_string(n);
  return candidate;
}

Json answer(bool ok, const std::string& text) { return {{"ok", ok}, {"text", text}}; }

}  // namespace

Commands::Commands(ViewerState& state, std::filesystem::path save_directory, SendCommand send,
                   Sheriff sheriff)
    : state_(state),
      save_directory_(std::move(save_directory)),
      send_(std::move(send)),
      sheriff_(std::move(sheriff)) {}

Commands::~Commands() {
  if (worker_.joinable()) worker_.join();
}

Json Commands::handle(const Request& request) {
  if (request.verb == "save_map") return save();
  if (!send_) return answer(false, "This is a recording: there is no robot to command.");
  if (request.verb == "reset") {
    send_("", "reset", "");
    return answer(true, "Asked every process to start anew.");
  }
  if (request.verb == "localise") {
    send_("localizer", "localise",
          std::to_string(request.x_m) + " " + std::to_string(request.y_m) + " " +
              std::to_string(request.yaw_rad));
    return answer(true, "Told the localizer where the robot is.");
  }
  return order(request.verb, request.target);
}

bool Commands::begin(std::function<void()> job) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (busy_) return false;
  if (worker_.joinable()) worker_.join();
  busy_ = true;
  worker_ = std::thread([this, job = std::move(job)] {
    try {
      job();
    } catch (const std::exception& error) {
      state_.notice("error", error.what());
    }
    busy_ = false;
  });
  return true;
}

Json Commands::save() {
  const auto folder = unused(save_directory_ / folder_name(state_.session_utime_us()));
  const bool begun = begin([this, folder] {
    const SessionResult result = state_.save(folder);
    std::string files;
    for (const std::string& file : result.files) files += (files.empty() ? "" : ", ") + file;
    if (result.files.empty())
      state_.notice("error", "There is no map to save yet.");
    else
      state_.notice("info", "Saved to " + folder.string() + ": " + files);
  });
  return begun ? answer(true, "Saving to " + folder.string())
               : answer(false, "The last order is still being carried out.");
}

Json Commands::order(const std::string& verb, const std::string& target) {
  if (sheriff_.lab.empty())
    return answer(false,
                  "Start the viewer with --lab FILE (the lab's configuration), so that it can ask "
                  "the sheriff.");
  const std::string task = verb == "start" ? "up" : verb == "stop" ? "down" : verb;
  std::vector<std::string> argv{sheriff_.program.string(), task, sheriff_.lab.string(), target};
  if (!sheriff_.lcm_url.empty()) argv.insert(argv.end(), {"--lcm-url", sheriff_.lcm_url});
  const bool begun = begin([this, argv, verb, target] {
    const auto log = std::filesystem::temp_directory_path() /
                     ("fusion-slam-viewer-" + std::to_string(getpid()) + ".log");
    Child child("procman-sheriff", argv, log);
    const auto deadline = std::chrono::steady_clock::now() + kSheriffPatience;
    while (child.running() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const bool good = !child.running() && child.ended_well();
    const std::string said = child.last_lines(4);
    std::error_code ignored;
    std::filesystem::remove(log, ignored);
    state_.notice(good ? "info" : "error",
                  good ? "The sheriff carried out: " + verb + " " + target
                       : "The sheriff could not " + verb + " " + target + ": " + said);
  });
  return begun ? answer(true, "Asked the sheriff to " + verb + " " + target + ".")
               : answer(false, "The last order is still being carried out.");
}

}  // namespace fusion_slam
