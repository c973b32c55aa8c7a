// Nodes that others supersede leave the pose graph: "Temporally scalable visual SLAM using a
// reduced pose graph" (Johannsson, Kaess, Fallon, Leonard 2013). In places that are known the
// oldest nodes stay, so the map rests on them; a newer one is carried rigidly by one of them, and
// what was measured at it is said of its carrier instead.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "libs/graph/edge.hpp"
#include "services/pose_graph/config.hpp"

namespace fusion_slam {

struct Retirement {
  NodeId id;
  NodeId carrier;                          // a node that stays
  SE3 T_carrier_base = SE3::Identity();    // of the retired node, from now on
  Matrix6d covariance = Matrix6d::Zero();  // as believed, of xi in T_carrier_base * Exp(xi)
};

// The edge with its end at retirement.id moved to the carrier: to first order the covariances of
// the two steps add up, each with its own floor (exact for a chain). Nothing: the edge leads from
// the carrier to itself now.
std::optional<GraphEdge> at_carrier(const PoseGraphConfig& config, bool planar,
                                    const GraphEdge& edge, const Retirement& retirement);

// Retires nodes one after the other. Not thread-safe.
class Thinning {
 public:
  Thinning(const PoseGraphConfig& config, bool planar, std::vector<GraphEdge>* edges);

  // Of the neighbours that may: the one to which the node's place is known best, and well enough.
  std::optional<NodeId> carrier_of(const NodeId& id,
                                   const std::function<bool(const NodeId&)>& may) const;
  // Moves the edges of retirement->id to its carrier and says how well T_carrier_base is known.
  // Measured is what the edge between the two says where there is nothing but the chain through
  // the node (exact); else T_carrier_base, which knows of all edges. False, and nothing is done:
  // no edge joins the two.
  bool retire(Retirement* retirement);
  // Of the moved edges of one kind between the same two nodes the most certain one stays: what they
  // say is not independent. Then writes back; the new number of each old edge, -1 when it is gone.
  std::vector<std::ptrdiff_t> finish();

 private:
  std::optional<std::size_t> best_between(const NodeId& a, const NodeId& b) const;
  double doubt(std::size_t edge) const;  // m^2, a radian counted as a metre

  const PoseGraphConfig& config_;
  bool planar_;
  std::vector<GraphEdge>* edges_;
  std::vector<char> gone_;
  std::map<NodeId, std::vector<std::size_t>> at_;
};

}  // namespace fusion_slam
