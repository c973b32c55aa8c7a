// doctor: is this machine fit for LCM's multicast and for a recording, and what mends it when not.
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "libs/netcheck/machine.hpp"
#include "libs/netcheck/multicast.hpp"
#include "procman/doctor/machines.hpp"
#include "procman/doctor/report.hpp"

int main(int argc, char** argv) {
  CLI::App app(
      "Checks this machine: multicast, receive buffers, programs, clock, disk. Prints the command "
      "that mends each fault. "
      "Returns 0 when there is no fault, 1 when there is one, 2 for wrong usage.",
      "doctor");
  std::string lcm_url;
  std::string folder = ".";
  bool json = false;
  bool only_commands = false;
  bool machines = false;
  app.add_option(
      "--lcm-url", lcm_url,
      "as for the other programs (default: LCM_DEFAULT_URL, or udpm://239.255.76.67:7667)");
  app.add_option("--folder", folder, "where recordings will go")->capture_default_str();
  app.add_flag("--json", json, "print JSON instead of lines");
  app.add_flag("--commands", only_commands, "print only the commands that mend the faults");
  app.add_flag("--machines", machines,
               "ask the lab's machines instead: clock offsets and losses, measured by 50 pings to "
               "the deputies");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const fusion_slam::UdpmUrl url = fusion_slam::parse_udpm_url(lcm_url);
    std::vector<fusion_slam::CheckResult> results;
    if (machines) {
      results = fusion_slam::check_machines(lcm_url);
    } else {
      results = fusion_slam::check_multicast(url);
      for (auto& result : fusion_slam::check_programs()) results.push_back(result);
      results.push_back(fusion_slam::check_clock());
      results.push_back(fusion_slam::check_disk(folder));
    }
    std::cout << (json            ? fusion_slam::json_report(results)
                  : only_commands ? fusion_slam::commands(results)
                                  : fusion_slam::text_report(results));
    return fusion_slam::has_fault(results) ? 1 : 0;
  } catch (const std::invalid_argument& error) {
    std::cerr << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
