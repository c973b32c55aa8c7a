// loops: which loops a session closed, which it did not, and why.
#include <exception>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>

#include "logplayer/loops/read_session.hpp"

int main(int argc, char** argv) {
  CLI::App app("What became of each idea of a loop in a session: every stage's verdict and reason",
               "loops");
  std::string file, closures;
  fusion_slam::LoopReportOptions options;
  app.add_option("SESSION", file, "session.lcmlog of a run")->required();
  app.add_flag("--all", options.all, "also the candidates that were rejected");
  app.add_option("--closures", closures,
                 "also write the accepted closures to this file, one a line: t1 t2 x y z roll "
                 "pitch yaw (s, m, rad; as `eval relations` reads them)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    const fusion_slam::LoopReport report = fusion_slam::read_session(file);
    if (!closures.empty() && !(std::ofstream(closures) << report.as_relations() << std::flush))
      throw std::runtime_error("can't write " + closures + ": is there such a folder, is it full?");
    std::cout << report.text(options);
    return std::cout.flush() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
