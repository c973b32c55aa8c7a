// Rigid motions. T_a_b takes points in b to a: p_a = T_a_b * p_b. Lengths in metres, angles in
// radians. All functions are pure and may be called from any thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace fusion_slam {

using SE3 = Eigen::Isometry3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Planar rigid motion; yaw in (-pi, pi].
struct SE2 {
  double x = 0.0;
  double y = 0.0;
  double yaw = 0.0;

  SE2 operator*(const SE2& other) const;
  Eigen::Vector2d operator*(const Eigen::Vector2d& p) const;
  SE2 inverse() const;
};

// The same angle in (-pi, pi].
double wrap_angle(double angle_rad);

// Rotation vector of a rotation matrix and back (Rodrigues), exact near 0 and near pi.
Eigen::Vector3d log_so3(const Eigen::Matrix3d& rotation);
Eigen::Matrix3d exp_so3(const Eigen::Vector3d& rotation_vector);

// Matrix v^ such that v^ * w = v x w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);

// Retraction used for every covariance of this project: T * (translation, exp(rotation)), with
// xi = (translation 3, rotation 3) in T's own axes. local() is its inverse: retract(T, local(T, U))
// = U.
SE3 retract(const SE3& T, const Vector6d& xi);
Vector6d local(const SE3& T, const SE3& other);

// On the path from a (fraction 0) to b (fraction 1): translation linear, rotation slerp.
// Extrapolates.
SE3 interpolate(const SE3& a, const SE3& b, double fraction);

// From position (m) and quaternion w, x, y, z (normalised here; a zero quaternion counts as
// identity).
SE3 make_pose(const Eigen::Vector3d& position_m, double w, double x, double y, double z);

// SE(2) as SE(3) with z, roll and pitch 0; and the projection back (yaw of the x axis).
SE3 to_se3(const SE2& pose);
SE2 to_se2(const SE3& pose);

// From x, y, z (m) and roll, pitch, yaw (rad), R = Rz(yaw) * Ry(pitch) * Rx(roll).
SE3 from_xyz_rpy(double x, double y, double z, double roll, double pitch, double yaw);

// The smallest rotation that takes `up` (unit) to z.
Eigen::Matrix3d rotation_to_z(const Eigen::Vector3d& up);

// The motion L of a whole map (p_new = L * p_old) that gives a pose in it the z, roll and pitch of
// T_new_a and turns and shifts everything else as little as that allows: the smallest rotation,
// about the map's origin, then a shift along z. The origin's x and y stay.
SE3 levelling(const SE3& T_old_a, const SE3& T_new_a);

// The rotation of a camera that looks along base x: T_base_camera of an optical frame without
// offset.
Eigen::Matrix3d optical_to_body();

}  // namespace fusion_slam
