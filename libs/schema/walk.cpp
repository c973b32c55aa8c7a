#include "libs/schema/walk.hpp"

#include <cstdio>
#include <cstring>
#include <utility>
#include <vector>

#include "libs/schema/big_endian.hpp"

namespace fusion_slam {
namespace {

constexpr int kMaxDepth =
    64;  // structs in structs; a type that holds itself could otherwise exhaust the stack

std::string hex(std::uint64_t value) {
  char text[32];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

class Walker {
 public:
  Walker(const LcmType& type, const std::uint8_t* bytes, std::size_t size_bytes,
         const LcmVisitor& visit)
      : root_(type), at_(bytes), end_(bytes + size_bytes), free_(size_bytes), visit_(visit) {}

  std::optional<std::string> run() {
    if (left() < 8)
      return root_.name + ": " + std::to_string(left()) + " bytes are too few for a fingerprint";
    const std::uint64_t found = read_big_endian(at_, 8);
    if (found != root_.fingerprint) {
      return root_.name + ": fingerprint " + hex(found) + " is not " + hex(root_.fingerprint);
    }
    at_ += 8;
    if (walk_struct(root_) && left() > 0) {
      error_ = root_.name + ": " + std::to_string(left()) +
               " bytes are left over behind the last member";
    }
    return error_.empty() ? std::nullopt : std::optional<std::string>(error_);
  }

 private:
  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }

  bool walk_struct(const LcmType& type) {
    if (++depth_ > kMaxDepth)
      return fail("structs are nested more than " + std::to_string(kMaxDepth) + " deep");
    const std::size_t frame = values_.size();
    values_.resize(frame + type.members.size(), 0);
    for (std::size_t i = 0; i < type.members.size(); ++i) {
      const LcmMember& member = type.members[i];
      path_.emplace_back(&member, std::vector<std::int64_t>());
      std::vector<std::int64_t> counts;
      counts.reserve(member.dimensions.size());
      for (const LcmDimension& d : member.dimensions) {
        counts.push_back(d.length_member < 0
                             ? d.fixed_count
                             : values_[frame + static_cast<std::size_t>(d.length_member)]);
      }
      const std::uint8_t* begin = at_;
      if (!fits(member, counts) || !walk_dimensions(member, counts, 0)) return false;
      const std::size_t size = size_bytes(member.primitive);
      if (counts.empty() && size > 0) values_[frame + i] = read_signed_big_endian(begin, size);
      path_.pop_back();
    }
    values_.resize(frame);
    --depth_;
    return true;
  }

  // Before anything is read: can so many elements be in the bytes that are left?
  bool fits(const LcmMember& member, const std::vector<std::int64_t>& counts) {
    std::size_t element = size_bytes(member.primitive);
    if (member.primitive == LcmPrimitive::kString) element = 5;
    if (member.nested != nullptr) element = member.nested->min_size_bytes;
    std::string lengths;
    std::size_t product = 1;  // elements
    std::size_t containers =
        counts.empty() ? 0 : 1;  // what a decoder makes even when the elements take no bytes
    for (const std::int64_t count : counts) {
      lengths += (lengths.empty() ? "" : " x ") + std::to_string(count);
      if (count < 0) return fail("length " + lengths + " is negative");
      const auto n = static_cast<std::size_t>(count);
      const bool too_many = n > 0 && product > (std::size_t{1} << 40) / n;
      product = too_many ? (std::size_t{1} << 40) : product * n;
      if (product > 0) containers = product;
      if (product == 0 && &count == &counts.front()) containers = 0;
    }
    const bool is_free = product == 0 || element == 0;
    if (is_free && containers > free_) {
      return fail("length " + lengths + " is more than a message of this size can hold");
    }
    if (is_free) free_ -= containers;
    if (!is_free && product > left() / element) {
      return counts.empty() ? fail("needs " + std::to_string(element) + " bytes, " +
                                   std::to_string(left()) + " are left")
                            : fail("length " + lengths + " needs more than the " +
                                   std::to_string(left()) + " bytes left");
    }
    return true;
  }

  bool walk_dimensions(const LcmMember& member, const std::vector<std::int64_t>& counts,
                       std::size_t depth) {
    const std::size_t size = size_bytes(member.primitive);
    if (depth + 1 >= counts.size() && size > 0) {
      const std::int64_t count = counts.empty() ? 1 : counts.back();
      emit(member, count, static_cast<std::size_t>(count) * size);
      at_ += static_cast<std::size_t>(count) * size;
      return true;
    }
    if (depth == counts.size())
      return member.nested != nullptr ? walk_struct(*member.nested) : walk_string(member);
    path_.back().second.push_back(0);
    for (std::int64_t i = 0; i < counts[depth]; ++i) {
      path_.back().second.back() = i;
      if (!walk_dimensions(member, counts, depth + 1)) return false;
    }
    path_.back().second.pop_back();
    return true;
  }

  bool walk_string(const LcmMember& member) {
    if (left() < 4) return fail("needs 4 bytes, " + std::to_string(left()) + " are left");
    const std::int64_t length = read_signed_big_endian(at_, 4);
    at_ += 4;
    if (length < 1)
      return fail("string length " + std::to_string(length) + " (with its NUL) is not positive");
    const auto n = static_cast<std::size_t>(length);
    if (n > left()) {
      return fail("string length " + std::to_string(length) + " needs more than the " +
                  std::to_string(left()) + " bytes left");
    }
    if (at_[n - 1] != 0)
      return fail("string of " + std::to_string(length) + " bytes doesn't end with NUL");
    emit(member, 1, n - 1);
    at_ += n;
    return true;
  }

  void emit(const LcmMember& member, std::int64_t count, std::size_t size) const {
    if (visit_) visit_({path(), &member, at_, count, size});
  }

  std::string path() const {
    std::string text;
    for (const auto& [member, indices] : path_) {
      text += (text.empty() ? "" : ".") + member->name;
      for (const std::int64_t i : indices) text += "[" + std::to_string(i) + "]";
    }
    return text;
  }

  bool fail(const std::string& reason) {
    error_ = root_.name + (path_.empty() ? "" : "." + path()) + ": " + reason;
    return false;
  }

  const LcmType& root_;
  const std::uint8_t* at_;
  const std::uint8_t* end_;
  std::size_t free_;  // how many more elements without bytes are accepted
  const LcmVisitor& visit_;
  std::vector<std::int64_t> values_;  // integer members of the structs being walked, innermost last
  std::vector<std::pair<const LcmMember*, std::vector<std::int64_t>>> path_;
  int depth_ = 0;
  std::string error_;
};

}  // namespace

std::optional<std::string> walk(const LcmType& type, const std::uint8_t* bytes,
                                std::size_t size_bytes, const LcmVisitor& visit) {
  return Walker(type, bytes, size_bytes, visit).run();
}

std::int64_t integer_value(const LcmField& field, std::int64_t index) {
  const LcmPrimitive primitive = field.member->primitive;
  const std::size_t size = size_bytes(primitive);
  if (size == 0 || primitive == LcmPrimitive::kFloat || primitive == LcmPrimitive::kDouble)
    return 0;
  const std::uint8_t* at = field.bytes + static_cast<std::size_t>(index) * size;
  return primitive == LcmPrimitive::kByte ? *at : read_signed_big_endian(at, size);
}

double real_value(const LcmField& field, std::int64_t index) {
  const std::size_t size = size_bytes(field.member->primitive);
  const std::uint8_t* at = field.bytes + static_cast<std::size_t>(index) * size;
  if (field.member->primitive == LcmPrimitive::kFloat) {
    const auto bits = static_cast<std::uint32_t>(read_big_endian(at, 4));
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  if (field.member->primitive == LcmPrimitive::kDouble) {
    const std::uint64_t bits = read_big_endian(at, 8);
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  return static_cast<double>(integer_value(field, index));
}

std::string string_value(const LcmField& field) {
  if (field.member->primitive != LcmPrimitive::kString) return {};
  return {reinterpret_cast<const char*>(field.bytes), field.size_bytes};
}

}  // namespace fusion_slam
