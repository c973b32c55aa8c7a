// loops: which loops a session closed, which it did not, and why.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "logplayer/loops/read_session.hpp"

int main(int argc, char** argv) {
  CLI::App app("What became of each idea of a loop in a session: every stage's verdict and reason",
               "loops");
  std::string file;
  fusion_slam::LoopReportOptions options;
  app.add_option("SESSION", file, "session.lcmlog of a run")->required();
  app.add_flag("--all", options.all, "also the candidates that were rejected");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    std::cout << fusion_slam::read_session(file).text(options);
    return std::cout.flush() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
