#include "libs/procman/allowed.hpp"

#include <algorithm>
#include <optional>
#include <sstream>

#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

bool is_harmless(const Allowed& allowed, const std::string& name) {
  return allowed.variables.count(name) > 0 || name == "TZ" || name.rfind("FUSION_SLAM_", 0) == 0 ||
         name.rfind("LCM_", 0) == 0;
}

std::optional<fs::path> real_program(const fs::path& path) {
  std::error_code problem;
  const fs::path real = fs::canonical(path, problem);
  if (problem || !fs::is_regular_file(real, problem) || access(real.c_str(), X_OK) != 0)
    return std::nullopt;
  return real;
}

// Folder by folder: /opt/robot does not hold /opt/robotics.
bool is_below(const fs::path& real, const fs::path& folder) {
  std::error_code problem;
  const fs::path root = fs::canonical(folder, problem);
  if (problem) return false;
  const auto [end, rest] = std::mismatch(root.begin(), root.end(), real.begin(), real.end());
  return end == root.end();
}

std::vector<fs::path> candidates(const Allowed& allowed, const std::string& name,
                                 const std::string& search_path) {
  if (name.find('/') != std::string::npos) return {name};
  std::vector<fs::path> result;
  for (const fs::path& folder : allowed.folders) result.push_back(folder / name);
  std::istringstream folders(search_path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty()) result.push_back(fs::path(folder) / name);
  return result;
}

}  // namespace

fs::path find_allowed(const Allowed& allowed, const ExecLine& line, const std::string& search_path,
                      std::string* why) {
  for (const auto& [name, value] : line.environment) {
    if (allowed.anything || is_harmless(allowed, name)) continue;
    *why = "this deputy does not let orders set the variable ";
    why->append(name).append(" (start it with --allow-env ").append(name).append(" if it shall)");
    return {};
  }
  const std::string& program = line.argv.at(0);
  fs::path forbidden;
  for (const fs::path& path : candidates(allowed, program, search_path)) {
    const auto real = real_program(path);
    if (!real) continue;
    const bool below = std::any_of(allowed.folders.begin(), allowed.folders.end(),
                                   [&](const fs::path& folder) { return is_below(*real, folder); });
    if (allowed.anything || below) return *real;
    if (forbidden.empty()) forbidden = *real;
  }
  if (forbidden.empty()) {
    *why = "there is no program " + program + " here";
  } else {
    *why = forbidden.string() +
           " is not below a folder this deputy may run from (start it with --allow " +
           forbidden.parent_path().string() + " if it shall)";
  }
  return {};
}

}  // namespace fusion_slam
