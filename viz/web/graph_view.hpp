// The pose graph as the page draws it: nodes in chunks of 64, so that a moved node costs one small
// item, and loops with what every stage said of them. Messages in, items of Topic::kNodes and kLoop
// out. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include <nlohmann/json.hpp>

#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/loop_candidate_t.hpp"
#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"
#include "viz/web/item_store.hpp"

namespace fusion_slam {

// Text of a JSON value for the page; whatever bytes a message's strings hold, it is UTF-8.
std::string to_text(const nlohmann::ordered_json& json);

class GraphView {
 public:
  static constexpr std::int64_t kChunkNodes = 64;
  static constexpr std::size_t kMostRejected =
      300;  // candidates kept for people to look at, the newest

  explicit GraphView(ItemStore& store) : store_(store) {}

  void on_keyframe(const keyframe_t& message);
  void on_lidar_node(const lidar_node_t& message);
  void on_graph(const graph_t& message);
  void on_candidate(const loop_candidate_t& message);
  void on_constraint(const constraint_t& message);
  void clear();

  struct Node {
    std::int64_t utime_us = 0;
    std::int64_t previous_id = 0;
    std::optional<SE3> T_map_base;  // nothing before GRAPH names it
  };
  const std::map<NodeId, Node>& nodes() const { return nodes_; }
  std::size_t loops_closed() const;  // and not switched off

 private:
  // from kind, from id, to kind, to id
  using LoopKey = std::tuple<int, std::int64_t, int, std::int64_t>;
  struct Loop {
    std::int64_t utime_us = 0;
    nlohmann::ordered_json stages = nlohmann::ordered_json::array();
    bool accepted = false;
    std::string source;  // of the constraint; empty: none came
    std::string off_reason;
    double off_squared_error = 0.0;
    bool off = false;
  };
  using Chunk = std::pair<NodeKind, std::int64_t>;
  void mark(const NodeId& id);
  void flush();
  void put(const LoopKey& key, const Loop& loop);
  void note_switched_off(const graph_t& message);

  ItemStore& store_;
  std::map<NodeId, Node> nodes_;
  std::set<Chunk> changed_;
  std::int64_t revision_ = 0;
  std::map<LoopKey, Loop> loops_;
  std::deque<LoopKey> rejected_;
};

}  // namespace fusion_slam
