// How long the question "which place looks like this" takes, in CPU time, as the number of
// keyframes grows to N: place_index_bench [N]. Places are made of random features that share a
// common stock, as rooms of one building do.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "libs/places/place_index.hpp"

namespace fusion_slam {
namespace {

constexpr int kFeatures = 1000;
constexpr int kStock = 20000;  // of descriptors that are seen all over the building

class Building {
 public:
  Building() {
    for (int i = 0; i < kStock; ++i) stock_.push_back(any());
  }
  FeatureSet keyframe(unsigned place, unsigned view) {
    std::mt19937 of_place(place + 1), of_view(view + 77);
    FeatureSet set;
    for (int i = 0; i < kFeatures; ++i) {
      Descriptor d = i % 2 == 0 ? stock_[of_place() % kStock] : from(&of_place);
      for (int k = 0; k < 20; ++k) {
        const unsigned bit = of_view() % 256;
        d[bit / 64] ^= 1ULL << (bit % 64);
      }
      set.features.emplace_back();
      set.descriptors.push_back(d);
    }
    return set;
  }

 private:
  // Bits of real descriptors are not even: half of them lean to one side.
  static Descriptor from(std::mt19937* random) {
    constexpr std::uint64_t kEven = 0x5555555555555555ULL;
    const auto word = [&] { return static_cast<std::uint64_t>((*random)()) << 32U | (*random)(); };
    Descriptor d;
    for (auto& w : d) w = word() & (kEven | word());
    return d;
  }
  Descriptor any() { return from(&random_); }
  std::mt19937 random_{5};
  std::vector<Descriptor> stock_;
};

void run(unsigned n) {
  Building building;
  PlaceIndex index{AppearanceConfig{}};
  int right = 0, asked = 0;
  std::vector<double> ms;
  const unsigned step = std::max(1U, n / 5U);
  for (unsigned i = 0; i < n; ++i) {
    index.add(i + 1, static_cast<std::int64_t>(i) * 1'000'000, building.keyframe(i, i));
    if ((i + 1) % step != 0) continue;
    ms.clear();
    for (unsigned k = 0; k < 50; ++k) {
      const unsigned place = (k * 97) % (i + 1 - step / 10);
      const FeatureSet seen = building.keyframe(place, 100000 + k);
      const std::clock_t before = std::clock();
      const auto places = index.like(seen);
      ms.push_back(1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
      ++asked;
      right += !places.empty() && places[0].id == place + 1 ? 1 : 0;
    }
    std::sort(ms.begin(), ms.end());
    std::printf("%5u keyframes: median %.1f ms, worst %.1f ms\n", i + 1, ms[25], ms.back());
  }
  std::printf("%d of %d places known again at once\n", right, asked);
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  const int n = argc > 1 ? std::atoi(argv[1]) : 5000;
  if (argc > 2 || n < 50) {
    std::fprintf(stderr, "usage: place_index_bench [N], at least 50 keyframes\n");
    return 2;
  }
  fusion_slam::run(static_cast<unsigned>(n));
  return 0;
}
