#include "drivers/rplidar/scan_parser.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace fusion_slam {
namespace {

// A place is taken for a row of nodes when so many in a row fit: each fits by chance in one case of
// five.
constexpr std::size_t kRowOfNodes = 8;
constexpr std::size_t kNodeBytes = 5;
// Between neighbours: parallax moves near objects by up to 25 degrees (measured: 25.5).
constexpr double kLargestJumpDeg = 40.0;
// A turn's first and last samples are as far from zero as parallax allows.
constexpr double kTurnSlackDeg = 40.0;
// From one capsule to the next; more than 1.6 times the step before means that one is missing.
constexpr double kLargestStepDeg = 180.0;
constexpr double kStepGrowth = 1.6;
constexpr std::size_t kMostPending = 32'768;  // samples: 4 s of the fastest device
constexpr double kFewest = 8;
// Whole nodes that a full buffer swallows leave no trace but a turn with fewer samples. A real
// motor's turns differ by 3 %.
constexpr double kUnevenShare = 0.08;
// A byte too few or too many is seen one to three nodes later: a turn is handed out when so many
// samples behind it fit.
constexpr std::size_t kConfirmation = 8;

// -180 to 180.
double wrap_deg(double angle_deg) { return std::remainder(angle_deg, 360.0); }

double to_turn(double angle_deg) {
  const double a = std::fmod(angle_deg, 360.0);
  return a < 0.0 ? a + 360.0 : a;
}

}  // namespace

ScanParser::ScanParser(ScanFormat format, double sample_period_s, double byte_period_s)
    : format_(format),
      sample_period_s_(sample_period_s),
      byte_period_us_(byte_period_s * 1e6),
      clock_(sample_period_s) {
  turn_.has_quality = format == ScanFormat::kStandard;
}

void ScanParser::add(const std::uint8_t* bytes, std::size_t n_bytes, std::int64_t arrival_us,
                     std::vector<Revolution>* revolutions) {
  counters_.bytes += static_cast<std::int64_t>(n_bytes);
  buffer_.insert(buffer_.end(), bytes, bytes + n_bytes);
  const auto end_us = static_cast<double>(arrival_us);
  if (format_ == ScanFormat::kStandard)
    add_standard(end_us, revolutions);
  else
    add_capsules(end_us, revolutions);
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = 0;
}

// The bytes behind the packet at at_ came later, one byte time each; the packet itself was measured
// before it was sent.
double ScanParser::packet_end_us(double end_us) const {
  return end_us - byte_period_us_ * static_cast<double>(buffer_.size() - at_);
}

void ScanParser::skip(std::size_t n_bytes) {
  at_ += n_bytes;
  counters_.skipped_bytes += static_cast<std::int64_t>(n_bytes);
}

void ScanParser::lose_framing() {
  if (framed_) ++counters_.bad_packets;
  framed_ = false;
  turn_damaged_ = true;
  if (finished_) ++counters_.damaged;
  finished_.reset();
  capsule_.reset();
  last_step_deg_ = 0.0;
  clock_.restart();
}

bool ScanParser::find_nodes() {
  while (buffer_.size() - at_ >= kRowOfNodes * kNodeBytes) {
    std::size_t n = 0;
    double last_deg = 0.0;
    for (; n < kRowOfNodes; ++n) {
      const auto node = decode_node(&buffer_[at_ + n * kNodeBytes]);
      if (!node || (n > 0 && std::abs(wrap_deg(node->angle_deg - last_deg)) > kLargestJumpDeg))
        break;
      last_deg = node->angle_deg;
      if (n == 0) last_angle_deg_ = last_deg;
    }
    if (n == kRowOfNodes) return true;
    skip(1);
  }
  return false;
}

