// What the driver needs to know. Times: why they are what they are; nobody has to set them.
#pragma once

#include <string>

namespace fusion_slam {

struct RplidarConfig {
  // A user's choices (sensor file, command line).
  std::string port;   // path, pattern with *, or empty: look for it
  int baud = 0;       // 0: 115200 (A1, A2M8), 256000 (A2M12, A3, S1), 460800 (C1), 1000000 (S2, S3)
  std::string model;  // "a1" ...: anything else that answers is refused; empty: all
  std::string scan_mode = "auto";  // auto, standard, express, dense

  // A device that scans sends something every 15 ms (32 samples at 2 kHz); USB adapters add 16 ms.
  int silence_ms = 300;
  // The motor of an A1 needs about a second to reach its speed, and samples come only then.
  int first_sample_ms = 1500;
  // Bytes come, but no whole turn of them: something is wrong with the line or the format.
  int no_turn_ms = 1000;
  // Data sheets: 1 to 10 turns/s (A1), 5 to 15 (A2, A3). Below 2 a sweep of a moving robot is not
  // one picture any more.
  double slowest_hz = 2.0;
  // Between attempts. With an answer's time-out and the first turn this stays below 1 s.
  int retry_ms = 200;
  // After RESET: boot and self-test, about a second.
  int boot_ms = 2000;
};

}  // namespace fusion_slam
