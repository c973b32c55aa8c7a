#include "libs/schema/guard.hpp"

#include "libs/schema/big_endian.hpp"
#include "libs/schema/walk.hpp"

namespace fusion_slam {

std::optional<std::string> check(const LcmType& type, const std::uint8_t* bytes,
                                 std::size_t size_bytes) {
  return walk(type, bytes, size_bytes, {});
}

const LcmType* peek_type(const std::uint8_t* bytes, std::size_t size_bytes) {
  return size_bytes < 8 ? nullptr : builtin_schema().find(read_big_endian(bytes, 8));
}

std::optional<std::int64_t> peek_utime(const std::uint8_t* bytes, std::size_t size_bytes) {
  const LcmType* type = peek_type(bytes, size_bytes);
  if (type == nullptr || !type->starts_with_utime || size_bytes < 16) return std::nullopt;
  return read_signed_big_endian(bytes + 8, 8);
}

std::optional<std::int64_t> peek_seq(const std::uint8_t* bytes, std::size_t size_bytes) {
  const LcmType* type = peek_type(bytes, size_bytes);
  if (type == nullptr || !type->continues_with_seq || size_bytes < 24) return std::nullopt;
  return read_signed_big_endian(bytes + 16, 8);
}

}  // namespace fusion_slam
