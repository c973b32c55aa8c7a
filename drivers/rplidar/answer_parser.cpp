#include "drivers/rplidar/answer_parser.hpp"

namespace fusion_slam {
namespace {

// No answer of any model is longer: more is A5 5A by chance.
constexpr std::uint32_t kLongestAnswer = 1024;

}  // namespace

bool AnswerParser::add(const std::uint8_t* bytes, std::size_t n_bytes) {
  bytes_.insert(bytes_.end(), bytes, bytes + n_bytes);
  if (!descriptor_ && !find_descriptor()) return false;
  return descriptor_->send_mode != 0 || bytes_.size() - at_ >= descriptor_->length_bytes;
}

bool AnswerParser::find_descriptor() {
  // A5 5A also comes about by chance, in a scan: only the right answer's descriptor counts.
  for (; at_ + kDescriptorBytes <= bytes_.size(); ++at_) {
    const auto found = decode_descriptor(&bytes_[at_]);
    if (!found) continue;
    if (is_answer_to(command_, *found)) {
      descriptor_ = found;
      at_ += kDescriptorBytes;
      return true;
    }
    if (found->send_mode <= 1 && found->length_bytes <= kLongestAnswer) other_ = found;
  }
  return false;
}

std::vector<std::uint8_t> AnswerParser::packet() const {
  const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
  return {begin, begin + static_cast<std::ptrdiff_t>(descriptor_->length_bytes)};
}

std::vector<std::uint8_t> AnswerParser::rest() const {
  const std::size_t packet = descriptor_->send_mode == 0 ? descriptor_->length_bytes : 0;
  return {bytes_.begin() + static_cast<std::ptrdiff_t>(at_ + packet), bytes_.end()};
}

std::string AnswerParser::seen() const {
  if (descriptor_) return "the descriptor but not the data behind it";
  if (other_) return "a wrong descriptor (" + to_string(*other_) + ")";
  if (bytes_.empty()) return "nothing";
  return std::to_string(bytes_.size()) + " bytes without a descriptor";
}

}  // namespace fusion_slam
