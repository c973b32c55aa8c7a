// Cells: fusing two sensors' probabilities, tiles to the wire and back.
#include <random>

#include <benchmark/benchmark.h>

#include "libs/grid/fused_tile.hpp"
#include "services/fuser/fusion_rule.hpp"

namespace fusion_slam {
namespace {

FusedCells random_tile() {
  std::mt19937 random(1);
  FusedCells cells;
  for (auto& p : cells.probability) p = static_cast<std::uint8_t>(random());
  for (auto& p : cells.provenance) p = static_cast<std::uint8_t>(random() % 5);
  return cells;
}

void fuse_a_tile(benchmark::State& state) {
  const FusedCells a = random_tile();
  for (auto _ : state)
    for (std::size_t i = 0; i < a.probability.size(); ++i)
      benchmark::DoNotOptimize(
          fuse_cells(a.probability[i], a.probability[a.probability.size() - 1 - i]));
  state.SetItemsProcessed(state.iterations() * static_cast<long>(a.probability.size()));
}
BENCHMARK(fuse_a_tile)->Unit(benchmark::kMicrosecond);

void encode_fused_tile_of_noise(benchmark::State& state) {
  const FusedCells cells = random_tile();
  for (auto _ : state) benchmark::DoNotOptimize(encode_fused_tile({}, cells, 0.05, 1, 1));
}
BENCHMARK(encode_fused_tile_of_noise)->Unit(benchmark::kMicrosecond);

void decode_fused_tile_of_noise(benchmark::State& state) {
  const Tile tile = encode_fused_tile({}, random_tile(), 0.05, 1, 1);
  for (auto _ : state) benchmark::DoNotOptimize(decode_fused_tile(tile));
}
BENCHMARK(decode_fused_tile_of_noise)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace fusion_slam
