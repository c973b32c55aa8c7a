// report: one page about a finished run, for people.
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "logplayer/report/report.hpp"

int main(int argc, char** argv) {
  CLI::App app("One self-contained page about a finished run: map, errors, processes, loops",
               "report");
  fusion_slam::ReportOptions options;
  app.add_option("DIR", options.run, "folder that `fusion-slam run LOG --out DIR` left")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--truth", options.truth_map, "map.yaml of the true map, shown beside")
      ->check(CLI::ExistingFile);
  app.add_option("--out", options.out, "the page's file (default: report.html in DIR)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    std::cout << fusion_slam::write_report(options).string() << std::endl;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "report: " << error.what() << std::endl;
    return 1;
  }
}
