#include "drivers/simulator/camera_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

namespace fusion_slam {
namespace {

constexpr int kAcross = 4, kDown = 2;  // pixels of a packet
constexpr int kTilePx = 32;            // packets near each other meet the same things
constexpr float kNearM = 0.02F;        // nearer things are not seen
// Within a mesh there is an edge where the inverse depth bends by more than this part between
// neighbours; on a plane it does not bend at all.
constexpr float kBend = 0.01F;
constexpr float kContrast = 6.0F;  // grey values; an edge between likes needs no smoothing

bool contrast(const cv::Vec3f& a, const cv::Vec3f& b) {
  return std::max({std::fabs(a[0] - b[0]), std::fabs(a[1] - b[1]), std::fabs(a[2] - b[2])}) >
         kContrast;
}

// 1 / before + 1 / after - 2 / here against kBend / here, all times before * after * here.
bool bends(float before, float here, float after) {
  return std::fabs(here * (before + after) - 2.0F * before * after) > kBend * before * after;
}

}  // namespace

// The face's picture has coordinates x = (offset + depth * slope . (ray x, ray y, 1)).
struct CameraRenderer::Face {
  const MipMap* picture = nullptr;
  float offset_x = 0.0F, offset_y = 0.0F;
  Eigen::Vector3f slope_x, slope_y;
  float texels_per_m = 0.0F;
};

struct CameraRenderer::View {
  SE3 T_world_camera;
  Eigen::Vector3f origin;
  Eigen::Matrix3f R_world_camera;
  bool within_a_box = false;
  std::vector<Face> faces;
};

CameraRenderer::CameraRenderer(const Scene& scene, Lighting lighting, CameraModel camera,
                               bool supersample)
    : scene_(scene),
      lighting_(std::move(lighting)),
      camera_(camera),
      supersample_(supersample),
      pixel_rad_(static_cast<float>(1.0 / camera.fx_px)),
      faces_(scene.boxes().size() * 6),
      meshes_(scene.meshes().size()) {
  // A packet may look past the border.
  for (int u = 0; u < camera_.width_px + kAcross; ++u)
    x_.push_back(static_cast<float>((u - camera_.cx_px) / camera_.fx_px));
  for (int v = 0; v < camera_.height_px + kDown; ++v)
    y_.push_back(static_cast<float>((v - camera_.cy_px) / camera_.fy_px));
}

const CameraRenderer::Face& CameraRenderer::face(View* view, std::int32_t index) const {
  const auto i = static_cast<std::size_t>(index);
  Face& face = view->faces[i];
  if (face.picture != nullptr) return face;
  PaintedFace& painted = faces_[i];
  std::call_once(painted.once, [&] {
    painted.surface = std::make_unique<Surface>(scene_, lighting_, index / 6, index % 6);
  });
  const Box& box = scene_.boxes()[i / 6];
  const FaceAxes axes = face_axes(box, index % 6);
  const SE3 T_box_camera = box.T_world_box.inverse() * view->T_world_camera;
  const Eigen::Vector3d from_corner = T_box_camera.translation() - axes.corner;
  const double per_m_s = static_cast<double>(painted.surface->texels_per_m_s());
  const double per_m_t = static_cast<double>(painted.surface->texels_per_m_t());
  face.offset_x = static_cast<float>(per_m_s * axes.s.dot(from_corner));
  face.offset_y = static_cast<float>(per_m_t * axes.t.dot(from_corner));
  face.slope_x = (per_m_s * T_box_camera.linear().transpose() * axes.s).cast<float>();
  face.slope_y = (per_m_t * T_box_camera.linear().transpose() * axes.t).cast<float>();
  face.texels_per_m = painted.surface->texels_per_m_s();
  face.picture = &painted.surface->picture();
  return face;
}

const MeshSurface& CameraRenderer::mesh(std::int32_t index) const {
  PaintedMesh& painted = meshes_[static_cast<std::size_t>(index)];
  std::call_once(painted.once, [&] {
    painted.surface = std::make_unique<MeshSurface>(scene_, lighting_, index);
  });
  return *painted.surface;
}

// A pixel covers an ellipse; a circle of its area blurs and flickers least.
float CameraRenderer::footprint(float depth, float cosine) const {
  return depth * pixel_rad_ / std::sqrt(std::max(cosine, 0.05F));
}

std::array<float, 3> CameraRenderer::colour(View* view, std::int32_t geometry,
                                            std::int32_t primitive, float u, float v, float depth,
                                            float cosine, float x, float y) const {
  if (geometry < 0) {
    const cv::Vec3f& c = lighting_.background_bgr;
    return {c[0], c[1], c[2]};
  }
  if (geometry > 0) return mesh(geometry - 1).at(primitive, u, v, footprint(depth, cosine));
  const Face& f = face(view, primitive);
  return f.picture->at(f.offset_x + depth * (f.slope_x.x() * x + f.slope_x.y() * y + f.slope_x.z()),
                       f.offset_y + depth * (f.slope_y.x() * x + f.slope_y.y() * y + f.slope_y.z()),
                       footprint(depth, cosine) * f.texels_per_m);
}

void CameraRenderer::packet(View* view, int left, int top, RenderedFrame* frame) const {
  const auto first_mesh = static_cast<std::int32_t>(6 * scene_.boxes().size());
  const Eigen::Matrix3f& R = view->R_world_camera;
  RayPacket rays;
  alignas(32) std::array<float, 8> x, y;
  const float* columns_x = &x_[static_cast<std::size_t>(left)];
  for (std::size_t row = 0; row < kDown; ++row) {
    std::copy_n(columns_x, kAcross, x.begin() + row * kAcross);
    std::fill_n(y.begin() + row * kAcross, kAcross, y_[static_cast<std::size_t>(top) + row]);
  }
  for (std::size_t k = 0; k < 8; ++k) {
    rays.x[k] = R(0, 0) * x[k] + R(0, 1) * y[k] + R(0, 2);
    rays.y[k] = R(1, 0) * x[k] + R(1, 1) * y[k] + R(1, 2);
    rays.z[k] = R(2, 0) * x[k] + R(2, 1) * y[k] + R(2, 2);
  }
  scene_.cast(view->origin, view->within_a_box, kNearM, &rays);
  bool same_thing = rays.geometry[0] >= 0;
  bool same_face = rays.geometry[0] == 0;
  for (std::size_t k = 1; k < 8; ++k) {
    same_thing = same_thing && rays.geometry[k] == rays.geometry[0];
    same_face = same_face && rays.primitive[k] == rays.primitive[0];
  }
  same_face = same_face && same_thing;
  const float covered =
      footprint(0.5F * (rays.t[0] + rays.t[7]), 0.5F * (rays.cosine[0] + rays.cosine[7]));
  std::array<std::array<float, 4>, 8> bgr;
  if (same_face) {
    const Face& f = face(view, rays.primitive[0]);
    alignas(32) std::array<float, 8> s, t;
    for (std::size_t k = 0; k < 8; ++k) {
      s[k] = f.offset_x + rays.t[k] * (f.slope_x.x() * x[k] + f.slope_x.y() * y[k] + f.slope_x.z());
      t[k] = f.offset_y + rays.t[k] * (f.slope_y.x() * x[k] + f.slope_y.y() * y[k] + f.slope_y.z());
    }
    f.picture->at(s, t, covered * f.texels_per_m, &bgr);
  } else if (same_thing && rays.geometry[0] > 0) {
    mesh(rays.geometry[0] - 1).at(rays.primitive, rays.u, rays.v, covered, &bgr);
  } else {
    for (std::size_t k = 0; k < 8; ++k) {
      const auto c = colour(view, rays.geometry[k], rays.primitive[k], rays.u[k], rays.v[k],
                            rays.t[k], rays.cosine[k], x[k], y[k]);
      bgr[k] = {c[0], c[1], c[2], 0.0F};
    }
  }
  const int columns = std::min(kAcross, camera_.width_px - left);
  for (int row = 0; row < kDown && top + row < camera_.height_px; ++row) {
    auto* out_bgr = frame->colour_bgr[top + row] + left;
    auto* out_depth = frame->depth_m[top + row] + left;
    auto* out_surface = frame->surface[top + row] + left;
    auto* out_cosine = frame->cosine[top + row] + left;
    for (int column = 0; column < columns; ++column) {
      const int k_int = row * kAcross + column;
      const auto k = static_cast<std::size_t>(k_int);
      const std::int32_t geometry = rays.geometry[k];
      out_bgr[column] = cv::Vec3f(bgr[k][0], bgr[k][1], bgr[k][2]);
      out_depth[column] = geometry < 0 ? 0.0F : rays.t[k];
      out_surface[column] =
          geometry > 0 ? first_mesh + geometry - 1 : (geometry == 0 ? rays.primitive[k] : -1);
      out_cosine[column] = rays.cosine[k];
    }
  }
}

std::vector<cv::Point> CameraRenderer::edges(const RenderedFrame& frame) const {
  const int width = camera_.width_px, height = camera_.height_px;
  const auto first_mesh = static_cast<std::int32_t>(6 * scene_.boxes().size());
  std::vector<cv::Point> edges;
  for (int v = 0; v < height; ++v) {
    const int up = std::max(v - 1, 0), down = std::min(v + 1, height - 1);
    const std::int32_t *here = frame.surface[v], *above = frame.surface[up],
                       *below = frame.surface[down];
    const float *z = frame.depth_m[v], *z_above = frame.depth_m[up], *z_below = frame.depth_m[down];
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - 1, 0), right = std::min(u + 1, width - 1);
      const bool within = here[u] >= first_mesh;
      const bool across = here[u] != here[left] || here[u] != here[right] ||
                          (within && bends(z[left], z[u], z[right]));
      const bool along = here[u] != above[u] || here[u] != below[u] ||
                         (within && bends(z_above[u], z[u], z_below[u]));
      if (!across && !along) continue;
      const cv::Vec3f* c = frame.colour_bgr[v];
      if ((across && (contrast(c[u], c[left]) || contrast(c[u], c[right]))) ||
          (along &&
           (contrast(c[u], frame.colour_bgr[up][u]) || contrast(c[u], frame.colour_bgr[down][u]))))
        edges.emplace_back(u, v);
    }
  }
  return edges;
}

