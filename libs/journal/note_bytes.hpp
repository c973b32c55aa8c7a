// What services write down of themselves in journal notes, number by number. As this machine has
// them in memory (little-endian on all that we run on): a journal is read where it was written.
// Pure.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

class NoteWriter {
 public:
  explicit NoteWriter(std::vector<std::uint8_t>* bytes) : bytes_(bytes) {}

  template <class Number>
  void put(Number number) {
    static_assert(std::is_arithmetic<Number>::value);
    const std::size_t at = bytes_->size();
    bytes_->resize(at + sizeof number);
    std::memcpy(bytes_->data() + at, &number, sizeof number);
  }
  void count(std::size_t n) { put(static_cast<std::uint32_t>(n)); }
  void pose(const SE3& T) {
    for (int i = 0; i < 12; ++i) put(T.matrix()(i % 3, i / 3));
  }
  void symmetric(const Matrix6d& M) {
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column <= row; ++column) put(M(row, column));
  }
  template <class Vector>
  void vector(const Vector& v) {
    for (int i = 0; i < 3; ++i) put(v[i]);
  }
  void some(const std::vector<std::uint8_t>& some) {
    count(some.size());
    bytes_->insert(bytes_->end(), some.begin(), some.end());
  }

 private:
  std::vector<std::uint8_t>* bytes_;
};

// Never throws on any bytes and never reads behind them: good() turns false, and what is read from
// then on is 0 or nothing. Doubles and floats of poses, matrices and vectors are finite; poses are
// rigid motions of less than 100 km.
class NoteReader {
 public:
  NoteReader(const std::uint8_t* bytes, std::size_t size_bytes) : at_(bytes), left_(size_bytes) {}

  template <class Number>
  Number get() {
    Number number{};
    if (left_ < sizeof number) {
      good_ = false;
      left_ = 0;
      return number;
    }
    std::memcpy(&number, at_, sizeof number);
    at_ += sizeof number;
    left_ -= sizeof number;
    return number;
  }
  bool flag() { return get<std::uint8_t>() != 0; }
  SE3 pose() {
    SE3 T = SE3::Identity();
    for (int i = 0; i < 12; ++i) T.matrix()(i % 3, i / 3) = finite(get<double>());
    expect(T.linear().isUnitary(1e-3) && T.translation().cwiseAbs().maxCoeff() < 1e5);
    return good_ ? T : SE3::Identity();
  }
  Matrix6d symmetric() {
    Matrix6d M;
    for (int row = 0; row < 6; ++row)
      for (int column = 0; column <= row; ++column)
        M(row, column) = M(column, row) = finite(get<double>());
    return M;
  }
  template <class Number>
  Eigen::Matrix<Number, 3, 1> vector() {
    Eigen::Matrix<Number, 3, 1> v;
    for (int i = 0; i < 3; ++i) v[i] = static_cast<Number>(finite(get<Number>()));
    return v;
  }
  std::vector<std::uint8_t> some() {
    const std::size_t size = count(1);
    std::vector<std::uint8_t> bytes(at_, at_ + size);
    at_ += size;
    left_ -= size;
    return bytes;
  }
  // How many things of at least so many bytes follow: never more than there is room for.
  std::size_t count(std::size_t each_bytes) {
    const std::size_t n = get<std::uint32_t>();
    if (n * each_bytes <= left_) return n;
    good_ = false;
    return 0;
  }
  double finite() { return finite(get<double>()); }
  // What is read is of no use unless this holds.
  void expect(bool holds) { good_ = good_ && holds; }
  bool good() const { return good_; }
  bool more() const { return good_ && left_ > 0; }

 private:
  double finite(double value) {
    good_ = good_ && std::isfinite(value);
    return value;
  }
  const std::uint8_t* at_;
  std::size_t left_;
  bool good_ = true;
};

}  // namespace fusion_slam
