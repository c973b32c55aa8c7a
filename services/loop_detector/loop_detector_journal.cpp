// What the loop detector's process keeps in its journal, and how it goes on from there. Nodes of an
// earlier process are remembered, not searched again: what it found is in the graph.
#include <cstring>

#include "services/loop_detector/loop_detector_process.hpp"

namespace fusion_slam {
namespace {

constexpr const char* kState = "LOOP_STATE";
constexpr std::size_t kHeadBytes = 8;  // reset's border
// Three quarters of a minute of driving. A state is 10 MB after 40 minutes in the same rooms, and
// what went since then takes 3 s to be contracted again after 90 keyframes.
constexpr int kKeyframesAState = 60;

}  // namespace

void LoopDetectorProcess::keep_journal() {
  bus_.keep_in_journal({"CAMERA_MODEL", "ROBOT_MODEL", "LIDAR_NODE", "KEYFRAME", "COMMAND"});
  bus_.keep_said<constraint_t>("CONSTRAINT", [this](const constraint_t& m) { on_earlier_loop(m); });
  bus_.on_note<graph_t>(kRetiredNote,
                        [this](const graph_t& m) { take_note(m, &earlier_places_.retired); });
  bus_.on_note<graph_t>(kKnownPlacesNote,
                        [this](const graph_t& m) { take_note(m, &earlier_places_.known); });
  bus_.on_note<journal_note_t>(kState, [this](const journal_note_t& m) { on_saved(m); });
  Bus::JournalNeeds needs;
  needs.first_of = {"CAMERA_MODEL", "ROBOT_MODEL"};
  needs.numbers = [this](const std::string& channel) -> std::set<std::int64_t> {
    if (!detector_) return {};
    if (channel == "KEYFRAME") return detector_->needed_keyframes();
    if (channel == "LIDAR_NODE") return detector_->needed_scans();
    return {};
  };
  needs.note_state = [this] { write_down(); };
  bus_.keep_journal_small(std::move(needs));
}

void LoopDetectorProcess::on_earlier_loop(const constraint_t& message) {
  if (const auto loop = from_message(message)) earlier_loops_.push_back(*loop);
}

// What was noted before is in it, or void.
void LoopDetectorProcess::on_saved(const journal_note_t& message) {
  if (message.data.size() < kHeadBytes)
    return bus_.report_error("the journal's state is damaged: keyframes are read one by one");
  std::int64_t border_us = 0;
  std::memcpy(&border_us, message.data.data(), kHeadBytes);
  reset_.restore(border_us);
  saved_.assign(message.data.begin() + kHeadBytes, message.data.end());
  earlier_loops_.clear();
  earlier_places_ = {};
}

void LoopDetectorProcess::write_down() {
  keyframes_since_written_ = 0;
  const std::int64_t border_us = reset_.border_us();
  journal_note_t message{};
  message.data.resize(kHeadBytes);
  std::memcpy(message.data.data(), &border_us, kHeadBytes);
  NoteWriter out(&message.data);
  if (detector_) detector_->write(&out);
  message.size_bytes = static_cast<std::int32_t>(message.data.size());
  bus_.note(kState, message);
}

// A restart contracts again what went since then.
void LoopDetectorProcess::write_down_now_and_then() {
  if (bus_.mode() == Mode::kLive && ++keyframes_since_written_ >= kKeyframesAState) write_down();
}

void LoopDetectorProcess::go_on_where_it_ended() {
  if (!saved_.empty()) {
    NoteReader in(saved_.data(), saved_.size());
    if (!detector_->restore(&in))
      bus_.report_error(
          "the journal's state is damaged or of another version: places that were seen before it "
          "was written may not be known again");
    saved_ = {};
  }
  detector_->remember(std::exchange(earlier_places_, {}));
  for (const LoopMeasurement& loop : std::exchange(earlier_loops_, {})) detector_->remember(loop);
}

// A process that is built up again from the journal needs no GRAPH to come to the same places.
void LoopDetectorProcess::note_news() {
  const KnownPlacesNews news = detector_->take_news();
  if (!news.retired.empty()) bus_.note(kRetiredNote, note_of(news.retired));
  if (!news.known.empty()) bus_.note(kKnownPlacesNote, note_of(news.known));
}

}  // namespace fusion_slam
