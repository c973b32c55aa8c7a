#include "drivers/simulator/image_motion.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr float kStillPx = 0.1F;  // less motion than this is not worth sampling
constexpr float kFarM = 1e6F;

// image_velocity in single precision with what is constant in a row taken out.
struct RowFlow {
  RowFlow(const CameraModel& camera, const CameraTwist& twist, int v)
      : fx(static_cast<float>(camera.fx_px)),
        fy(static_cast<float>(camera.fy_px)),
        cx(static_cast<float>(camera.cx_px)),
        y(static_cast<float>((v - camera.cy_px) / camera.fy_px)),
        lin(twist.linear_m_s.cast<float>()),
        ang(twist.angular_rad_s.cast<float>()) {}
  // dx, dy in px/s, dz in m/s of what pixel u shows at depth z.
  void at(int u, float z, float* du, float* dv, float* dz) const {
    const float x = (static_cast<float>(u) - cx) / fx;
    const float inverse = 1.0F / (z > 0.0F ? z : kFarM);
    const float turn = ang.x() * y - ang.y() * x;  // of z, a metre away
    *du = fx * ((x * lin.z() - lin.x()) * inverse - (ang.y() - ang.z() * y) + x * turn);
    *dv = fy * ((y * lin.z() - lin.y()) * inverse - (ang.z() * x - ang.x()) + y * turn);
    *dz = -lin.z() - turn * (z > 0.0F ? z : 0.0F);
  }
  float fx, fy, cx, y;
  Eigen::Vector3f lin, ang;
};

cv::Vec3f bilinear(const cv::Mat_<cv::Vec3f>& image, float u, float v) {
  u = std::clamp(u, 0.0F, static_cast<float>(image.cols - 1));
  v = std::clamp(v, 0.0F, static_cast<float>(image.rows - 1));
  const int u0 = std::min(static_cast<int>(u), image.cols - 2);
  const int v0 = std::min(static_cast<int>(v), image.rows - 2);
  const float fu = u - static_cast<float>(u0), fv = v - static_cast<float>(v0);
  const cv::Vec3f* top = image[v0] + u0;
  const cv::Vec3f* low = image[v0 + 1] + u0;
  cv::Vec3f out;
  for (int k = 0; k < 3; ++k) {
    const float a = top[0][k] + fu * (top[1][k] - top[0][k]);
    const float b = low[0][k] + fu * (low[1][k] - low[0][k]);
    out[k] = a + fv * (b - a);
  }
  return out;
}

}  // namespace

CameraTwist twist_between(const SE3& T_world_camera_before, const SE3& T_world_camera_after,
                          double dt_s) {
  const SE3 T = T_world_camera_before.inverse() * T_world_camera_after;
  return {T.translation() / dt_s, log_so3(T.linear()) / dt_s};
}

Eigen::Vector2d image_velocity(const CameraModel& camera, const CameraTwist& twist, double u_px,
                               double v_px, double z_m) {
  const double z = z_m > 0.0 ? z_m : static_cast<double>(kFarM);
  const Eigen::Vector3d p = camera.unproject(u_px, v_px, z);
  const Eigen::Vector3d dp = -twist.linear_m_s - twist.angular_rad_s.cross(p);
  return {camera.fx_px * (dp.x() - p.x() / z * dp.z()) / z,
          camera.fy_px * (dp.y() - p.y() / z * dp.z()) / z};
}

cv::Mat_<cv::Vec3f> expose_moving(const CameraModel& camera, const CameraTwist& twist,
                                  const ShutterModel& shutter, const cv::Mat_<cv::Vec3f>& colour,
                                  const cv::Mat_<float>& depth_m) {
  cv::Mat_<cv::Vec3f> out(colour.size());
  const auto open = static_cast<float>(shutter.open_s);
  for (int v = 0; v < colour.rows; ++v) {
    const RowFlow flow(camera, twist, v);
    const auto row_s =
        static_cast<float>(shutter.readout_s * (static_cast<double>(v) / (colour.rows - 1) - 0.5));
    for (int u = 0; u < colour.cols; ++u) {
      float du = 0.0F, dv = 0.0F, dz = 0.0F;
      flow.at(u, depth_m(v, u), &du, &dv, &dz);
      const float length = std::max(std::fabs(du), std::fabs(dv));
      if (length * (open + std::fabs(row_s)) < kStillPx) {
        out(v, u) = colour(v, u);
        continue;
      }
      const int n = std::min(1 + static_cast<int>(std::ceil(length * open)), 24);
      cv::Vec3f sum(0, 0, 0);
      for (int k = 0; k < n; ++k) {
        const float at_s =
            row_s + open * ((static_cast<float>(k) + 0.5F) / static_cast<float>(n) - 0.5F);
        sum +=
            bilinear(colour, static_cast<float>(u) - du * at_s, static_cast<float>(v) - dv * at_s);
      }
      out(v, u) = sum * (1.0F / static_cast<float>(n));
    }
  }
  return out;
}

cv::Mat_<float> depth_later(const CameraModel& camera, const CameraTwist& twist, double delay_s,
                            const cv::Mat_<float>& depth_m) {
  cv::Mat_<float> out(depth_m.size());
  const auto delay = static_cast<float>(delay_s);
  for (int v = 0; v < depth_m.rows; ++v) {
    const RowFlow flow(camera, twist, v);
    for (int u = 0; u < depth_m.cols; ++u) {
      float du = 0.0F, dv = 0.0F, dz = 0.0F;
      flow.at(u, depth_m(v, u), &du, &dv, &dz);
      const int from_u = std::clamp(
          static_cast<int>(std::lrintf(static_cast<float>(u) - du * delay)), 0, depth_m.cols - 1);
      const int from_v = std::clamp(
          static_cast<int>(std::lrintf(static_cast<float>(v) - dv * delay)), 0, depth_m.rows - 1);
      const float z = depth_m(from_v, from_u);
      out(v, u) = z > 0.0F ? z + dz * delay : 0.0F;
    }
  }
  return out;
}

}  // namespace fusion_slam
