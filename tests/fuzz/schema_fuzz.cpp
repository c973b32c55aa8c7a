// link: fs_schema
// Any text as a .lcm file: parsed, or refused with a runtime_error.
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include "libs/schema/guard.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  try {
    const fusion_slam::Schema schema(fusion_slam::LcmFiles{
        {"fuzz.lcm", std::string(reinterpret_cast<const char*>(bytes), size)}});
    for (const auto& [name, type] : schema.types()) {
      if (schema.find(name) != &type) std::abort();
      // The text itself is a message of none of its types, whatever it says.
      fusion_slam::check(type, bytes, size);
    }
  } catch (const std::runtime_error&) {
  }
  return 0;
}
