#include "tests/support/virtual_rplidar/wire.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fusion_slam {
namespace {

const std::vector<VirtualModel>& models() {
  static const std::vector<VirtualModel> all = {
      {"a1", 0x18, 1, 29, 7, true, true, false, 115'200, false},
      {"a1-1.20", 0x18, 1, 20, 5, true, false, false, 115'200, false},
      {"a1-1.15", 0x18, 1, 15, 2, false, false, false, 115'200, false},
      {"a2", 0x28, 1, 29, 5, true, true, false, 115'200, true},
      {"s2", 0x71, 1, 2, 18, true, true, true, 1'000'000, false}};
  return all;
}

void put(Bytes* bytes, std::uint64_t value, int n_bytes) {
  for (int i = 0; i < n_bytes; ++i) bytes->push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

std::uint32_t q6(double angle_deg) {
  return static_cast<std::uint32_t>(std::lround(std::fmod(angle_deg + 360.0, 360.0) * 64.0)) %
         (360U * 64U);
}

Bytes seal(Bytes body) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : body) sum ^= byte;
  const Bytes head = {static_cast<std::uint8_t>(0xA0 | (sum & 0x0F)),
                      static_cast<std::uint8_t>(0x50 | (sum >> 4))};
  body.insert(body.begin(), head.begin(), head.end());
  return body;
}

std::uint32_t millimetres(double range_m, std::uint32_t most) {
  const long mm = std::lround(range_m * 1000.0);
  return mm < 0 || mm > static_cast<long>(most) ? 0 : static_cast<std::uint32_t>(mm);
}

}  // namespace

VirtualModel virtual_model(const std::string& name) {
  for (const VirtualModel& model : models())
    if (model.name == name) return model;
  throw std::invalid_argument("no virtual model " + name);
}

std::vector<std::string> virtual_model_names() {
  std::vector<std::string> names;
  for (const VirtualModel& model : models()) names.push_back(model.name);
  return names;
}

namespace wire {

Bytes descriptor(std::uint32_t length_bytes, bool many, std::uint8_t type) {
  Bytes bytes = {0xA5, 0x5A};
  put(&bytes, length_bytes | (many ? 1U << 30 : 0U), 4);
  bytes.push_back(type);
  return bytes;
}

Bytes info(const VirtualModel& model) {
  Bytes bytes = {model.model, model.firmware_minor, model.firmware_major, model.hardware};
  for (int i = 0; i < 16; ++i) bytes.push_back(static_cast<std::uint8_t>(0xC0 + i));
  return bytes;
}

Bytes standard_node(const Sample& s) {
  Bytes bytes;
  bytes.push_back(static_cast<std::uint8_t>((s.quality << 2) | (s.first ? 1 : 2)));
  put(&bytes, (q6(s.angle_deg) << 1) | 1U, 2);
  const long quarter_mm = std::lround(s.range_m * 4000.0);
  put(&bytes, static_cast<std::uint64_t>(quarter_mm > 65535 ? 0 : quarter_mm), 2);
  return bytes;
}

Bytes express_capsule(const std::vector<Sample>& samples, bool first) {
  Bytes body;
  put(&body, q6(samples.front().raw_deg) | (first ? 0x8000U : 0U), 2);
  for (std::size_t i = 0; i < 32; i += 2) {
    std::uint32_t d[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const Sample& s = samples[i + k];
      const double parallax_deg = std::remainder(s.raw_deg - s.angle_deg, 360.0);
      d[k] = static_cast<std::uint32_t>(std::clamp(std::lround(parallax_deg * 8.0), 0L, 63L));
      put(&body, (millimetres(s.range_m, 16383) << 2) | (d[k] >> 4), 2);
    }
    body.push_back(static_cast<std::uint8_t>((d[0] & 0x0F) | ((d[1] & 0x0F) << 4)));
  }
  return seal(body);
}

Bytes dense_capsule(const std::vector<Sample>& samples, bool first) {
  Bytes body;
  put(&body, q6(samples.front().raw_deg) | (first ? 0x8000U : 0U), 2);
  for (std::size_t i = 0; i < 40; ++i) put(&body, millimetres(samples[i].range_m, 65535), 2);
  return seal(body);
}

std::uint8_t answer_type(const VirtualModel& model, unsigned mode) {
  switch (mode) {
    case 0:
      return 0x81;
    case 1:
      return 0x82;
    case 2:
      return 0x84;  // ultra capsules: offered by real devices, not documented
    case 3:
      return model.has_dense ? 0x85 : 0;
    default:
      return 0;
  }
}

Bytes conf(const VirtualModel& model, std::uint32_t entry, unsigned mode, double standard_period_s,
           double express_period_s) {
  static const char* const kNames[] = {"Standard", "Express", "Boost", "DenseBoost"};
  Bytes value;
  if (entry == 0x70) put(&value, model.has_dense ? 4 : 3, 2);
  if (entry == 0x7C) put(&value, 1, 2);
  if (answer_type(model, mode) == 0) return value;
  if (entry == 0x71)
    put(&value,
        static_cast<std::uint64_t>(
            std::llround(256e6 * (mode == 0 ? standard_period_s : express_period_s))),
        4);
  if (entry == 0x75) value.push_back(answer_type(model, mode));
  if (entry == 0x7F) {
    for (const char* c = kNames[mode]; *c != '\0'; ++c)
      value.push_back(static_cast<std::uint8_t>(*c));
    value.push_back(0);
  }
  return value;
}

}  // namespace wire
}  // namespace fusion_slam
