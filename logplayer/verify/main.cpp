// verify: what is wrong in an LCM event log.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>

#include "logplayer/verify/verifier.hpp"

int main(int argc, char** argv) {
  CLI::App app(
      "Looks for damage in an LCM event log: holes in sequence numbers, time going backwards, "
      "messages that can't be "
      "decoded, bytes that are no events. Returns 0 when nothing is wrong, 1 when something is, 2 "
      "for wrong usage.",
      "verify");
  std::string file;
  std::size_t max_lines = 50;
  app.add_option("LOG", file, "LCM event log (lcm-logger, fusion-slam import)")->required();
  app.add_option("--max-lines", max_lines, "findings to print")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    fusion_slam::LogReader reader(file);
    const fusion_slam::VerifyReport report = fusion_slam::verify(reader);
    std::cout << fusion_slam::text_report(file, report, max_lines);
    return report.findings.empty() && std::cout.flush() ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
}