void CameraRenderer::smooth(View* view, const std::vector<cv::Point>& edges,
                            RenderedFrame* frame) const {
  // Two pixels to a packet, four rays each.
  const Eigen::Matrix3f& R = view->R_world_camera;
  const float step_x = 0.25F / static_cast<float>(camera_.fx_px);
  const float step_y = 0.25F / static_cast<float>(camera_.fy_px);
  RayPacket rays;
  std::array<float, 8> x{}, y{};
  for (std::size_t first = 0; first < edges.size(); first += 2) {
    for (std::size_t k = 0; k < 8; ++k) {
      const cv::Point& at = edges[std::min(first + k / 4, edges.size() - 1)];
      x[k] = x_[static_cast<std::size_t>(at.x)] + (k % 2 == 0 ? -step_x : step_x);
      y[k] = y_[static_cast<std::size_t>(at.y)] + (k % 4 < 2 ? -step_y : step_y);
      rays.x[k] = R(0, 0) * x[k] + R(0, 1) * y[k] + R(0, 2);
      rays.y[k] = R(1, 0) * x[k] + R(1, 1) * y[k] + R(1, 2);
      rays.z[k] = R(2, 0) * x[k] + R(2, 1) * y[k] + R(2, 2);
    }
    scene_.cast(view->origin, view->within_a_box, kNearM, &rays);
    for (std::size_t i = first; i < std::min(first + 2, edges.size()); ++i) {
      cv::Vec3f sum(0, 0, 0);
      for (std::size_t k = 4 * (i - first); k < 4 * (i - first) + 4; ++k) {
        const auto c = colour(view, rays.geometry[k], rays.primitive[k], rays.u[k], rays.v[k],
                              rays.t[k], rays.cosine[k], x[k], y[k]);
        sum += cv::Vec3f(c[0], c[1], c[2]);
      }
      frame->colour_bgr(edges[i]) = 0.25F * sum;
    }
  }
}

