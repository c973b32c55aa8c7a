#include "logplayer/run/crew.hpp"

#include <csignal>

#include "libs/bus/process.hpp"
#include "libs/bus/transport.hpp"

namespace fusion_slam {
namespace {

// lcm-logger keeps this much in memory when the disk is slow, before it drops (its default is 100
// MB).
constexpr const char* kLoggerMemory = "--max-unwritten-mb=2000";
// lcm-logger can't ask again for what it lost: when the processors are busy, the services give way
// to it.
constexpr int kServiceNiceness = 5;

}  // namespace

Crew::Crew(const RunOptions& options, const std::string& url) {
  namespace fs = std::filesystem;
  const fs::path logs = options.out / "logs";
  fs::create_directories(logs);
  const auto log_file = [&](const std::string& name) {
    fs::remove(logs / (name + ".log"));
    return logs / (name + ".log");
  };
  if (options.keep_session)
    logger_.emplace_back("lcm-logger",
                         std::vector<std::string>{"lcm-logger", "--force", "--quiet", kLoggerMemory,
                                                  "--lcm-url=" + complete_url(url),
                                                  (options.out / "session.lcmlog").string()},
                         log_file("lcm-logger"));
  for (const std::string& name : service_names(options)) {
    std::vector<std::string> command{(options.programs / name).string(), "--lcm-url", url, "--mode",
                                     to_string(options.mode)};
    if (name == "localizer") command.insert(command.end(), {"--map", options.map.string()});
    services_.emplace_back(name, command, log_file(name), kServiceNiceness);
  }
}

void Crew::check() {
  for (auto* group : {&services_, &logger_})
    for (Child& child : *group) {
      if (child.running()) continue;
      throw ProcessDied(child.name() + " ended: " + child.how_it_ended() + ". Its last lines:\n" +
                        child.last_lines(20));
    }
}

void Crew::stop() {
  for (Child& child : services_) child.signal(SIGTERM);
  for (Child& child : services_) child.stop(5000);
  for (Child& child : logger_) child.stop(20'000, SIGINT);
}

}  // namespace fusion_slam
