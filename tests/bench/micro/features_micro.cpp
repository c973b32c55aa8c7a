// Features near a pixel, descriptors that belong together.
#include <bitset>
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>

#include "libs/features/feature_grid.hpp"
#include "libs/features/matching.hpp"

namespace fusion_slam {
namespace {

std::vector<Feature> scattered_features(int n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(0.0F, 640.0F), v(0.0F, 480.0F);
  std::vector<Feature> features(static_cast<std::size_t>(n));
  for (Feature& f : features) {
    f.u_px = u(random);
    f.v_px = v(random);
    f.octave = static_cast<std::int8_t>(random() % 8);
  }
  return features;
}

std::vector<Descriptor> random_descriptors(int n) {
  std::mt19937_64 random(1);
  std::vector<Descriptor> descriptors(static_cast<std::size_t>(n));
  for (Descriptor& d : descriptors)
    for (std::uint64_t& word : d) word = random();
  return descriptors;
}

void near_by_grid(benchmark::State& state) {
  const auto features = scattered_features(1000);
  const FeatureGrid grid(features, 640, 480);
  std::vector<int> found;
  for (auto _ : state) {
    found.clear();
    grid.near(320.0, 240.0, 15.0, 1, 3, &found);
    benchmark::DoNotOptimize(found.data());
  }
}
BENCHMARK(near_by_grid);

void near_by_looking_at_all(benchmark::State& state) {
  const auto features = scattered_features(1000);
  std::vector<int> found;
  for (auto _ : state) {
    found.clear();
    for (int i = 0; i < static_cast<int>(features.size()); ++i) {
      const Feature& f = features[static_cast<std::size_t>(i)];
      if (f.octave >= 1 && f.octave <= 3 && std::hypot(f.u_px - 320.0, f.v_px - 240.0) <= 15.0)
        found.push_back(i);
    }
    benchmark::DoNotOptimize(found.data());
  }
}
BENCHMARK(near_by_looking_at_all);

void hamming_by_popcount(benchmark::State& state) {
  const auto d = random_descriptors(1000);
  for (auto _ : state)
    for (const Descriptor& other : d) benchmark::DoNotOptimize(hamming(d[0], other));
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(hamming_by_popcount);

void hamming_bit_by_bit(benchmark::State& state) {
  const auto d = random_descriptors(1000);
  for (auto _ : state)
    for (const Descriptor& other : d) {
      int bits = 0;
      for (std::size_t w = 0; w < 4; ++w)
        for (unsigned b = 0; b < 64; ++b) bits += static_cast<int>((d[0][w] ^ other[w]) >> b & 1U);
      benchmark::DoNotOptimize(bits);
    }
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(hamming_bit_by_bit);

void match_two_images(benchmark::State& state) {
  const auto a = random_descriptors(static_cast<int>(state.range(0)));
  auto b = a;
  for (Descriptor& d : b) d[1] ^= 0x1111;
  for (auto _ : state) benchmark::DoNotOptimize(match_mutual(a, b));
}
BENCHMARK(match_two_images)->Arg(250)->Arg(500)->Arg(1000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace fusion_slam