RenderedFrame CameraRenderer::render(const SE3& T_world_camera) const {
  View view;
  view.T_world_camera = T_world_camera;
  view.origin = T_world_camera.translation().cast<float>();
  view.R_world_camera = T_world_camera.linear().cast<float>();
  view.within_a_box = scene_.within_a_box(T_world_camera.translation());
  view.faces.resize(faces_.size());
  const cv::Size size(camera_.width_px, camera_.height_px);
  RenderedFrame frame{cv::Mat_<cv::Vec3f>(size), cv::Mat_<float>(size),
                      cv::Mat_<std::int32_t>(size), cv::Mat_<float>(size)};
  for (int tile_y = 0; tile_y < size.height; tile_y += kTilePx)
    for (int tile_x = 0; tile_x < size.width; tile_x += kTilePx)
      for (int y = tile_y; y < std::min(tile_y + kTilePx, size.height); y += kDown)
        for (int x = tile_x; x < std::min(tile_x + kTilePx, size.width); x += kAcross)
          packet(&view, x, y, &frame);
  if (supersample_) smooth(&view, edges(frame), &frame);
  return frame;
}

void CameraRenderer::prepare(const std::vector<SE3>& T_world_camera, int threads) const {
  std::vector<std::thread> workers;
  const auto n = static_cast<std::size_t>(std::max(1, threads));
  for (std::size_t i = 0; i < n; ++i)
    workers.emplace_back([&, i] {
      for (std::size_t k = i; k < T_world_camera.size(); k += n) render(T_world_camera[k]);
    });
  for (std::thread& worker : workers) worker.join();
}

}  // namespace fusion_slam
