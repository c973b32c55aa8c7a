// Depth packed for networks beside zlib, which every program reads.
#include <random>

#include <benchmark/benchmark.h>

#include "libs/camera/packed_depth.hpp"

namespace fusion_slam {
namespace {

// 640 x 480 of a wall that runs away, in steps of an eighth of a pixel of disparity, with noise of
// half a step and holes.
cv::Mat wall() {
  std::mt19937 random(1);
  cv::Mat depth(480, 640, CV_16UC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const int steps = 120 + u / 4 + v / 8 + static_cast<int>(random() % 4) / 3;
      depth.at<std::uint16_t>(v, u) =
          static_cast<std::uint16_t>(random() % 100 == 0 ? 0 : 342000 / steps);
    }
  return depth;
}

void encode_with(benchmark::State& state, Bytes (*encode)(const cv::Mat&)) {
  const cv::Mat depth = wall();
  Bytes bytes;
  for (auto _ : state) benchmark::DoNotOptimize(bytes = encode(depth));
  state.counters["bytes"] = static_cast<double>(bytes.size());
}

void decode_with(benchmark::State& state, Bytes (*encode)(const cv::Mat&),
                 std::optional<cv::Mat> (*decode)(const Bytes&, int, int, std::string*)) {
  const Bytes bytes = encode(wall());
  std::string why;
  for (auto _ : state) benchmark::DoNotOptimize(decode(bytes, 640, 480, &why));
}

void pack_depth(benchmark::State& state) { encode_with(state, encode_packed_depth); }
void zip_depth(benchmark::State& state) { encode_with(state, encode_depth); }
void unpack_depth(benchmark::State& state) {
  decode_with(state, encode_packed_depth, decode_packed_depth);
}
void unzip_depth(benchmark::State& state) { decode_with(state, encode_depth, decode_depth); }
BENCHMARK(pack_depth);
BENCHMARK(zip_depth);
BENCHMARK(unpack_depth);
BENCHMARK(unzip_depth);

}  // namespace
}  // namespace fusion_slam
