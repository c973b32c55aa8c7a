// What the loop detector writes down of itself, so that a restart need not read the whole journal:
// docs/formats.md has the bytes.
#include "libs/graph/node_bytes.hpp"
#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kPoseBytes = 96;

template <class Numbers>
void put_numbers(const Numbers& numbers, NoteWriter* out) {
  out->count(numbers.size());
  for (const std::int64_t number : numbers) out->put(number);
}

template <class Take>
void get_numbers(NoteReader* in, Take take) {
  for (std::size_t n = in->count(8); n > 0; --n) take(in->get<std::int64_t>());
}

}  // namespace

void GraphKnowledge::write(NoteWriter* out) const {
  out->count(nodes_.size());
  for (const auto& [id, node] : nodes_) {
    put_node(id, out);
    out->put(node.utime_us);
    out->pose(node.T_odom_base);
  }
  out->count(newest_.size());
  for (const auto& [kind, id] : newest_) put_node({kind, id}, out);
  out->count(T_map_base_.size());
  for (const auto& [id, T_map_base] : T_map_base_) {
    put_node(id, out);
    out->pose(T_map_base);
  }
  out->count(tied_.size());
  for (const auto& [id, tied] : tied_) put_node(id, out);
  edges_.write(out);
}

bool GraphKnowledge::read(NoteReader* in) {
  for (std::size_t n = in->count(17 + kPoseBytes); n > 0; --n) {
    const NodeId id = get_node(in);
    Node& node = nodes_[id];
    node.utime_us = in->get<std::int64_t>();
    node.T_odom_base = in->pose();
    if (id.kind == NodeKind::kLidar) scans_by_time_[node.utime_us] = id;
  }
  for (std::size_t n = in->count(9); n > 0; --n) {
    const NodeId id = get_node(in);
    newest_[id.kind] = id.id;
  }
  for (std::size_t n = in->count(9 + kPoseBytes); n > 0; --n) {
    const NodeId id = get_node(in);
    T_map_base_[id] = in->pose();
  }
  for (std::size_t n = in->count(9); n > 0; --n) tied_[get_node(in)] = true;
  return edges_.read(in);
}

void SubmapStore::write(NoteWriter* out) const {
  out->count(submaps_.size());
  for (const auto& [id, submap] : submaps_) {
    out->put(id);
    out->put(submap.last_utime_us);
    out->count(submap.members.size());
    for (const Member& member : submap.members) {
      out->put(member.node_id);
      for (const double x :
           {member.T_submap_base.x, member.T_submap_base.y, member.T_submap_base.yaw})
        out->put(x);
    }
  }
  out->count(submaps_of_.size());
  for (const auto& [node, memberships] : submaps_of_) {
    out->put(node);
    out->count(memberships.size());
    for (const LoopScan::Membership& in : memberships) {
      out->put(in.submap_id);
      out->pose(in.T_submap_base);
    }
  }
}

void SubmapStore::read(NoteReader* in) {
  for (std::size_t n = in->count(20); n > 0; --n) {
    Submap& submap = submaps_[in->get<std::int64_t>()];
    submap.last_utime_us = in->get<std::int64_t>();
    for (std::size_t members = in->count(32); members > 0; --members) {
      Member member;
      member.node_id = in->get<std::int64_t>();
      member.T_submap_base.x = in->finite();
      member.T_submap_base.y = in->finite();
      member.T_submap_base.yaw = in->finite();
      submap.members.push_back(member);
    }
  }
  for (std::size_t n = in->count(12); n > 0; --n) {
    auto& memberships = submaps_of_[in->get<std::int64_t>()];
    for (std::size_t k = in->count(8 + kPoseBytes); k > 0; --k) {
      const auto submap_id = in->get<std::int64_t>();
      memberships.push_back({submap_id, in->pose()});
    }
  }
}

void LoopDetector::write(NoteWriter* out) const {
  out->put(kVersion);
  for (const std::int64_t n : {counts_.keyframes, counts_.scans, counts_.lidar_searches,
                               counts_.candidates, counts_.accepted, counts_.retired,
                               counts_.nothing_new, last_keyframe_, last_scan_, chain_begins_at_})
    out->put(n);
  out->put(static_cast<std::uint8_t>(T_odom_searched_.has_value()));
  out->pose(T_odom_searched_.value_or(SE3::Identity()));
  std::set<std::int64_t> kept = kept_before_;
  for (const auto& [id, keyframe] : keyframes_) kept.insert(id);
  put_numbers(kept, out);
  put_numbers(known_places_, out);
  put_numbers(links_, out);
  graph_.write(out);
  submaps_.write(out);
}

bool LoopDetector::restore(NoteReader* in) {
  LoopDetector restored(robot_, config_);
  restored.camera_ = camera_;
  bool good = in->get<std::uint8_t>() == kVersion;
  LoopCounts& c = restored.counts_;
  for (std::int64_t* n :
       {&c.keyframes, &c.scans, &c.lidar_searches, &c.candidates, &c.accepted, &c.retired,
        &c.nothing_new, &restored.last_keyframe_, &restored.last_scan_, &restored.chain_begins_at_})
    *n = in->get<std::int64_t>();
  const bool searched = in->flag();
  const SE3 T_odom_searched = in->pose();
  if (searched) restored.T_odom_searched_ = T_odom_searched;
  get_numbers(in, [&](std::int64_t id) { restored.kept_before_.insert(id); });
  get_numbers(in, [&](std::int64_t id) { restored.known_places_.insert(id); });
  get_numbers(in, [&](std::int64_t id) { restored.links_.push_back(id); });
  good = restored.graph_.read(in) && good;
  restored.submaps_.read(in);
  good = good && in->good() && !in->more();
  if (!good) {
    restored = LoopDetector(robot_, config_);
    restored.camera_ = camera_;
  }
  *this = std::move(restored);
  return good;
}

std::set<std::int64_t> LoopDetector::needed_keyframes() const {
  std::set<std::int64_t> numbers;
  for (const auto& [id, keyframe] : keyframes_) numbers.insert(keyframe.seq);
  return numbers;
}

std::set<std::int64_t> LoopDetector::needed_scans() const {
  std::set<std::int64_t> numbers;
  for (const auto& [id, scan] : scans_) numbers.insert(scan.seq);
  return numbers;
}

}  // namespace fusion_slam
