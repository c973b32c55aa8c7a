// link: fs_pose_graph
// The pose graph's state, as it stands in its journal. What can be read is written the same way,
// and can be gone on with.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "services/pose_graph/pose_graph.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::PoseGraph graph;
  fusion_slam::NoteReader in(data, size);
  if (!graph.restore(&in)) {
    if (graph.n_nodes() != 0 || !graph.edges().empty()) std::abort();
    return 0;
  }
  std::vector<std::uint8_t> bytes;
  fusion_slam::NoteWriter out(&bytes);
  graph.write(&out);
  fusion_slam::PoseGraph again;
  fusion_slam::NoteReader back(bytes.data(), bytes.size());
  if (!again.restore(&back)) std::abort();
  if (again.n_nodes() != graph.n_nodes() || again.edges().size() != graph.edges().size())
    std::abort();
  again.nodes_after({}, again.n_nodes());
  again.take_changes();
  return 0;
}
