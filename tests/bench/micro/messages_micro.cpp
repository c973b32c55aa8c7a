// What the guard in front of LCM's decoder costs, beside the decoder itself.
#include <benchmark/benchmark.h>

#include "bot_core/planar_lidar_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

template <class Message>
std::vector<std::uint8_t> bytes_of(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

std::vector<std::uint8_t> scan() {
  bot_core::planar_lidar_t m{};
  m.ranges.resize(360, 1.0F);
  m.nranges = 360;
  return bytes_of(m);
}

std::vector<std::uint8_t> graph() {
  graph_t m{};
  m.nodes.resize(1000);
  m.n_nodes = 1000;
  return bytes_of(m);
}

template <class Message>
void guard(benchmark::State& state, const std::vector<std::uint8_t>& bytes) {
  const LcmType* type = peek_type(bytes.data(), bytes.size());
  if (type == nullptr || check(*type, bytes.data(), bytes.size()))
    return state.SkipWithError("the guard refuses this message");
  for (auto _ : state) benchmark::DoNotOptimize(check(*type, bytes.data(), bytes.size()));
  state.SetBytesProcessed(state.iterations() * static_cast<long>(bytes.size()));
}

template <class Message>
void decode(benchmark::State& state, const std::vector<std::uint8_t>& bytes) {
  for (auto _ : state) {
    Message message;
    benchmark::DoNotOptimize(message.decode(bytes.data(), 0, static_cast<int>(bytes.size())));
  }
  state.SetBytesProcessed(state.iterations() * static_cast<long>(bytes.size()));
}

void guard_a_scan(benchmark::State& state) { guard<bot_core::planar_lidar_t>(state, scan()); }
void decode_a_scan(benchmark::State& state) { decode<bot_core::planar_lidar_t>(state, scan()); }
void guard_a_graph_of_1000(benchmark::State& state) { guard<graph_t>(state, graph()); }
void decode_a_graph_of_1000(benchmark::State& state) { decode<graph_t>(state, graph()); }
BENCHMARK(guard_a_scan);
BENCHMARK(decode_a_scan);
BENCHMARK(guard_a_graph_of_1000);
BENCHMARK(decode_a_graph_of_1000);

}  // namespace
}  // namespace fusion_slam
