// The graph of uncertainty in a journal note.
#include <algorithm>

#include "libs/graph/node_bytes.hpp"
#include "libs/graph/uncertainty.hpp"

namespace fusion_slam {
namespace {

constexpr std::size_t kNodeBytes = 9;
constexpr std::size_t kEdgeBytes = 281;

}  // namespace

// Edges name their ends by their place among the nodes.
void GraphUncertainty::write(NoteWriter* out) const {
  std::vector<std::uint32_t> place(neighbours_.size());
  std::uint32_t n = 0;
  out->count(index_.size());
  for (const auto& [id, index] : index_) {
    put_node(id, out);
    place[static_cast<std::size_t>(index)] = n++;
  }
  std::vector<bool> is_free(edges_.size());
  for (const int e : free_edges_) is_free[static_cast<std::size_t>(e)] = true;
  out->count(n_edges());
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (is_free[e]) continue;
    const Edge& edge = edges_[e];
    out->put(place[static_cast<std::size_t>(edge.from)]);
    out->put(place[static_cast<std::size_t>(edge.to)]);
    out->pose(edge.T_from_to);
    out->symmetric(edge.covariance);
    out->put(edge.length);
    out->put(static_cast<std::uint8_t>(edge.is));
  }
}

bool GraphUncertainty::read(NoteReader* in) {
  *this = {};
  const std::size_t n_nodes = in->count(kNodeBytes);
  for (std::size_t i = 0; i < n_nodes; ++i) index_of(get_node(in));
  bool good = index_.size() == n_nodes;
  for (std::size_t n = in->count(kEdgeBytes); n > 0 && in->good() && good; --n) {
    Edge edge;
    const auto from = in->get<std::uint32_t>();
    const auto to = in->get<std::uint32_t>();
    edge.from = static_cast<int>(from);
    edge.to = static_cast<int>(to);
    edge.T_from_to = in->pose();
    edge.covariance = in->symmetric();
    edge.length = in->finite();
    const auto is = in->get<std::uint8_t>();
    good = from < n_nodes && to < n_nodes && from != to && edge.length >= 0.0 &&
           is <= static_cast<std::uint8_t>(EdgeIs::kShortcut);
    edge.is = static_cast<EdgeIs>(is);
    if (good && in->good()) put(edge);
  }
  if (good && in->good()) return true;
  *this = {};
  return false;
}

}  // namespace fusion_slam
