// link: fs_schema fs_all_types
// Any bytes as a message of every type. What the guard lets through, the generated decoder must
// read to the last byte, without an exception and without allocating more than the documented
// multiple of the message.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "all_types.hpp"
#include "libs/schema/big_endian.hpp"
#include "libs/schema/guard.hpp"
#include "libs/schema/walk.hpp"
#include "tests/fuzz/allocations.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;

void require(bool ok, const char* what, const char* type) {
  if (ok) return;
  std::fprintf(stderr, "%s: %s\n", type, what);
  std::abort();
}

template <class Message>
void try_type(const char* name, Bytes bytes) {
  const auto fingerprint = static_cast<std::uint64_t>(Message::getHash());
  fusion_slam::write_big_endian(fingerprint, 8, bytes.data());
  const fusion_slam::LcmType& type = *fusion_slam::builtin_schema().find(fingerprint);
  if (fusion_slam::check(type, bytes.data(), bytes.size())) return;

  std::size_t walked = 8;
  fusion_slam::walk(type, bytes.data(), bytes.size(), [&](const fusion_slam::LcmField& field) {
    require(field.bytes >= bytes.data() && field.size_bytes <= bytes.size(),
            "a field outside the message", name);
    const bool is_string = field.member->primitive == fusion_slam::LcmPrimitive::kString;
    walked += field.size_bytes + (is_string ? 5 : 0);
  });
  require(walked == bytes.size(), "the fields are not the whole message", name);

  const std::size_t before = fusion_slam::allocated_bytes();
  Message message;
  const int decoded = message.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
  require(decoded == static_cast<int>(bytes.size()), "the decoder did not read the whole message",
          name);
  require(fusion_slam::allocated_bytes() - before <=
              fusion_slam::kDecodedBytesPerByte * bytes.size() + 64,
          "the decoder allocated more than documented", name);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::count_allocations();
  fusion_slam::peek_utime(data, size);
  fusion_slam::peek_seq(data, size);
  if (size < 8) return 0;
  const Bytes bytes(data, data + size);
#define FS_TRY(package, type) try_type<package::type>(#package "." #type, bytes);
  FS_FOR_EACH_TYPE(FS_TRY)
  return 0;
}
