// Walks an encoded message (big-endian, as on the wire and in logs) by its type, without decoding
// or allocating it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "libs/schema/schema.hpp"

namespace fusion_slam {

// A run of values that lie side by side: a single member, an array of numbers, one row of an array
// of arrays, or one string. The pointer is into the message.
struct LcmField {
  std::string path;  // images[1].size
  const LcmMember* member = nullptr;
  const std::uint8_t* bytes = nullptr;  // first value; the first character of a string
  std::int64_t count = 0;               // values; 1 for a string
  std::size_t size_bytes = 0;           // of the run; of a string without its NUL
};

using LcmVisitor = std::function<void(const LcmField&)>;

// Calls `visit` (may be empty) for each run in the message's order. Returns why the bytes are no
// message of this type: "fusion_slam.tile_t.data: length 2000000000 needs more than the 120 bytes
// left"; fields before the damage have then been visited. Takes time linear in size_bytes whatever
// the bytes are, and memory that depends on the type only.
std::optional<std::string> walk(const LcmType& type, const std::uint8_t* bytes,
                                std::size_t size_bytes, const LcmVisitor& visit);

// Value `index` of a run of integers, booleans, bytes; 0 for other members.
std::int64_t integer_value(const LcmField& field, std::int64_t index = 0);
// Value `index` of a run of numbers; 0 for strings.
double real_value(const LcmField& field, std::int64_t index = 0);
// A string's text; empty for other members.
std::string string_value(const LcmField& field);

}  // namespace fusion_slam
