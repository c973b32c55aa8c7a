#include "viz/web/viewer.hpp"

#include <atomic>
#include <chrono>
#include <csignal>
#include <iostream>
#include <thread>

#include <CLI/CLI.hpp>

#include "fusion_slam/command_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "viz/web/commands.hpp"
#include "viz/web/player.hpp"
#include "viz/web/viewer_process.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

std::atomic<bool> stop_asked{false};
std::atomic<Bus*> running_bus{nullptr};

void on_signal(int) {
  stop_asked = true;
  if (Bus* bus = running_bus.load()) bus->stop();
}

std::int64_t wall_us() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// A folder that `run` left stands for the session in it.
std::filesystem::path log_of(const std::filesystem::path& session) {
  if (!std::filesystem::is_directory(session)) return session;
  if (std::filesystem::exists(session / "session.lcmlog")) return session / "session.lcmlog";
  throw std::runtime_error(session.string() +
                           " has no session.lcmlog: give a folder that `fusion-slam run LOG --out "
                           "DIR` left (without --no-session), or an LCM log");
}

std::string reply(const Request& request, Json json) {
  json["id"] = request.id;
  return to_text(json);
}

PageFiles page_files() {
  PageFiles files(page_folder(std::filesystem::read_symlink("/proc/self/exe")));
  if (!files.complete())
    std::cerr << "viewer: the page is not built: install nodejs and npm, then `./fusion-slam "
                 "build`\n";
  return files;
}

void say_ready(const WebServer& server) {
  std::cout << "viewer: open " << server.url() << std::endl;
}

void run_replay(const ViewerOptions& options) {
  const auto log = log_of(options.session);
  { const LogReader is_a_log(log); }  // throws, before anything is started, when it is not
  ItemStore store;
  ViewerState state(store);
  Commands commands(state, options.save_directory, {});
  Player player(log, store, state);
  const WebServer server(options.server, store, page_files(), [&](const Request& request) {
    if (request.kind == Request::Kind::kCell)
      return reply(request, Json::parse(state.cell_json(request.x_m, request.y_m)));
    if (request.kind == Request::Kind::kCommand) return reply(request, commands.handle(request));
    player.handle(request);
    return reply(request, {{"ok", true}});
  });
  say_ready(server);
  while (!stop_asked && !player.failed())
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  if (player.failed()) throw std::runtime_error("stopped: the recording can't be shown");
}

void run_live(const ViewerOptions& options) {
  BusOptions bus_options;
  bus_options.process = "viewer";
  bus_options.url = options.lcm_url;
  Bus bus(bus_options);
  const std::shared_ptr<void> no_signals_after(nullptr, [](void*) { running_bus = nullptr; });
  running_bus = &bus;
  bus.listen<command_t>("COMMAND", [&bus](const command_t& command) {
    if (command.verb == "quit" && (command.target.empty() || command.target == "viewer"))
      bus.stop();
  });
  ItemStore store;
  ViewerState state(store, wall_us);
  if (!options.lab.empty()) state.set_lab(load_lab_config(options.lab));
  ViewerProcess process(bus, state);
  Commands commands(
      state, options.save_directory,
      [&process](const std::string& target, const std::string& verb, const std::string& argument) {
        process.send(target, verb, argument);
      },
      {std::filesystem::read_symlink("/proc/self/exe").parent_path() / "procman-sheriff",
       options.lab, options.lcm_url});
  const WebServer server(options.server, store, page_files(), [&](const Request& request) {
    if (request.kind == Request::Kind::kCell)
      return reply(request, Json::parse(state.cell_json(request.x_m, request.y_m)));
    if (request.kind == Request::Kind::kCommand) return reply(request, commands.handle(request));
    return reply(request, {{"ok", false}, {"text", "This is live: there is nothing to wind."}});
  });
  say_ready(server);
  if (!stop_asked) bus.run();
}

}  // namespace

std::optional<ViewerOptions> parse_viewer_options(int argc, char** argv, int* exit_code) {
  ViewerOptions options;
  CLI::App app{
      "viewer: the map, the robot and every process's health in a browser, live or from a "
      "recording"};
  app.add_option("SESSION", options.session,
                 "what `run` left in DIR, or an LCM log; without it: live, from the LCM network")
      ->check(CLI::ExistingPath);
  app.add_option("--listen", options.server.address,
                 "address to serve on; 0.0.0.0 lets every machine of the network look and command")
      ->capture_default_str();
  app.add_option("--port", options.server.port, "0: any that is free")->capture_default_str();
  app.add_option(
      "--name", options.server.names,
      "further name under which browsers reach this machine (its host name and addresses "
      "need none)");
  app.add_option("--lcm-url", options.lcm_url,
                 "LCM network (default: LCM_DEFAULT_URL, else LCM's own)");
  app.add_option("--save-dir", options.save_directory, "where \"Save map\" makes its folders")
      ->capture_default_str();
  app.add_option("--lab", options.lab,
                 "lab configuration: lets the page start and stop its processes by the sheriff")
      ->check(CLI::ExistingFile);
  app.add_option("--most-browsers", options.server.most_browsers, "further ones are refused")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    *exit_code = app.exit(error) == 0 ? 0 : 2;
    return std::nullopt;
  }
  return options;
}

void run_viewer(const ViewerOptions& options) {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGPIPE, SIG_IGN);
  if (options.session.empty())
    run_live(options);
  else
    run_replay(options);
}

}  // namespace fusion_slam