void ScanParser::add_standard(double end_us, std::vector<Revolution>* revolutions) {
  while (buffer_.size() - at_ >= kNodeBytes) {
    if (!framed_ && !(framed_ = find_nodes())) return;
    const auto node = decode_node(&buffer_[at_]);
    if (!node || std::abs(wrap_deg(node->angle_deg - last_angle_deg_)) > kLargestJumpDeg) {
      lose_framing();
      skip(1);
      continue;
    }
    clock_.bound(counters_.samples, packet_end_us(end_us));
    last_angle_deg_ = node->angle_deg;
    at_ += kNodeBytes;
    const std::int64_t utime_us = clock_.utime_us(counters_.samples++);
    add_sample(node->turn_begins,
               {to_turn(node->angle_deg), node->range_m, node->quality, utime_us}, revolutions);
  }
}

void ScanParser::add_capsules(double end_us, std::vector<Revolution>* revolutions) {
  const std::size_t n_bytes = packet_bytes(format_);
  while (buffer_.size() - at_ >= n_bytes) {
    auto capsule = decode_capsule(format_, &buffer_[at_]);
    if (!capsule) {
      lose_framing();
      skip(1);
      continue;
    }
    const double latest_us = packet_end_us(end_us);
    framed_ = true;
    at_ += n_bytes;
    const double step_deg = capsule_ ? to_turn(capsule->start_deg - capsule_->start_deg) : 0.0;
    const bool missing = step_deg > kLargestStepDeg ||
                         (last_step_deg_ > 0.0 && step_deg > kStepGrowth * last_step_deg_ + 1.0);
    if (capsule_ && (missing || capsule->scan_begins)) {
      lose_framing();
      framed_ = true;
    }
    const auto n = static_cast<double>(samples_per_packet(format_));
    if (capsule_) {
      // What a capsule holds was measured before it was sent.
      for (std::size_t k = 0; k < capsule_->samples.size(); ++k) {
        const Capsule::Sample& sample = capsule_->samples[k];
        const double raw_deg = to_turn(capsule_->start_deg + step_deg * static_cast<double>(k) / n);
        const bool turn_begins = raw_deg < last_raw_deg_ - 180.0;
        last_raw_deg_ = raw_deg;
        const std::int64_t utime_us = clock_.utime_us(counters_.samples++);
        add_sample(turn_begins,
                   {to_turn(raw_deg - sample.parallax_deg), sample.range_m, 0, utime_us},
                   revolutions);
      }
      last_step_deg_ = step_deg;
    } else {
      last_raw_deg_ = capsule->start_deg;
    }
    capsule_ = std::move(capsule);
    const auto last = counters_.samples + static_cast<std::int64_t>(capsule_->samples.size()) - 1;
    clock_.bound(last, latest_us);
  }
}

void ScanParser::add_sample(bool turn_begins, const Measurement& measurement,
                            std::vector<Revolution>* revolutions) {
  if (turn_begins) {
    if (turn_begun_) finish_turn();
    turn_.measurements.clear();
    turn_begun_ = true;
    turn_damaged_ = false;
    turned_deg_ = 0.0;
  }
  if (!turn_begun_) return;
  if (turn_.measurements.size() >= kMostPending) {
    ++counters_.incomplete;
    turn_.measurements.clear();
    turn_begun_ = false;
    return;
  }
  if (!turn_.measurements.empty())
    turned_deg_ += wrap_deg(measurement.angle_deg - turn_.measurements.back().angle_deg);
  turn_.measurements.push_back(measurement);
  if (!finished_ || turn_.measurements.size() < kConfirmation) return;
  ++counters_.revolutions;
  revolutions->push_back(std::move(*finished_));
  finished_.reset();
}

void ScanParser::finish_turn() {
  finished_.reset();
  if (turn_damaged_) {
    ++counters_.damaged;
    last_count_ = 0.0;
    return;
  }
  const auto count = static_cast<double>(turn_.measurements.size());
  const bool uneven =
      last_count_ > 0.0 && std::abs(count - last_count_) > kUnevenShare * last_count_;
  last_count_ = count;
  if (count < kFewest || uneven || std::abs(turned_deg_ - 360.0) > kTurnSlackDeg) {
    ++counters_.incomplete;
    return;
  }
  turn_.period_s = sample_period_s_ * static_cast<double>(turn_.measurements.size());
  finished_ = turn_;
}

}  // namespace fusion_slam
