// Finds the answer to a request among whatever else comes (the rest of a scan, a boot text, noise).
// Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/rplidar/protocol.hpp"

namespace fusion_slam {

class AnswerParser {
 public:
  explicit AnswerParser(RplidarCommand command) : command_(command) {}

  // True when the answer is whole: its descriptor and, unless it is a scan, its one packet. Never
  // throws on content. Bytes after the answer are kept for rest().
  bool add(const std::uint8_t* bytes, std::size_t n_bytes);

  const AnswerDescriptor& descriptor() const { return *descriptor_; }  // after add() was true
  std::vector<std::uint8_t> packet() const;                            // after add() was true
  std::vector<std::uint8_t> rest() const;                              // after add() was true

  // What has come instead, for people: "nothing", "37 bytes without a descriptor", "a descriptor of
  // type 0x06, 3 bytes, one packet".
  std::string seen() const;

 private:
  bool find_descriptor();

  RplidarCommand command_;
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;  // searched up to here; then where the packet begins
  std::optional<AnswerDescriptor> descriptor_;
  std::optional<AnswerDescriptor> other_;  // well-formed, but no answer to this request
};

}  // namespace fusion_slam
