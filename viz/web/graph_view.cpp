#include "viz/web/graph_view.hpp"

#include <algorithm>

#include "libs/messages/convert.hpp"
#include "viz/web/protocol.hpp"

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMostId = 4'000'000'000;  // the page's ids are uint32

std::optional<NodeId> node_of(int kind, std::int64_t id) {
  if (kind < 0 || kind > 1 || id < 1 || id > kMostId) return std::nullopt;
  return NodeId{static_cast<NodeKind>(kind), id};
}

std::string text_of(int kind, std::int64_t id) {
  return std::string(kind == 0 ? "k" : "l") + std::to_string(id);
}

}  // namespace

std::string to_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

void GraphView::mark(const NodeId& id) { changed_.emplace(id.kind, id.id / kChunkNodes); }

void GraphView::on_keyframe(const keyframe_t& message) {
  const auto id = node_of(0, message.id);
  if (!id) return;
  nodes_[*id].previous_id = std::clamp<std::int64_t>(message.previous_id, 0, kMostId);
  nodes_[*id].utime_us = message.utime;
  mark(*id);
}

void GraphView::on_lidar_node(const lidar_node_t& message) {
  const auto id = node_of(1, message.id);
  if (!id) return;
  nodes_[*id].previous_id = std::clamp<std::int64_t>(message.previous_id, 0, kMostId);
  nodes_[*id].utime_us = message.utime;
  mark(*id);
}

void GraphView::on_graph(const graph_t& message) {
  if (message.complete && message.part == 0 && message.revision < revision_) clear();  // restarted
  revision_ = std::max(revision_, message.revision);
  for (const graph_node_t& moved : message.nodes) {
    const auto id = node_of(moved.kind, moved.id);
    const auto T_map_base = from_message(moved.T_map_base);
    if (!id || !T_map_base) continue;
    Node& node = nodes_[*id];
    if (node.T_map_base && node.T_map_base->isApprox(*T_map_base, 1e-9)) continue;
    node.T_map_base = T_map_base;
    node.utime_us = moved.utime;
    mark(*id);
  }
  if (message.part == 0) note_switched_off(message);
  if (message.part + 1 >= message.n_parts) flush();
}

// One record of 44 bytes a node: u32 id, u32 previous id, f64 utime (us), pose.
void GraphView::flush() {
  for (const auto& [kind, block] : changed_) {
    ByteWriter out;
    const NodeId begin{kind, block * kChunkNodes};
    const NodeId end{kind, (block + 1) * kChunkNodes};
    for (auto node = nodes_.lower_bound(begin); node != nodes_.lower_bound(end); ++node) {
      if (!node->second.T_map_base) continue;
      out.u32(static_cast<std::uint32_t>(node->first.id));
      out.u32(static_cast<std::uint32_t>(node->second.previous_id));
      out.f64(static_cast<double>(node->second.utime_us)).pose(*node->second.T_map_base);
    }
    store_.put(Topic::kNodes, text_of(static_cast<int>(kind), block), out.take());
  }
  changed_.clear();
}

void GraphView::note_switched_off(const graph_t& message) {
  std::map<LoopKey, const loop_state_t*> off;
  for (const loop_state_t& loop : message.switched_off)
    off[{loop.from_kind, loop.from_id, loop.to_kind, loop.to_id}] = &loop;
  for (auto& [key, loop] : loops_) {
    const auto state = off.find(key);
    const bool is_off = state != off.end();
    if (is_off == loop.off) continue;
    loop.off = is_off;
    loop.off_reason = is_off ? state->second->reason : "";
    loop.off_squared_error = is_off ? state->second->squared_error : 0.0;
    put(key, loop);
  }
}

void GraphView::on_candidate(const loop_candidate_t& message) {
  const LoopKey key{message.from_kind, message.from_id, message.to_kind, message.to_id};
  const bool is_new = loops_.count(key) == 0;
  Loop& loop = loops_[key];
  loop.utime_us = message.utime;
  loop.accepted = loop.accepted || message.accepted;
  loop.stages = Json::array();
  for (const stage_verdict_t& stage : message.stages)
    loop.stages.push_back({{"stage", stage.stage},
                           {"score", stage.score},
                           {"threshold", stage.threshold},
                           {"passed", stage.passed != 0},
                           {"reason", stage.reason}});
  put(key, loop);
  if (!is_new || loop.accepted) return;
  rejected_.push_back(key);
  if (rejected_.size() <= kMostRejected) return;
  const auto oldest = loops_.find(rejected_.front());
  if (oldest != loops_.end() && !oldest->second.accepted && oldest->second.source.empty()) {
    const auto& [from_kind, from, to_kind, to] = oldest->first;
    store_.remove(Topic::kLoop, text_of(from_kind, from) + "-" + text_of(to_kind, to));
    loops_.erase(oldest);
  }
  rejected_.pop_front();
}

void GraphView::on_constraint(const constraint_t& message) {
  const LoopKey key{message.from_kind, message.from_id, message.to_kind, message.to_id};
  Loop& loop = loops_[key];
  loop.accepted = true;
  loop.utime_us = message.utime;
  loop.source = message.source.empty() ? "unnamed" : message.source;
  put(key, loop);
}

void GraphView::put(const LoopKey& key, const Loop& loop) {
  const auto& [from_kind, from, to_kind, to] = key;
  const char* state = loop.off ? "switched_off" : loop.accepted ? "closed" : "rejected";
  Json json = {
      {"from", text_of(from_kind, from)}, {"to", text_of(to_kind, to)}, {"state", state},
      {"utime", loop.utime_us},           {"source", loop.source},      {"stages", loop.stages}};
  if (loop.off) {
    json["off_reason"] = loop.off_reason;
    json["off_squared_error"] = loop.off_squared_error;
  }
  store_.put(Topic::kLoop, text_of(from_kind, from) + "-" + text_of(to_kind, to), to_text(json));
}

std::size_t GraphView::loops_closed() const {
  return static_cast<std::size_t>(
      std::count_if(loops_.begin(), loops_.end(),
                    [](const auto& entry) { return entry.second.accepted && !entry.second.off; }));
}

void GraphView::clear() {
  nodes_.clear();
  changed_.clear();
  revision_ = 0;
  loops_.clear();
  rejected_.clear();
  store_.remove_all(Topic::kNodes);
  store_.remove_all(Topic::kLoop);
}

}  // namespace fusion_slam
