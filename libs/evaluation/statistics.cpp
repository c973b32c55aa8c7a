#include "libs/evaluation/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

}  // namespace

std::array<std::pair<std::string_view, double>, 7> Statistics::named() const {
  return {{{"rmse", rmse},
           {"mean", mean},
           {"median", median},
           {"std", std},
           {"min", min},
           {"max", max},
           {"sse", sse}}};
}

Statistics compute_statistics(const std::vector<double>& errors) {
  Statistics s;
  s.count = errors.size();
  if (errors.empty()) return s;
  const auto n = static_cast<double>(errors.size());
  double sum = 0.0;
  for (const double e : errors) {
    sum += e;
    s.sse += e * e;
  }
  s.mean = sum / n;
  s.rmse = std::sqrt(s.sse / n);
  double squares = 0.0;
  for (const double e : errors) squares += (e - s.mean) * (e - s.mean);
  s.std = std::sqrt(squares / n);
  s.median = median_of(errors);
  const auto [lowest, highest] = std::minmax_element(errors.begin(), errors.end());
  s.min = *lowest;
  s.max = *highest;
  return s;
}

}  // namespace fusion_slam
