#include <stdexcept>

#include "libs/schema/schema.hpp"

namespace fusion_slam {
namespace {

// Signed shift right: LCM's generator hashes in an int64.
std::uint64_t mix(std::uint64_t hash, std::uint64_t character) {
  const auto high = static_cast<std::uint64_t>(static_cast<std::int64_t>(hash) >> 55);
  return ((hash << 8) ^ high) + character;
}

// Lengths and characters are signed bytes to LCM's generator.
std::uint64_t mix_byte(std::uint64_t hash, std::size_t value) {
  return mix(
      hash, static_cast<std::uint64_t>(static_cast<std::int64_t>(static_cast<std::int8_t>(value))));
}

std::uint64_t mix(std::uint64_t hash, const std::string& text) {
  hash = mix_byte(hash, text.size());
  for (const char c : text) hash = mix_byte(hash, static_cast<unsigned char>(c));
  return hash;
}

std::uint64_t own_hash(const LcmType& type) {
  std::uint64_t hash = 0x12345678;
  for (const LcmMember& member : type.members) {
    hash = mix(hash, member.name);
    if (member.primitive != LcmPrimitive::kStruct) hash = mix(hash, member.type_name);
    hash = mix_byte(hash, member.dimensions.size());
    for (const LcmDimension& dimension : member.dimensions) {
      hash = mix_byte(hash, dimension.length_member < 0 ? 0 : 1);
      hash = mix(hash, dimension.text);
    }
  }
  return hash;
}

// A chain of the types being computed, innermost first.
struct Parents {
  const LcmType* type;
  const Parents* outer;
};

// The rule costs time exponential in the nesting: a type of 64 levels with two members each would
// never finish.
constexpr int kMaxSteps = 10'000;

std::uint64_t recursive_hash(const LcmType& type, const Parents* parents, int* steps) {
  if (++*steps > kMaxSteps) throw std::runtime_error("type " + type.name + " is nested too deeply");
  for (const Parents* p = parents; p != nullptr; p = p->outer) {
    if (p->type == &type) return 0;
  }
  const Parents chain{&type, parents};
  std::uint64_t hash = own_hash(type);
  for (const LcmMember& member : type.members) {
    if (member.nested != nullptr) hash += recursive_hash(*member.nested, &chain, steps);
  }
  return (hash << 1) | (hash >> 63);
}

}  // namespace

std::uint64_t fingerprint(const LcmType& type) {
  int steps = 0;
  return recursive_hash(type, nullptr, &steps);
}

}  // namespace fusion_slam
