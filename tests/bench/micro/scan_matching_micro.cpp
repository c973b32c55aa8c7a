// Placing a scan: branch and bound beside trying everything; refining the place.
#include <benchmark/benchmark.h>

#include "tests/libs/scan_matching/drawn_room.hpp"
#include "tests/libs/scan_matching/exhaustive_match.hpp"

namespace fusion_slam {
namespace {

const SE2 kTruth{0.63, -0.31, 0.9};

SearchWindow window_of(const benchmark::State& state) {
  SearchWindow window;
  window.linear_m = 0.1 * static_cast<double>(state.range(0));
  window.angular_rad = 0.3;
  return window;
}

void match_by_branch_and_bound(benchmark::State& state) {
  const SearchPyramid pyramid(room_raster());
  const Points points = room_points(kTruth, 180, 0.01, 3);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        match_correlative(pyramid, points, kTruth * SE2{0.1, -0.1, 0.1}, window_of(state), 0.3));
}
BENCHMARK(match_by_branch_and_bound)->Arg(2)->Arg(5)->Arg(20)->Unit(benchmark::kMicrosecond);

void match_by_trying_everything(benchmark::State& state) {
  const Raster raster = room_raster();
  const Points points = room_points(kTruth, 180, 0.01, 3);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        best_score_by_force(raster, points, kTruth * SE2{0.1, -0.1, 0.1}, window_of(state)));
}
BENCHMARK(match_by_trying_everything)->Arg(2)->Arg(5)->Unit(benchmark::kMicrosecond);

void build_search_pyramid(benchmark::State& state) {
  const Raster raster = room_raster();
  for (auto _ : state) benchmark::DoNotOptimize(SearchPyramid(raster));
}
BENCHMARK(build_search_pyramid)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace fusion_slam
