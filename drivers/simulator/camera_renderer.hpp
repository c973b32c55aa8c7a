// What an ideal camera sees of a scene.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include <opencv2/core.hpp>

#include "drivers/simulator/scene.hpp"
#include "drivers/simulator/surface.hpp"
#include "libs/camera/camera_model.hpp"

namespace fusion_slam {

struct RenderedFrame {
  cv::Mat_<cv::Vec3f> colour_bgr;  // 0 to 255
  cv::Mat_<float> depth_m;         // along the optical axis; 0: nothing there
  cv::Mat_<std::int32_t> surface;  // box * 6 + face; -1: nothing
  cv::Mat_<float> cosine;          // of the angle between ray and surface normal
};

class CameraRenderer {
 public:
  // Keeps a reference to the scene. supersample: four rays for each pixel on an edge; within a
  // surface its mip map does the same for less.
  CameraRenderer(const Scene& scene, Lighting lighting, CameraModel camera,
                 bool supersample = true);

  // Thread-safe: surfaces are painted when they first come into view, each once.
  RenderedFrame render(const SE3& T_world_camera) const;

  const CameraModel& camera() const { return camera_; }

 private:
  struct View;  // the boxes in the camera's frame, sorted into square tiles of the image
  struct PixelHit {
    float depth = 0.0F;
    std::int32_t surface = -1;
  };
  struct Painted {
    std::once_flag once;
    std::unique_ptr<Surface> surface;
    FaceAxes axes;
  };
  View look(const SE3& T_world_camera) const;
  PixelHit cast(const View& view, int tile, double u_px, double v_px) const;
  std::array<float, 3> colour(const View& view, const PixelHit& hit, double u_px, double v_px,
                              float* cosine) const;

  const Scene& scene_;
  Lighting lighting_;
  CameraModel camera_;
  bool supersample_;
  mutable std::vector<Painted> painted_;  // box * 6 + face
};

}  // namespace fusion_slam
