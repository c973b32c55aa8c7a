// An RPLidar on an open port: one request at a time, each with its answer or a reason. One thread.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/rplidar/protocol.hpp"
#include "drivers/rplidar/scan_packets.hpp"
#include "drivers/rplidar/serial_port.hpp"

namespace fusion_slam {

// The device did not answer as it should; for people.
struct DeviceError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A way of scanning that the device offers and we can read.
struct ScanMode {
  std::string name = "Standard";  // the device's own, or "Standard", "Express"
  ScanFormat format = ScanFormat::kStandard;
  std::uint8_t id = 0;            // EXPRESS_SCAN's working mode
  double sample_period_s = 5e-4;  // from one measurement to the next
};

class RplidarDevice {
 public:
  // The protocol's document has no number; answers take a few ms, a loaded machine and an adapter
  // some more.
  static constexpr int kAnswerTimeoutMs = 250;

  // `port` must outlive this.
  explicit RplidarDevice(SerialPort& port, int answer_timeout_ms = kAnswerTimeoutMs)
      : port_(port), answer_timeout_ms_(answer_timeout_ms) {}

  // All throw DeviceError (no answer, a wrong one) and PortError (unplugged).
  RplidarInfo info();
  RplidarHealth health();
  // What it offers, standard scan first: by GET_LIDAR_CONF, else GET_SAMPLERATE, else what the
  // first firmware did. Formats that Slamtec does not document (ultra capsules) are left out.
  std::vector<ScanMode> scan_modes(const RplidarInfo& info);
  // Starts `mode`; returns the bytes that came behind the descriptor. Throws DeviceError too when
  // the device answers in another format than `mode` has.
  std::vector<std::uint8_t> start_scan(const ScanMode& mode);

  // Ends a scan and drops what was on its way.
  void stop();
  // Reboots the device: it answers again after about a second.
  void reset();
  // DTR for every model (the A1's motor hangs on it, the others need it off to talk); SET_MOTOR_PWM
  // for A2 and A3 with an accessory board. Later models turn by themselves while they scan.
  void set_motor(bool on, const RplidarInfo& info);

 private:
  std::vector<std::uint8_t> ask(RplidarCommand command, const std::vector<std::uint8_t>& request);
  std::optional<std::vector<std::uint8_t>> conf(RplidarConf entry,
                                                std::optional<std::uint16_t> mode = {});
  std::vector<ScanMode> modes_by_conf();

  SerialPort& port_;
  int answer_timeout_ms_;
  std::vector<std::uint8_t> rest_;
  AnswerDescriptor descriptor_;
};

// The mode to use: "auto": the shortest time between measurements; "standard", "express", "dense":
// the fastest of that format. Throws DeviceError naming what there is.
ScanMode choose_mode(const std::vector<ScanMode>& modes, const std::string& wish);

}  // namespace fusion_slam
