// report.html of a finished run, from the files in its folder.
#pragma once

#include <filesystem>

namespace fusion_slam {

struct ReportOptions {
  std::filesystem::path run;        // folder that `fusion-slam run LOG --out` left
  std::filesystem::path truth_map;  // map.yaml of the true map; empty: none
  std::filesystem::path out;        // empty: report.html in the run's folder
};

// What is missing in the folder is left out of the page, which says so. Equal files give an equal
// page. Throws std::runtime_error when there is no metrics.json in the folder, a file that is there
// can't be read, or the page can't be written. Returns the page's file.
std::filesystem::path write_report(const ReportOptions& options);

}  // namespace fusion_slam
