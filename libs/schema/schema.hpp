// Message types as data: what the .lcm files say, for code that has to understand bytes it was not
// compiled for (the decoder guard, info, verify, viewers). No LCM here. A Schema doesn't change
// once built: any thread may read it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fusion_slam {

enum class LcmPrimitive {
  kStruct,  // not a primitive: see LcmMember::nested
  kBoolean,
  kByte,
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kFloat,
  kDouble,
  kString,
};

// Bytes of one encoded value; 0 for strings and structs, whose size varies.
std::size_t size_bytes(LcmPrimitive primitive);

struct LcmType;

// One pair of brackets behind a member: `[3]` or `[n]`, n being an earlier integer member of the
// same struct.
struct LcmDimension {
  std::string text;              // as written
  std::int64_t fixed_count = 0;  // `[3]`: 3
  int length_member = -1;        // `[n]`: index of n among the members; -1: fixed
};

struct LcmMember {
  std::string name;
  std::string type_name;  // int32_t, bot_core.pose_t
  LcmPrimitive primitive = LcmPrimitive::kStruct;
  const LcmType* nested = nullptr;  // set when primitive is kStruct
  std::vector<LcmDimension> dimensions;
};

struct LcmConstant {
  std::string name;
  std::string type_name;
  std::string value;  // as written
};

struct LcmType {
  std::string name;  // with its package: fusion_slam.tile_t
  std::vector<LcmMember> members;
  std::vector<LcmConstant> constants;
  std::uint64_t fingerprint = 0;  // the first 8 bytes of an encoded message, big-endian
  std::size_t min_size_bytes =
      0;  // of an encoding without the fingerprint, all variable arrays empty
  bool starts_with_utime = false;   // first member is `int64_t utime`
  bool continues_with_seq = false;  // and the second is `int64_t seq`
};

// (file name, text) of .lcm files.
using LcmFiles = std::vector<std::pair<std::string, std::string>>;

class Schema {
 public:
  // From files in any order. Throws std::runtime_error "file:line: what
  // is wrong".
  explicit Schema(const LcmFiles& files);
  Schema(const Schema&) = delete;
  Schema& operator=(const Schema&) = delete;

  // nullptr when there is none. The pointer lives as long as the Schema.
  const LcmType* find(const std::string& name) const;
  const LcmType* find(std::uint64_t fingerprint) const;

  // By name.
  const std::map<std::string, LcmType>& types() const { return types_; }

 private:
  std::map<std::string, LcmType> types_;
  std::map<std::uint64_t, const LcmType*> by_fingerprint_;
};

// LCM's rule (lcm-gen's type specification): a hash over each member's name, its type when that is
// a primitive, the number of its dimensions, and each one's mode and text; plus the hashes of
// nested types (0 for one that is being computed already); rotated left by one bit. The type's own
// name, constants and comments don't count.
std::uint64_t fingerprint(const LcmType& type);

// The types in lcmtypes/, compiled into the program.
const Schema& builtin_schema();

}  // namespace fusion_slam
