#include "libs/netcheck/machine.hpp"

#include <cstdlib>
#include <ctime>
#include <sstream>

#include <sys/timex.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

constexpr std::time_t kEarliest = 1'700'000'000;  // November 2023: before this program was written
constexpr std::time_t kLatest = 4'102'444'800;    // the year 2100

CheckResult check_program(const std::string& name, CheckState when_missing, const std::string& why,
                          const std::string& package) {
  const std::filesystem::path path = find_program(name);
  if (!path.empty()) return {name, CheckState::kGood, path.string(), ""};
  return {name, when_missing, "not installed; " + why, "apt-get install --yes " + package};
}

}  // namespace

std::filesystem::path find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::filesystem::path candidate = std::filesystem::path(folder) / name;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(candidate, ignored) &&
        access(candidate.c_str(), X_OK) == 0)
      return candidate;
  }
  return {};
}

std::vector<CheckResult> check_programs() {
  return {check_program("lcm-logger", CheckState::kFault, "it records runs", "liblcm-bin"),
          check_program("lcm-logplayer", CheckState::kFault, "it plays recordings", "liblcm-bin"),
          check_program("lcm-spy", CheckState::kWarning, "it shows messages as they pass",
                        "liblcm-bin liblcm-java"),
          check_program("java", CheckState::kWarning, "lcm-spy needs it", "default-jre"),
          check_program("lcm-gen", CheckState::kWarning, "only building needs it", "liblcm-bin")};
}

CheckResult check_clock() {
  CheckResult result{"clock", CheckState::kGood, "", ""};
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  char date[32] = "";
  if (gmtime_r(&now, &parts) != nullptr)
    std::strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S UTC", &parts);
  result.found = date;
  if (now < kEarliest || now > kLatest) {
    result.state = CheckState::kFault;
    result.found += " can't be; recordings would carry wrong times";
    result.command = "timedatectl set-ntp true";
    return result;
  }
  timex query{};
  if (adjtimex(&query) < 0) return result;  // not permitted here: nothing known
  if ((query.status & STA_UNSYNC) == 0) {
    result.found += ", synchronised";
  } else {
    result.state = CheckState::kWarning;
    result.found += ", not synchronised: fine on one machine, not between several";
    result.command = "timedatectl set-ntp true";
  }
  return result;
}

CheckResult check_disk(const std::filesystem::path& folder) {
  CheckResult result{"disk", CheckState::kGood, "", ""};
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) {
    return {"disk", CheckState::kFault, folder.string() + ": " + error.message(),
            "mkdir -p " + folder.string()};
  }
  const double free_GB = static_cast<double>(space.available) / 1e9;
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(1);
  text << free_GB << " GB free in " << folder.string();
  result.found = text.str();
  if (free_GB < 10.0) {
    result.state = free_GB < 1.0 ? CheckState::kFault : CheckState::kWarning;
    result.found += "; a camera and a LiDAR fill about 0.5 GB a minute";
    result.command = "du -xh " + folder.string() + " | sort -h | tail";
  }
  return result;
}

}  // namespace fusion_slam
