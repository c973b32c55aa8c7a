// What an ideal camera sees of a scene.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <vector>

#include <opencv2/core.hpp>

#include "drivers/simulator/lighting.hpp"
#include "drivers/simulator/mesh_surface.hpp"
#include "drivers/simulator/scene.hpp"
#include "drivers/simulator/surface.hpp"
#include "libs/camera/camera_model.hpp"

namespace fusion_slam {

struct RenderedFrame {
  cv::Mat_<cv::Vec3f> colour_bgr;  // 0 to 255
  cv::Mat_<float> depth_m;         // along the optical axis; 0: nothing there
  cv::Mat_<std::int32_t> surface;  // box * 6 + face, 6 * boxes + mesh; -1: nothing
  cv::Mat_<float> cosine;          // of the angle between ray and surface normal
};

class CameraRenderer {
 public:
  // Keeps a reference to the scene. supersample: four rays for each pixel on an edge; within a
  // surface its mip map does the same for less. The camera is ideal: its distortion is not drawn.
  CameraRenderer(const Scene& scene, Lighting lighting, CameraModel camera,
                 bool supersample = true);

  // Thread-safe: surfaces are painted when they first come into view, each once. Equal poses give
  // equal frames, whatever was rendered before.
  RenderedFrame render(const SE3& T_world_camera) const;
  // Paints what comes into view from these poses, so that no frame has to wait for it later.
  void prepare(const std::vector<SE3>& T_world_camera, int threads) const;

  const CameraModel& camera() const { return camera_; }

 private:
  struct Face;  // of a box, in the camera's frame
  struct View;  // what belongs to one frame
  struct PaintedFace {
    std::once_flag once;
    std::unique_ptr<const Surface> surface;
  };
  struct PaintedMesh {
    std::once_flag once;
    std::unique_ptr<const MeshSurface> surface;
  };
  // Rays through 4 x 2 pixels, and their colours.
  void packet(View* view, int left, int top, RenderedFrame* frame) const;
  std::vector<cv::Point> edges(const RenderedFrame& frame) const;
  void smooth(View* view, const std::vector<cv::Point>& edges, RenderedFrame* frame) const;
  std::array<float, 3> colour(View* view, std::int32_t geometry, std::int32_t primitive, float u,
                              float v, float depth, float cosine, float x, float y) const;
  float footprint(float depth, float cosine) const;  // metres that a pixel covers
  const Face& face(View* view, std::int32_t index) const;
  const MeshSurface& mesh(std::int32_t index) const;

  const Scene& scene_;
  Lighting lighting_;
  CameraModel camera_;
  bool supersample_;
  float pixel_rad_;
  std::vector<float> x_, y_;                // of a pixel's ray at depth 1, by column and by row
  mutable std::vector<PaintedFace> faces_;  // box * 6 + face
  mutable std::vector<PaintedMesh> meshes_;
};

}  // namespace fusion_slam
