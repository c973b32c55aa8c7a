#include "logplayer/map_merge/renumber.hpp"

#include <algorithm>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/constraint_t.hpp"
#include "fusion_slam/graph_node_t.hpp"
#include "fusion_slam/keyframe_image_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/lidar_node_t.hpp"
#include "fusion_slam/pose_estimate_t.hpp"
#include "fusion_slam/tile_t.hpp"
#include "libs/map_directory/decode.hpp"
#include "libs/schema/guard.hpp"

namespace fusion_slam {
namespace {

void shift(std::int64_t offset, std::int64_t* id) {
  if (*id > 0) *id += offset;
}

std::int64_t of_kind(const Offsets& o, std::int8_t kind) {
  if (kind == graph_node_t::KEYFRAME) return o.keyframe;
  return kind == graph_node_t::LIDAR ? o.lidar_node : 0;
}

void change(const Offsets& o, keyframe_t* m) {
  shift(o.keyframe, &m->id);
  shift(o.keyframe, &m->previous_id);
  for (std::int64_t& id : m->refined_id) shift(o.keyframe, &id);
  for (std::int64_t& id : m->landmark_id) shift(o.landmark, &id);
  m->T_odom_base.utime += o.time_us;
  m->T_previous_base.utime += o.time_us;
}

void change(const Offsets& o, keyframe_image_t* m) {
  shift(o.keyframe, &m->id);
  m->images.utime += o.time_us;
  for (auto& image : m->images.images) image.utime += o.time_us;
}

void change(const Offsets& o, lidar_node_t* m) {
  shift(o.lidar_node, &m->id);
  shift(o.lidar_node, &m->previous_id);
  for (std::int64_t& id : m->submap_ids) shift(o.lidar_node, &id);
  m->T_odom_base.utime += o.time_us;
  m->T_previous_base.utime += o.time_us;
}

void change(const Offsets& o, constraint_t* m) {
  shift(of_kind(o, m->from_kind), &m->from_id);
  shift(of_kind(o, m->to_kind), &m->to_id);
}

void change(const Offsets& o, pose_estimate_t* m) {
  shift(of_kind(o, m->reference_kind), &m->reference_id);
  m->fix_utime += o.time_us;
  m->T_frame_base.utime += o.time_us;
  m->T_reference_base.utime += o.time_us;
}

void change(const Offsets& o, tile_t* m) { shift(o.lidar_node, &m->submap_id); }

void number(std::int64_t /*offset*/, bot_core::pose_t* /*m*/) {}  // has no sequence number
template <class Message>
void number(std::int64_t offset, Message* m) {
  m->seq += offset;
}
void change(const Offsets& /*o*/, bot_core::pose_t* /*m*/) {}

template <class Message>
LogEvent with(const LogEvent& event, const Offsets& offsets) {
  auto message = decode<Message>(event);
  if (!message) return event;
  change(offsets, &*message);
  message->utime += offsets.time_us;
  const auto seq = offsets.seq.find(event.channel);
  if (seq != offsets.seq.end()) number(seq->second, &*message);
  LogEvent changed = event;
  changed.timestamp_us += offsets.time_us;
  changed.data.resize(static_cast<std::size_t>(message->getEncodedSize()));
  message->encode(changed.data.data(), 0, static_cast<int>(changed.data.size()));
  return changed;
}

}  // namespace

void note_largest(const LogEvent& event, Offsets* largest) {
  if (const auto seq = peek_seq(event.data.data(), event.data.size())) {
    std::int64_t& known = largest->seq[event.channel];
    known = std::max(known, *seq);
  }
  if (event.channel == "KEYFRAME") {
    const auto m = decode<keyframe_t>(event);
    if (!m) return;
    largest->keyframe = std::max(largest->keyframe, m->id);
    for (const std::int64_t id : m->landmark_id)
      largest->landmark = std::max(largest->landmark, id);
  } else if (event.channel == "LIDAR_NODE") {
    if (const auto m = decode<lidar_node_t>(event))
      largest->lidar_node = std::max(largest->lidar_node, m->id);
  }
}

LogEvent renumbered(const LogEvent& event, const Offsets& offsets) {
  if (event.channel == "KEYFRAME") return with<keyframe_t>(event, offsets);
  if (event.channel == "KEYFRAME_IMAGE") return with<keyframe_image_t>(event, offsets);
  if (event.channel == "LIDAR_NODE") return with<lidar_node_t>(event, offsets);
  if (event.channel == "CONSTRAINT" || event.channel == "LEVEL")
    return with<constraint_t>(event, offsets);
  if (event.channel == "VISUAL_POSE" || event.channel == "LIDAR_POSE")
    return with<pose_estimate_t>(event, offsets);
  if (event.channel == "ODOMETRY") return with<bot_core::pose_t>(event, offsets);
  if (event.channel == "SUBMAP") return with<tile_t>(event, offsets);
  return event;
}

}  // namespace fusion_slam
