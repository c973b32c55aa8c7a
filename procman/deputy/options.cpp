#include "procman/deputy/options.hpp"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include <CLI/CLI.hpp>
#include <pwd.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

std::string host_name() {
  char name[256] = {};
  gethostname(name, sizeof(name) - 1);
  return name;
}

std::pair<uid_t, gid_t> find_user(const std::string& name) {
  const passwd* user = getpwnam(name.c_str());
  if (user == nullptr) throw std::runtime_error("there is no user " + name + " on this machine");
  if (geteuid() != 0 && geteuid() != user->pw_uid)
    throw std::runtime_error("only a deputy started by root can run commands as " + name);
  return {user->pw_uid, user->pw_gid};
}

}  // namespace

std::optional<DeputyOptions> parse_deputy_options(int argc, char** argv, int* exit_code) {
  CLI::App app(
      "procman-deputy: runs on each machine of the lab, starts and stops processes as a sheriff "
      "orders (procman's protocol), and publishes their state and output. Runs only programs below "
      "the folders it is allowed.");
  DeputyOptions options;
  options.name = host_name();
  std::vector<std::string> folders;
  std::vector<std::string> variables;
  std::string user;
  if (const char* key = std::getenv("FUSION_SLAM_KEY_FILE")) options.key_file = key;
  app.add_option("--name,-i,--id", options.name, "what configurations call this machine")
      ->capture_default_str();
  app.add_option("--lcm-url,-u,--lcmurl", options.lcm_url,
                 "LCM network (default: LCM_DEFAULT_URL, else LCM's own)");
  app.add_option("--allow", folders,
                 "a folder whose programs may be run with all below it, or one program; may be "
                 "given again (default: "
                 "this installation's programs)");
  app.add_option("--allow-env", variables, "a variable that orders may set; may be given again");
  app.add_flag("--allow-anything", options.allowed.anything,
               "any program with any variables: as procman's own deputy does");
  app.add_option("--user", user, "run commands as this user (the deputy must be root's)");
  app.add_option(
      "--key", options.key_file,
      "take only orders signed with the key in this file (default: FUSION_SLAM_KEY_FILE)");
  app.add_option("--log-folder", options.log_folder,
                 "append each command's output to NAME.log there");
  app.add_option("--until-idle", options.until_idle_s, "end after so many seconds without commands")
      ->check(CLI::NonNegativeNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  if (options.name.empty()) throw std::runtime_error("--name must not be empty");
  if (folders.empty()) folders.push_back(fs::read_symlink("/proc/self/exe").parent_path());
  for (const std::string& folder : folders) {
    if (!fs::exists(folder))
      throw std::runtime_error("--allow " + folder + ": there is no such folder or program");
    options.allowed.folders.emplace_back(folder);
  }
  options.allowed.variables.insert(variables.begin(), variables.end());
  if (!user.empty()) options.user = find_user(user);
  if (!options.log_folder.empty()) fs::create_directories(options.log_folder);
  return options;
}

}  // namespace fusion_slam
