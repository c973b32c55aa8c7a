// Writes messages of generated types to an LCM log, with ROBOT_MODEL and CAMERA_MODEL once a second
// of log time in between.
#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "libs/config/robot_config.hpp"
#include "libs/eventlog/writer.hpp"

namespace fusion_slam {

class LogOutput {
 public:
  LogOutput(LogWriter* writer, RobotConfig config) : writer_(writer), config_(std::move(config)) {}

  // `message` is any type of lcm-gen. Throws std::runtime_error when the disk is full.
  template <typename Message>
  void write(std::int64_t utime_us, const std::string& channel, const Message& message) {
    write_models(utime_us);
    encode(utime_us, channel, message);
  }

  const std::map<std::string, std::int64_t>& counts() const { return counts_; }
  std::int64_t largest_message_bytes() const { return largest_bytes_; }

 private:
  void write_models(std::int64_t utime_us);
  template <typename Message>
  void encode(std::int64_t utime_us, const std::string& channel, const Message& message) {
    buffer_.resize(static_cast<std::size_t>(message.getEncodedSize()));
    if (message.encode(buffer_.data(), 0, static_cast<int>(buffer_.size())) < 0)
      throw std::runtime_error("a message for " + channel + " cannot be encoded");
    writer_->write(utime_us, channel, buffer_);
    ++counts_[channel];
    largest_bytes_ = std::max(largest_bytes_, static_cast<std::int64_t>(buffer_.size()));
  }

  LogWriter* writer_;
  RobotConfig config_;
  std::int64_t next_models_us_ = INT64_MIN;
  std::int64_t models_seq_ = 0;
  std::map<std::string, std::int64_t> counts_;
  std::int64_t largest_bytes_ = 0;
  std::vector<std::uint8_t> buffer_;
};

}  // namespace fusion_slam
