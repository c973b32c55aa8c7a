// export: an LCM log in the formats of other systems.
#include <exception>
#include <iostream>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "libs/log_export/carmen_export.hpp"
#include "libs/log_export/lcm_export.hpp"
#include "libs/log_export/tum_export.hpp"

namespace {

void show_progress(double share) {
  std::cerr << "\rexport: " << static_cast<int>(100.0 * share) << " %" << (share < 1.0 ? "" : "\n")
            << std::flush;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("An LCM log in the formats that other SLAM systems read", "export");
  app.require_subcommand(1);
  std::string log, out;
  fusion_slam::TumExportOptions tum_options;
  fusion_slam::CarmenExportOptions carmen_options;
  fusion_slam::LcmExportOptions lcm_options;
  std::string images = "packed";
  auto* tum = app.add_subcommand(
      "tum", "TUM RGB-D directory: rgb/, depth/, rgb.txt, depth.txt, groundtruth.txt");
  auto* carmen = app.add_subcommand("carmen", "CARMEN log: ODOM and FLASER lines");
  auto* lcm = app.add_subcommand(
      "lcm", "LCM log again, its images packed: about half the size, nothing lost");
  for (auto* format : {tum, carmen, lcm}) {
    format->add_option("LOG", log, "the LCM log")->required()->check(CLI::ExistingFile);
    format->add_option("OUT", out, "what to make: a directory (tum), a file (carmen, lcm)")
        ->required();
  }
  tum->add_flag(
      "--jpeg", tum_options.keep_jpeg,
      "the log's own JPEG images instead of PNG: nothing re-encoded, a tenth of the size");
  carmen->add_flag("--full-sweep", carmen_options.full_sweep,
                   "ROBOTLASER1 lines with all beams instead of FLASER with those ahead");
  lcm->add_option("--images", images,
                  "packed, or plain for programs that know bot_core's images only")
      ->check(CLI::IsMember({"packed", "plain"}))
      ->capture_default_str();
  lcm->add_option("--jpeg-quality", lcm_options.jpeg_quality,
                  "encode colour anew, too; without: it stays as it is")
      ->check(CLI::Range(30, 100));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  lcm_options.images = fusion_slam::image_coding(images);
  std::function<void(double)> shown;
  if (isatty(2) != 0) shown = show_progress;
  try {
    const fusion_slam::ExportSummary summary =
        tum->parsed()   ? fusion_slam::export_tum(log, out, tum_options, shown)
        : lcm->parsed() ? fusion_slam::export_lcm(log, out, lcm_options, shown)
                        : fusion_slam::export_carmen(log, out, carmen_options, shown);
    std::cout << out << ": " << summary_text(summary);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "export: " << error.what() << "\n";
    return 1;
  }
}
