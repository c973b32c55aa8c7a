// Nodes and what hangs on them in journal notes.
#pragma once

#include "libs/graph/node_id.hpp"
#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {

inline void put_node(const NodeId& id, NoteWriter* out) {
  out->put(static_cast<std::int8_t>(id.kind));
  out->put(id.id);
}
inline NodeId get_node(NoteReader* in) {
  const auto kind = in->get<std::int8_t>() == 0 ? NodeKind::kKeyframe : NodeKind::kLidar;
  return {kind, in->get<std::int64_t>()};
}

}  // namespace fusion_slam
