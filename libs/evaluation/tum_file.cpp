#include "libs/evaluation/tum_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace fusion_slam {
namespace {

constexpr char kColumns[] = "time x y z qx qy qz qw";
// Published files carry 4 decimals (norm off by 1e-4); wrong columns are off by far more.
constexpr double kMaxNormError = 0.01;

StampedPose to_pose(const NumberRow& row, const std::string& name) {
  const auto& v = row.values;
  const double norm = std::sqrt(v[4] * v[4] + v[5] * v[5] + v[6] * v[6] + v[7] * v[7]);
  if (std::abs(norm - 1.0) > kMaxNormError) {
    std::array<char, 96> reason{};
    std::snprintf(reason.data(), reason.size(),
                  "quaternion (fields 5 to 8) has norm %.6g, not 1; are these TUM columns?", norm);
    throw FileError(name, row.line, reason.data());
  }
  return {v[0], make_pose({v[1], v[2], v[3]}, v[7], v[4], v[5], v[6])};
}

TumFile to_trajectory(const std::vector<NumberRow>& rows, const std::string& name) {
  TumFile result;
  result.trajectory.reserve(rows.size());
  for (const NumberRow& row : rows) {
    if (!result.trajectory.empty() && row.values[0] < result.trajectory.back().time_s) {
      ++result.out_of_order;
    }
    result.trajectory.push_back(to_pose(row, name));
  }
  const auto earlier = [](const StampedPose& a, const StampedPose& b) {
    return a.time_s < b.time_s;
  };
  std::stable_sort(result.trajectory.begin(), result.trajectory.end(), earlier);
  for (std::size_t i = 1; i < result.trajectory.size(); ++i) {
    if (result.trajectory[i].time_s == result.trajectory[i - 1].time_s) ++result.repeated;
  }
  return result;
}

// "-0.000000000" and "0.000000000" are one value and should be one text.
double without_negative_zero(double value, double half_a_digit) {
  return std::abs(value) < half_a_digit ? 0.0 : value;
}

}  // namespace

TumFile read_tum(std::istream& in, const std::string& name) {
  return to_trajectory(read_number_rows(in, name, kColumns), name);
}

TumFile read_tum(const std::filesystem::path& file) {
  return to_trajectory(read_number_rows(file, kColumns), file.string());
}

void write_tum(std::ostream& out, const Trajectory& trajectory, const std::string& comment) {
  if (!comment.empty()) out << "# " << comment << '\n';
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d& p = pose.T_world_body.translation();
    Eigen::Quaterniond q(pose.T_world_body.linear());
    q.normalize();
    if (q.w() < 0.0) q.coeffs() *= -1.0;
    const std::array<double, 7> values = {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
    std::array<char, 352> text{};  // the largest double has 309 digits before the point
    std::snprintf(text.data(), text.size(), "%.6f", without_negative_zero(pose.time_s, 5e-7));
    out << text.data();
    for (const double value : values) {
      std::snprintf(text.data(), text.size(), " %.9f", without_negative_zero(value, 5e-10));
      out << text.data();
    }
    out << '\n';
  }
}

void write_tum(const std::filesystem::path& file, const Trajectory& trajectory,
               const std::string& comment) {
  std::filesystem::path unfinished = file;
  unfinished += ".part";
  {
    std::ofstream out(unfinished, std::ios::binary);
    write_tum(out, trajectory, comment);
    out.close();
    if (!out)
      throw FileError(unfinished.string(), "can't be written; does the folder exist, is it full?");
  }
  std::error_code error;
  std::filesystem::rename(unfinished, file, error);
  if (error) throw FileError(file.string(), "can't be written: " + error.message());
}

}  // namespace fusion_slam
