#include "libs/features/matching.hpp"

#include <array>
#include <cmath>

namespace fusion_slam {
namespace {

struct Nearest {
  int index = -1;
  int best = 257;
  int second = 257;

  void offer(int candidate, int distance) {
    if (distance < best) {
      second = best;
      best = distance;
      index = candidate;
    } else if (distance < second) {
      second = distance;
    }
  }
};

}  // namespace

std::vector<Match> match_mutual(const std::vector<Descriptor>& a, const std::vector<Descriptor>& b,
                                const MatchConfig& config) {
  std::vector<Nearest> of_a(a.size());
  std::vector<Nearest> of_b(b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int distance = hamming(a[i], b[j]);
      of_a[i].offer(static_cast<int>(j), distance);
      of_b[j].offer(static_cast<int>(i), distance);
    }
  std::vector<Match> matches;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Nearest& n = of_a[i];
    if (n.index < 0 || n.best > config.max_distance || n.best > config.ratio * n.second) continue;
    if (of_b[n.index].index == static_cast<int>(i))
      matches.push_back({static_cast<int>(i), n.index, n.best});
  }
  return matches;
}

std::vector<Match> keep_common_rotation(const std::vector<Match>& matches,
                                        const std::vector<float>& angles_a_rad,
                                        const std::vector<float>& angles_b_rad) {
  constexpr int kBins = 36;
  const auto bin_of = [&](const Match& m) {
    const double turn = angles_b_rad[m.b] - angles_a_rad[m.a];
    const double fraction = turn / (2.0 * M_PI) - std::floor(turn / (2.0 * M_PI));
    return static_cast<int>(fraction * kBins) % kBins;
  };
  std::array<int, kBins> histogram{};
  for (const Match& m : matches) ++histogram[bin_of(m)];
  int peak = 0;
  int most = -1;
  for (int i = 0; i < kBins; ++i) {
    const int sum = histogram[(i + kBins - 1) % kBins] + histogram[i] + histogram[(i + 1) % kBins];
    if (sum > most) {
      most = sum;
      peak = i;
    }
  }
  std::vector<Match> kept;
  for (const Match& m : matches) {
    const int apart = (bin_of(m) - peak + kBins) % kBins;
    if (apart <= 1 || apart == kBins - 1) kept.push_back(m);
  }
  return kept;
}

}  // namespace fusion_slam
