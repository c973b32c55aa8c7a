// How well one node's place is known as seen from another. Exact marginals need the whole graph's
// inverse; along one path of edges the covariances add up, and the best path gives an upper bound
// that is good enough to gate loops with (Olson 2009, "Recognizing positives and negatives in
// loop-closing"; Bosse et al. 2004: Dijkstra projections). Not thread-safe.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "libs/graph/edge.hpp"
#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {

class GraphUncertainty {
 public:
  // Nodes are made as edges name them. `covariance` as the edge is believed
  // (effective_covariance), of xi in T_from_to * Exp(xi). Not finite: ignored.
  void add_edge(const NodeId& from, const NodeId& to, const SE3& T_from_to,
                const Matrix6d& covariance, bool is_loop = false);
  // The loops between the two are gone: the pose graph has switched them off.
  void remove_loops(const NodeId& from, const NodeId& to);

  // The node is gone; where the shortest path between two of its neighbours led through it, an edge
  // of its length and covariance takes its place (Geisberger et al. 2008: contraction), so that
  // paths between the others stay what they were. A loop that is switched off later stays in such
  // edges, and never tears apart what edges that are no loops had tied.
  void retire(const NodeId& node);

  // Best paths from one node to others; valid until an edge comes or goes, and the graph must
  // outlive it. Searches as far as it is asked: O(E log N) of what is nearer.
  class Paths {
   public:
    struct Relative {
      SE3 T_start_node = SE3::Identity();      // by the edges of the path
      Matrix6d covariance = Matrix6d::Zero();  // of it, in the node's axes
    };
    // Nothing: no path leads there.
    std::optional<Relative> to(const NodeId& node);

   private:
    friend class GraphUncertainty;
    using Entry = std::pair<double, int>;  // ties: the smaller index first, the same every time
    // Goes on until the node is reached, or all that is nearer than `most` is known.
    bool reach(int node, double most);
    const GraphUncertainty* graph_ = nullptr;
    std::vector<int> edge_to_;  // by node: the last edge of the path; -1 start, -2 unreachable
    std::vector<double> length_;
    std::vector<bool> settled_;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open_;
  };
  Paths from(const NodeId& start) const;

  // All of it in a journal note, and back. False: damaged; the graph is then empty.
  void write(NoteWriter* out) const;
  bool read(NoteReader* in);

  std::size_t n_nodes() const { return index_.size(); }
  std::size_t n_edges() const { return edges_.size() - free_edges_.size(); }

 private:
  enum class EdgeIs {
    kLasting,   // measured, never switched off: whatever loops go, who hung together still does
    kLoop,      // may be switched off
    kShortcut,  // for a path through a node that is gone
  };
  struct Edge {
    int from = 0;
    int to = 0;
    SE3 T_from_to;
    Matrix6d covariance;
    double length = 0.0;  // what paths are compared by
    EdgeIs is = EdgeIs::kLasting;
  };
  struct Spoke {  // of a node that goes: its shortest edge to a neighbour, told from the neighbour
    Edge edge;
    bool lasting = false;  // one of its edges to the neighbour is
  };
  int index_of(const NodeId& id);
  void put(const Edge& edge);
  void remove(int edge);
  std::map<int, Spoke> take_out(int node);
  static Edge through(const Edge& a, const Edge& b, EdgeIs is);  // from a's neighbour to b's
  void hold_together(const std::map<int, Spoke>& spokes, std::vector<Edge>* added) const;
  void remove_longer(int a, int b, double length);
  Paths from(int start) const;

  std::map<NodeId, int> index_;
  struct Arc {  // an edge as one of its ends has it: what searches need, side by side
    int edge = 0;
    int other = 0;
    double length = 0.0;
  };
  std::vector<std::vector<Arc>> neighbours_;  // of a node
  std::vector<Edge> edges_;
  std::vector<int> free_nodes_, free_edges_;  // numbers that are not in use
};

}  // namespace fusion_slam
