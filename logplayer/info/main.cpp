// info: what is in an LCM event log.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "libs/eventlog/summary.hpp"
#include "logplayer/info/report.hpp"

int main(int argc, char** argv) {
  CLI::App app("What is in an LCM event log: channels, types, rates, sizes, gaps, times", "info");
  std::string file;
  bool json = false;
  app.add_option("LOG", file, "LCM event log (lcm-logger, fusion-slam import)")->required();
  app.add_flag("--json", json, "print JSON instead of a table");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    fusion_slam::LogReader reader(file);
    const fusion_slam::LogSummary summary = fusion_slam::summarise(reader);
    std::cout << (json ? fusion_slam::json_report(file, summary)
                       : fusion_slam::text_report(file, summary));
    return std::cout.flush() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
