// The decoder guard. Decoders that lcm-gen writes trust the lengths in a message: a negative or
// huge one throws out of a C callback or allocates gigabytes, and any process on the network can
// send one. Ask the guard first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "libs/schema/schema.hpp"

namespace fusion_slam {

// A generated C++ decoder allocates at most this many bytes for each byte of a message that passed
// check(). Worst types of lcmtypes/: image_metadata_t, 64 bytes of struct for 9 on the wire, then
// strings, 32 for 5; an empty array of a struct costs what the struct itself does. An array of
// arrays with variable sizes would cost up to 24 more; lcmtypes/ has none.
constexpr std::size_t kDecodedBytesPerByte = 8;

// Nothing when `bytes` (from the fingerprint on) are exactly one message of `type`; else the
// reason, for people: "fusion_slam.tile_t.data: length 2000000000 needs more than the 120 bytes
// left". Checked: fingerprint, lengths neither negative nor beyond the bytes left, strings
// NUL-terminated, nothing missing, nothing left over. Not checked: what the numbers mean. Any
// thread.
std::optional<std::string> check(const LcmType& type, const std::uint8_t* bytes,
                                 std::size_t size_bytes);

// The builtin type whose fingerprint stands at the head of `bytes`; nullptr when there is none.
const LcmType* peek_type(const std::uint8_t* bytes, std::size_t size_bytes);

// `utime` (us) and `seq` of a message whose builtin type begins with `int64_t utime` (and goes on
// with `int64_t seq`). They don't need a message that passes check(), only one that is long enough.
std::optional<std::int64_t> peek_utime(const std::uint8_t* bytes, std::size_t size_bytes);
std::optional<std::int64_t> peek_seq(const std::uint8_t* bytes, std::size_t size_bytes);

}  // namespace fusion_slam
