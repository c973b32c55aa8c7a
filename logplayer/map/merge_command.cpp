#include <iostream>

#include "logplayer/map/commands.hpp"
#include "logplayer/map_merge/merge.hpp"

namespace fusion_slam {

int merge_two_maps(const MapOptions& options) {
  const MergeReport report = merge_maps(options.map, options.other, options.out);
  std::cout << options.out.string() << ": " << describe(report.summary) << "  joined by "
            << report.cross_loops << " closures between the two";
  if (report.switched_off > 0) std::cout << ", " << report.switched_off << " of them switched off";
  std::cout << "\n";
  if (report.shifted_s != 0.0)
    std::cout << "  the times of " << options.other.string() << " were moved by "
              << report.shifted_s << " s: it began before the first ended\n";
  if (report.images_refused > 0)
    std::cout << "  " << report.images_refused
              << " images of another size than the first map's camera were left out\n";
  return 0;
}

}  // namespace fusion_slam
