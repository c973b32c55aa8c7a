// What the dense mapper's process keeps in its journal, and how it goes on from there: the map as
// it was packed, and the images that aren't in it for good.
#include <cstring>

#include "fusion_slam/constraint_t.hpp"
#include "services/dense_mapper/dense_mapper_process.hpp"

namespace fusion_slam {
namespace {

constexpr const char* kChannel = "DENSE_MAP";
enum Flag : std::uint8_t {
  kAnew = 1,        // what was noted before is void
  kMore = 2,        // of no use without the notes that follow
  kFinished = 4,    // COMMAND finish has come
  kBeginsAnew = 8,  // after COMMAND reset, no keyframe yet
};
constexpr std::size_t kHeadBytes = 17;  // flags; reset's border, newest command's utime
constexpr std::size_t kMostNumbers = 2000;

}  // namespace

// An earlier process's images are mapped where the graph has their keyframes now: so they are read
// when the graph is known, and none waits in memory for its pose.
void DenseMapperProcess::keep_journal() {
  bus_.keep_in_journal({"KEYFRAME_IMAGE", "COMMAND"}, Bus::Recover::kWhenAsked);
  bus_.keep_in_journal({"CAMERA_MODEL", "ROBOT_MODEL"});
  bus_.keep_said<constraint_t>("LEVEL", [](const constraint_t&) {});
  bus_.on_note<journal_note_t>(kChannel, [this](const journal_note_t& m) { on_saved(m); });
  Bus::JournalNeeds needs;
  needs.first_of = {"CAMERA_MODEL", "ROBOT_MODEL"};
  needs.numbers = [this](const std::string& channel) { return needed_numbers(channel); };
  needs.note_state = [this] { write_all_down(); };
  bus_.keep_journal_small(std::move(needs));
}

void DenseMapperProcess::on_saved(const journal_note_t& message) {
  if (message.data.size() < kHeadBytes) {
    saved_is_whole_ = false;
    return;
  }
  const std::uint8_t flags = message.data[0];
  std::int64_t border_us = 0;
  std::memcpy(&border_us, message.data.data() + 1, 8);
  std::memcpy(&commands_upto_us_, message.data.data() + 9, 8);
  reset_.restore(border_us);
  finished_ = (flags & kFinished) != 0;
  begins_anew_ = (flags & kBeginsAnew) != 0;
  if ((flags & kAnew) != 0) saved_.emplace();
  if (!saved_) return;
  const std::size_t n = message.data.size() - kHeadBytes;
  const bool read = n == 0 || read_saved(message.data.data() + kHeadBytes, n, &*saved_);
  if (!read) {  // what follows builds on it
    saved_.reset();
    bus_.report_error(
        "the journal's map is damaged or of another version: images are mapped again");
  }
  saved_is_whole_ = read && (flags & kMore) == 0;
}

void DenseMapperProcess::go_on_where_it_ended() {
  if (bus_.mode() == Mode::kLive) mapper_->keep_changes();
  if (!saved_ || !saved_is_whole_) return;
  went_on_ = mapper_->restore(std::move(*saved_));
  all_is_due_ = !went_on_;
  if (!went_on_)
    bus_.report_error(
        "the journal's map has another resolution than ROBOT_MODEL says now: images "
        "are mapped again");
  saved_.reset();
}

void DenseMapperProcess::note(std::uint8_t flags, const SavedBytes& bytes) {
  if (finished_) flags |= kFinished;
  if (begins_anew_) flags |= kBeginsAnew;
  const std::int64_t border_us = reset_.border_us();
  journal_note_t message{};
  message.utime = commands_upto_us_;
  message.data.resize(kHeadBytes + bytes.size());
  message.data[0] = flags;
  std::memcpy(message.data.data() + 1, &border_us, 8);
  std::memcpy(message.data.data() + 9, &commands_upto_us_, 8);
  std::copy(bytes.begin(), bytes.end(), message.data.begin() + kHeadBytes);
  message.size_bytes = static_cast<std::int32_t>(message.data.size());
  bus_.note(kChannel, message);
}

void DenseMapperProcess::write_all_down() {
  if (!mapper_) return;
  note(kAnew | kMore, {});
  mapper_->write_all([this](const SavedBytes& bytes) { note(kMore, bytes); });
  note(0, {});
}

void DenseMapperProcess::write_down() {
  if (bus_.mode() != Mode::kLive || bus_.recovering()) return;
  if (std::exchange(all_is_due_, false)) return write_all_down();
  const SavedBytes changes = mapper_->take_changes();
  if (!changes.empty()) note(0, changes);
  if (number_.size() > kMostNumbers) needed_numbers("KEYFRAME_IMAGE");
}

std::set<std::int64_t> DenseMapperProcess::needed_numbers(const std::string& channel) {
  if (channel != "KEYFRAME_IMAGE" || !mapper_) return {};
  std::set<std::int64_t> ids = mapper_->needed_images();
  for (const auto& [id, image] : pending_) ids.insert(id);
  std::map<std::int64_t, std::int64_t> number;
  std::set<std::int64_t> numbers;
  for (const std::int64_t id : ids) {
    const auto it = number_.find(id);
    if (it == number_.end()) continue;
    number.insert(*it);
    numbers.insert(it->second);
  }
  number_ = std::move(number);
  return numbers;
}

}  // namespace fusion_slam
