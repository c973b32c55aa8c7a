// The bytes of an RPLidar, written from Slamtec's document apart from the driver's reader: a
// mistake in one of them shows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fusion_slam {

using Bytes = std::vector<std::uint8_t>;

struct VirtualModel {
  std::string name;
  std::uint8_t model = 0x18;
  std::uint8_t firmware_major = 1;
  std::uint8_t firmware_minor = 29;
  std::uint8_t hardware = 7;
  bool has_rates = true;   // GET_SAMPLERATE, EXPRESS_SCAN
  bool has_conf = true;    // GET_LIDAR_CONF
  bool has_dense = false;  // mode 3
  int baud = 115'200;
  bool has_board = false;  // SET_MOTOR_PWM; the motor stands until told
};
// a1, a1-1.20 (without GET_LIDAR_CONF), a1-1.15 (standard scan only), a2, s2. Throws
// std::invalid_argument.
VirtualModel virtual_model(const std::string& name);
std::vector<std::string> virtual_model_names();

namespace wire {

Bytes descriptor(std::uint32_t length_bytes, bool many, std::uint8_t type);
Bytes info(const VirtualModel& model);

struct Sample {
  double raw_deg = 0.0;    // of the turning part
  double angle_deg = 0.0;  // reported
  double range_m = 0.0;
  int quality = 0;
  bool first = false;  // of its turn
};
Bytes standard_node(const Sample& sample);
Bytes express_capsule(const std::vector<Sample>& samples, bool first);  // 32
Bytes dense_capsule(const std::vector<Sample>& samples, bool first);    // 40

// Value of a GET_LIDAR_CONF entry behind its echo; empty: there is none.
Bytes conf(const VirtualModel& model, std::uint32_t entry, unsigned mode, double standard_period_s,
           double express_period_s);
// Answer type of a scan mode: 0x81, 0x82, 0x84, 0x85, or 0.
std::uint8_t answer_type(const VirtualModel& model, unsigned mode);

}  // namespace wire
}  // namespace fusion_slam
