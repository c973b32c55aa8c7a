#include "libs/schema/schema.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "libs/schema/parser.hpp"

namespace fusion_slam {
namespace {

bool is_int64(const LcmType& type, std::size_t index, const char* name) {
  if (index >= type.members.size()) return false;
  const LcmMember& member = type.members[index];
  return member.name == name && member.primitive == LcmPrimitive::kInt64 &&
         member.dimensions.empty();
}

constexpr std::size_t kHugeBytes = std::numeric_limits<std::int32_t>::max();

// Smallest encoding of a type; beyond 2 GB (no message is) the exact number doesn't matter. A type
// that is being measured already holds itself outside a variable array and has no finite encoding.
std::size_t min_size(const LcmType& type, std::map<const LcmType*, std::size_t>* known) {
  if (const auto [entry, is_new] = known->emplace(&type, kHugeBytes); !is_new) return entry->second;
  std::size_t sum = 0;
  for (const LcmMember& member : type.members) {
    bool variable = false;
    for (const LcmDimension& dimension : member.dimensions)
      variable |= dimension.length_member >= 0;
    if (variable) continue;
    std::size_t size = member.primitive == LcmPrimitive::kString ? 5 : size_bytes(member.primitive);
    if (member.nested != nullptr) size = min_size(*member.nested, known);
    for (const LcmDimension& dimension : member.dimensions) {
      const auto count = static_cast<std::size_t>(dimension.fixed_count);
      size = size > kHugeBytes / count ? kHugeBytes : size * count;
    }
    sum = std::min(sum + size, kHugeBytes);
  }
  return (*known)[&type] = sum;
}

}  // namespace

std::size_t size_bytes(LcmPrimitive primitive) {
  switch (primitive) {
    case LcmPrimitive::kStruct:
    case LcmPrimitive::kString:
      return 0;
    case LcmPrimitive::kBoolean:
    case LcmPrimitive::kByte:
    case LcmPrimitive::kInt8:
      return 1;
    case LcmPrimitive::kInt16:
      return 2;
    case LcmPrimitive::kInt32:
    case LcmPrimitive::kFloat:
      return 4;
    case LcmPrimitive::kInt64:
    case LcmPrimitive::kDouble:
      return 8;
  }
  return 0;
}

[[noreturn]] static void refuse_twice(const std::string& file, const std::string& type) {
  throw std::runtime_error(file + ": type " + type + " is defined twice");
}

Schema::Schema(const LcmFiles& files) {
  for (const auto& [file, text] : files) {
    for (LcmType& type : parse_lcm(file, text)) {
      const std::string name = type.name;
      if (!types_.emplace(name, std::move(type)).second) {
        refuse_twice(file, name);
      }
    }
  }
  for (auto& [name, type] : types_) {
    for (LcmMember& member : type.members) {
      if (member.primitive != LcmPrimitive::kStruct) continue;
      member.nested = find(member.type_name);
      if (member.nested == nullptr) {
        throw std::runtime_error(name + "." + member.name + ": there is no type " +
                                 member.type_name);
      }
    }
  }
  std::map<const LcmType*, std::size_t> sizes;
  for (auto& [name, type] : types_) {
    type.fingerprint = fusion_slam::fingerprint(type);  // first: refuses what is nested too deeply
    type.min_size_bytes = min_size(type, &sizes);
    type.starts_with_utime = is_int64(type, 0, "utime");
    type.continues_with_seq = type.starts_with_utime && is_int64(type, 1, "seq");
    // Two types of the same members have the same fingerprint; the first by name stands for both.
    by_fingerprint_.emplace(type.fingerprint, &type);
  }
}

const LcmType* Schema::find(const std::string& name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : &found->second;
}

const LcmType* Schema::find(std::uint64_t fingerprint) const {
  const auto found = by_fingerprint_.find(fingerprint);
  return found == by_fingerprint_.end() ? nullptr : found->second;
}

}  // namespace fusion_slam
