// The seven numbers by which a list of errors is reported.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

namespace fusion_slam {

// All in the unit of the errors, sse in its square. std is of the population (divided by n); the
// median of an even count is the mean of the middle two.
struct Statistics {
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double std = 0.0;
  double min = 0.0;
  double max = 0.0;
  double sse = 0.0;
  std::size_t count = 0;

  // Name and value in the order of the table that people read.
  std::array<std::pair<std::string_view, double>, 7> named() const;
};

// Of no errors: all zero, count 0.
Statistics compute_statistics(const std::vector<double>& errors);

}  // namespace fusion_slam
