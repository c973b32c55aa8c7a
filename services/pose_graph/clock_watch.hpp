// Tells a clock that was set back from a message that comes late: what is said later (by its
// number) was measured earlier.
#pragma once

#include <cstdint>

#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {

class ClockWatch {
 public:
  // True: between this message and the one before it the clock was set back by a second or more.
  bool was_set_back(std::int64_t seq, std::int64_t utime_us) {
    if (seq <= seq_ && utime_us <= utime_us_) return false;  // late
    if (seq <= seq_) {                                       // a publisher that was started again
      anew_us_ = utime_us;
      before_ = seq_;
    }
    // What the publisher before it had still to say is late, too, whatever its numbers.
    if (utime_us < anew_us_ && seq > before_) return false;
    const bool back = seq_ > 0 && utime_us < utime_us_ - kBack_us;
    seq_ = seq;
    utime_us_ = utime_us;
    return back;
  }

  void write(NoteWriter* out) const {  // for the journal
    for (const std::int64_t n : {seq_, utime_us_, anew_us_, before_}) out->put(n);
  }
  void read(NoteReader* in) {
    for (std::int64_t* n : {&seq_, &utime_us_, &anew_us_, &before_}) *n = in->get<std::int64_t>();
  }

 private:
  static constexpr std::int64_t kBack_us = 1'000'000;  // stamps of one sensor vary by far less
  std::int64_t seq_ = 0;
  std::int64_t utime_us_ = 0;
  std::int64_t anew_us_ = 0;  // first heard of the publisher that speaks now
  std::int64_t before_ = 0;   // last heard of the one before
};

}  // namespace fusion_slam
