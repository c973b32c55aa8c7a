#include "viz/web/commands.hpp"

#include <cstdio>
#include <ctime>

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

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

Commands::Commands(ViewerState& state, std::filesystem::path save_directory, SendCommand send)
    : state_(state), save_directory_(std::move(save_directory)), send_(std::move(send)) {}

Commands::~Commands() {
  if (saver_.joinable()) saver_.join();
}

Json Commands::handle(const Request& request) {
  if (request.verb == "save_map") return save();
  if (!send_) return answer(false, "This is a recording: there is no robot to command.");
  if (request.verb == "reset") {
    send_("", "reset", "");
    return answer(true, "Asked every process to start anew.");
  }
  if (request.verb == "localise") {
    send_("pose_graph", "localise",
          std::to_string(request.x_m) + " " + std::to_string(request.y_m) + " " +
              std::to_string(request.yaw_rad));
    return answer(true, "Told the pose graph where the robot is.");
  }
  send_("sheriff", request.verb, request.target);
  return answer(true, "Asked the sheriff to " + request.verb + " " + request.target + ".");
}

Json Commands::save() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (saving_) return answer(false, "The map is being saved already.");
  if (saver_.joinable()) saver_.join();
  const auto folder = unused(save_directory_ / folder_name(state_.session_utime_us()));
  saving_ = true;
  saver_ = std::thread([this, folder] {
    try {
      const SessionResult result = state_.save(folder);
      std::string files;
      for (const std::string& file : result.files) files += (files.empty() ? "" : ", ") + file;
      if (result.files.empty())
        state_.notice("error", "There is no map to save yet.");
      else
        state_.notice("info", "Saved to " + folder.string() + ": " + files);
    } catch (const std::exception& error) {
      state_.notice("error", std::string("The map could not be saved: ") + error.what());
    }
    saving_ = false;
  });
  return answer(true, "Saving to " + folder.string());
}

}  // namespace fusion_slam
