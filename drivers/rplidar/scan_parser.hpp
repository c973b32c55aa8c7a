// From the bytes of a scan to whole turns: pure, no port, no clock of its own. Noise, lost and
// changed bytes cost the turn in which they are seen, never more: framing is found again by itself.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drivers/rplidar/sample_clock.hpp"
#include "drivers/rplidar/scan_packets.hpp"

namespace fusion_slam {

struct Measurement {
  double angle_deg = 0.0;  // clockwise seen from above, 0 to 360, as the device corrected it
  double range_m = 0.0;    // 0: no return
  int quality = 0;         // 0 to 63, standard format only
  std::int64_t utime_us = 0;
};

// One turn, from the turning part's zero to its zero, in order of measurement. Angles are not quite
// in order: the correction for parallax moves near objects by up to 25 degrees.
struct Revolution {
  std::vector<Measurement> measurements;
  double period_s = 0.0;  // of the turn
  bool has_quality = false;
};

struct ScanParserCounters {
  std::int64_t bytes = 0;
  std::int64_t skipped_bytes = 0;  // that belong to no packet
  std::int64_t bad_packets = 0;    // check bits or checksum wrong where a packet had to be
  std::int64_t samples = 0;
  std::int64_t revolutions = 0;  // handed out
  std::int64_t damaged = 0;      // turns not handed out: a packet in them was bad or missing
  std::int64_t incomplete =
      0;  // turns not handed out: they did not go around once, or have far more
          // or fewer samples than the one before (lost, or the motor's speed jumps)
};

class ScanParser {
 public:
  // sample_period_s: time from one measurement to the next. byte_period_s: time of one byte on the
  // line, 10 / baud.
  ScanParser(ScanFormat format, double sample_period_s, double byte_period_s);

  // Takes bytes as they were read; arrival_us: when the last of them was there. Appends the turns
  // that are now whole. Never throws on content and keeps less than 2 MB whatever comes.
  void add(const std::uint8_t* bytes, std::size_t n_bytes, std::int64_t arrival_us,
           std::vector<Revolution>* revolutions);

  const ScanParserCounters& counters() const { return counters_; }
  // Samples of the turn that is not yet whole: grows without end when the motor stands.
  std::size_t pending() const { return turn_.measurements.size(); }

 private:
  void add_standard(double end_us, std::vector<Revolution>* revolutions);
  void add_capsules(double end_us, std::vector<Revolution>* revolutions);
  bool find_nodes();    // moves to the next place that looks like a row of nodes
  void lose_framing();  // a packet did not fit
  void skip(std::size_t n_bytes);
  double packet_end_us(double end_us) const;
  void add_sample(bool turn_begins, const Measurement& measurement,
                  std::vector<Revolution>* revolutions);
  void finish_turn();

  ScanFormat format_;
  double sample_period_s_;
  double byte_period_us_;
  SampleClock clock_;
  ScanParserCounters counters_;

  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;  // of the next packet in buffer_
  bool framed_ = false;
  double last_angle_deg_ = 0.0;  // standard: of the node before

  std::optional<Capsule> capsule_;  // waits for the next one's start angle
  double last_step_deg_ = 0.0;      // from capsule to capsule; 0: unknown
  double last_raw_deg_ = 0.0;

  std::optional<Revolution> finished_;  // handed out when what follows it fits
  Revolution turn_;
  bool turn_begun_ = false;
  bool turn_damaged_ = false;
  double turned_deg_ = 0.0;  // angle covered by turn_
  double last_count_ = 0.0;  // samples of the turn before; 0: unknown
};

}  // namespace fusion_slam
