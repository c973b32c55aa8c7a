// link: fs_session fs_lcmtypes
// A session whose messages say anything at all: the collector takes them, and what it writes at the
// end are whole files whose trajectories can be read again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>

#include <fuzzer/FuzzedDataProvider.h>

#include "libs/evaluation/tum_file.hpp"
#include "libs/messages/convert.hpp"
#include "libs/session/session_collector.hpp"
#include "tests/fuzz/temporary_folder.hpp"

namespace {

using Input = FuzzedDataProvider;

void require(bool ok) {
  if (!ok) std::abort();
}

double number(Input& in) {
  constexpr double kMax = std::numeric_limits<double>::max();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static const double special[] = {0.0, 1.0, 0.05, -kMax, kMax, kInfinity, NAN, 5e-324, 1e9, 1e-9};
  return in.ConsumeBool() ? in.ConsumeFloatingPointInRange(-10.0, 10.0)
                          : in.PickValueInArray(special);
}

std::int64_t whole(Input& in) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  static const std::int64_t special[] = {0, 1, -1, kMax, -kMax - 1, 1'000'000, 1'400'000};
  return in.ConsumeBool() ? in.ConsumeIntegralInRange<std::int64_t>(0, 2'000'000)
                          : in.PickValueInArray(special);
}

std::int32_t index(Input& in) {
  constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
  static const std::int32_t special[] = {0, 1, -1, 3, 40, 127, 4095, kMax, -kMax - 1};
  return in.PickValueInArray(special);
}

void pose(Input& in, double* position, double* wxyz) {
  wxyz[0] = 1.0;
  if (in.ConsumeBool())
    for (int i = 0; i < 4; ++i) wxyz[i] = number(in);
  for (int i = 0; i < 3; ++i) position[i] = number(in);
}

fusion_slam::pose_estimate_t estimate(Input& in) {
  fusion_slam::pose_estimate_t m{};
  m.utime = whole(in);
  m.state = in.ConsumeIntegralInRange<std::int8_t>(-1, 5);
  m.reference_kind = in.ConsumeIntegralInRange<std::int8_t>(-2, 3);
  m.reference_id = whole(in);
  pose(in, m.T_frame_base.trans, m.T_frame_base.quat);
  pose(in, m.T_reference_base.trans, m.T_reference_base.quat);
  return m;
}

fusion_slam::graph_t graph(Input& in) {
  fusion_slam::graph_t m{};
  m.revision = whole(in);
  m.complete = in.ConsumeBool();
  m.nodes.resize(in.ConsumeIntegralInRange<std::size_t>(0, 3));
  m.n_nodes = static_cast<std::int32_t>(m.nodes.size());
  for (auto& node : m.nodes) {
    node.kind = in.ConsumeIntegralInRange<std::int8_t>(-2, 3);
    node.id = whole(in);
    pose(in, node.T_map_base.trans, node.T_map_base.quat);
  }
  return m;
}

// Data of a length that its encoding may have, or of any.
fusion_slam::tile_t tile(Input& in) {
  fusion_slam::Tile t;
  t.key = {in.ConsumeBool() ? 0 : whole(in), index(in), index(in), index(in)};
  t.revision = whole(in);
  t.resolution_m = in.ConsumeBool() ? 0.05 : number(in);
  const int encoding = in.ConsumeIntegralInRange(-1, 5);
  t.encoding = static_cast<fusion_slam::TileEncoding>(encoding);
  t.size_cells = in.ConsumeBool() ? (encoding > 2 ? 32 : 64) : index(in);
  const std::string some = in.ConsumeRandomLengthString(16);
  static const std::size_t lengths[] = {4096, 8192, 9, 90, 4097};
  std::vector<std::uint8_t> raw(in.PickValueInArray(lengths));
  for (std::size_t i = 0; i < raw.size(); ++i)
    raw[i] = some.empty() ? 0 : static_cast<std::uint8_t>(some[i % some.size()]);
  if (in.ConsumeBool() && raw.size() == 4097) {  // one voxel
    std::fill(raw.begin(), raw.end(), 0);
    raw[in.ConsumeIntegralInRange<std::size_t>(0, 4095)] = 1;
    raw[4096] = in.ConsumeIntegral<std::uint8_t>();
  }
  t.data = in.ConsumeBool() ? fusion_slam::deflate_bytes(raw) : raw;
  return fusion_slam::to_message(t);
}

fusion_slam::robot_model_t robot_model(Input& in) {
  fusion_slam::robot_model_t m{};
  m.reference_frame = in.ConsumeBool() ? "camera" : "lidar";
  pose(in, m.T_base_lidar.trans, m.T_base_lidar.quat);
  pose(in, m.T_base_camera.trans, m.T_base_camera.quat);
  m.lidar_range_max_m = m.lidar_sigma_m = m.robot_height_m = 1.0;
  m.map_resolution_m = in.ConsumeBool() ? 0.05 : number(in);
  return m;
}

fusion_slam::status_t status(Input& in) {
  fusion_slam::status_t m{};
  m.seq = whole(in);
  m.pid = in.ConsumeBool();
  m.channels.resize(in.ConsumeIntegralInRange<std::size_t>(0, 2));
  m.n_channels = static_cast<std::int32_t>(m.channels.size());
  for (auto& channel : m.channels) {
    channel = fusion_slam::channel_stats_t{};
    channel.dropped = whole(in);
    channel.lost = whole(in);
  }
  return m;
}

void feed(Input& in, fusion_slam::SessionCollector* session) {
  static const char* const channels[] = {"GRID_FUSED", "GRID_LIDAR", "GRID_VISUAL",
                                         "OCTOMAP",    "CLOUD",      "SUBMAP"};
  bot_core::pose_t truth{};
  switch (in.ConsumeIntegralInRange(0, 9)) {
    case 0:
      return session->on_camera(whole(in));
    case 1:
      return session->on_lidar(whole(in));
    case 2:
      return session->on_visual_pose(estimate(in));
    case 3:
      return session->on_lidar_pose(estimate(in));
    case 4:
      return session->on_pose(estimate(in));
    case 5:
      return session->on_graph(graph(in));
    case 6:
      return session->on_robot_model(robot_model(in));
    case 7:
      return session->on_status(status(in));
    case 8:
      truth.utime = whole(in);
      pose(in, truth.pos, truth.orientation);
      return session->on_ground_truth(truth);
    default:
      return session->on_tile(in.PickValueInArray(channels), tile(in));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Input in(data, size);
  fusion_slam::SessionCollector session;
  while (in.remaining_bytes() > 0) feed(in, &session);
  session.dropped_total();
  session.lost_total();
  const auto folder = fusion_slam::temporary_folder() / "session";
  const auto result = session.write(folder);
  require(result.files.size() + result.missing.size() == 12);
  for (const std::string& name : result.files) {
    require(std::filesystem::file_size(folder / name) > 0);
    if (std::filesystem::path(name).extension() == ".tum") fusion_slam::read_tum(folder / name);
  }
  require(std::isfinite(result.path_length_m) && std::isfinite(result.free_area_m2));
  return 0;
}
