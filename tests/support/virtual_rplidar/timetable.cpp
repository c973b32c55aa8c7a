#include "tests/support/virtual_rplidar/timetable.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace fusion_slam {

std::vector<FaultChange> timetable(const std::vector<std::string>& texts) {
  std::vector<FaultChange> changes;
  for (const std::string& text : texts) {
    char name[32] = {};
    double at_s = 0.0;
    double for_s = 0.0;
    if (std::sscanf(text.c_str(), "%31[a-z-]@%lf+%lf", name, &at_s, &for_s) != 3)
      throw std::invalid_argument("--fault " + text + " is not NAME@START+SECONDS");
    changes.push_back({at_s, virtual_fault(name)});
    changes.push_back({at_s + for_s, VirtualFault::kNone});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const FaultChange& a, const FaultChange& b) { return a.at_s < b.at_s; });
  return changes;
}

}  // namespace fusion_slam
