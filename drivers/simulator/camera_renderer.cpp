#include "drivers/simulator/camera_renderer.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

namespace fusion_slam {
namespace {

constexpr int kAcross = 4, kDown = 2;  // pixels of a packet
constexpr int kTilePx = 32;            // packets near each other meet the same things
constexpr float kNearM = 0.02F;        // nearer things are not seen
// Where the surface's inverse depth bends by more than this part between neighbours, there is an
// edge within a mesh. On a plane it does not bend at all.
constexpr float kBend = 0.02F;

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

struct CameraRenderer::Trace {
  cv::Mat_<std::int32_t> primitive;
  cv::Mat_<float> u, v;
};

CameraRenderer::CameraRenderer(const Scene& scene, Lighting lighting, CameraModel camera,
                               bool supersample)
    : scene_(scene),
      lighting_(std::move(lighting)),
      camera_(camera),
      supersample_(supersample),
      faces_(scene.boxes().size() * 6),
      meshes_(scene.meshes().size()) {
  for (int u = 0; u < camera_.width_px; ++u)
    x_.push_back(static_cast<float>((u - camera_.cx_px) / camera_.fx_px));
  for (int v = 0; v < camera_.height_px; ++v)
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

std::array<float, 3> CameraRenderer::colour(View* view, std::int32_t geometry,
                                            std::int32_t primitive, float u, float v, float depth,
                                            float cosine, float x, float y) const {
  // A pixel covers an ellipse; a circle of its area blurs and flickers least.
  const float footprint =
      depth / static_cast<float>(camera_.fx_px) / std::sqrt(std::max(cosine, 0.05F));
  if (geometry > 0) return mesh(geometry - 1).at(primitive, u, v, footprint);
  const Face& f = face(view, primitive);
  return f.picture->at(f.offset_x + depth * (f.slope_x.x() * x + f.slope_x.y() * y + f.slope_x.z()),
                       f.offset_y + depth * (f.slope_y.x() * x + f.slope_y.y() * y + f.slope_y.z()),
                       footprint * f.texels_per_m);
}

void CameraRenderer::trace(const View& view, Trace* trace, RenderedFrame* frame) const {
  const int width = camera_.width_px, height = camera_.height_px;
  const auto first_mesh = static_cast<std::int32_t>(6 * scene_.boxes().size());
  const Eigen::Matrix3f& R = view.R_world_camera;
  RayPacket rays;
  const auto packet = [&](int left, int top) {
    for (int i = 0; i < 8; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const float x = x_[static_cast<std::size_t>(std::min(left + i % kAcross, width - 1))];
      const float y = y_[static_cast<std::size_t>(std::min(top + i / kAcross, height - 1))];
      rays.x[k] = R(0, 0) * x + R(0, 1) * y + R(0, 2);
      rays.y[k] = R(1, 0) * x + R(1, 1) * y + R(1, 2);
      rays.z[k] = R(2, 0) * x + R(2, 1) * y + R(2, 2);
    }
    scene_.cast(view.origin, view.within_a_box, kNearM, &rays);
    for (int i = 0; i < 8; ++i) {
      const int px = left + i % kAcross, py = top + i / kAcross;
      if (px >= width || py >= height) continue;
      const auto k = static_cast<std::size_t>(i);
      const std::int32_t geometry = rays.geometry[k];
      frame->surface(py, px) =
          geometry > 0 ? first_mesh + geometry - 1 : (geometry == 0 ? rays.primitive[k] : -1);
      frame->depth_m(py, px) = geometry < 0 ? 0.0F : rays.t[k];
      frame->cosine(py, px) = rays.cosine[k];
      trace->primitive(py, px) = rays.primitive[k];
      trace->u(py, px) = rays.u[k];
      trace->v(py, px) = rays.v[k];
    }
  };
  for (int tile_y = 0; tile_y < height; tile_y += kTilePx)
    for (int tile_x = 0; tile_x < width; tile_x += kTilePx)
      for (int y = tile_y; y < std::min(tile_y + kTilePx, height); y += kDown)
        for (int x = tile_x; x < std::min(tile_x + kTilePx, width); x += kAcross) packet(x, y);
}

void CameraRenderer::shade(View* view, const Trace& trace, RenderedFrame* frame) const {
  const auto first_mesh = static_cast<std::int32_t>(6 * scene_.boxes().size());
  const int width = camera_.width_px, height = camera_.height_px;
  const auto pixel = [&](int u, int v) {
    const std::int32_t surface = frame->surface(v, u);
    if (surface < 0) {
      frame->colour_bgr(v, u) = lighting_.background_bgr;
      return;
    }
    const auto c =
        colour(view, surface < first_mesh ? 0 : surface - first_mesh + 1, trace.primitive(v, u),
               trace.u(v, u), trace.v(v, u), frame->depth_m(v, u), frame->cosine(v, u),
               x_[static_cast<std::size_t>(u)], y_[static_cast<std::size_t>(v)]);
    frame->colour_bgr(v, u) = cv::Vec3f(c[0], c[1], c[2]);
  };
  for (int tile_y = 0; tile_y < height; tile_y += kTilePx)
    for (int tile_x = 0; tile_x < width; tile_x += kTilePx)
      for (int v = tile_y; v < std::min(tile_y + kTilePx, height); ++v)
        for (int u = tile_x; u < std::min(tile_x + kTilePx, width); ++u) pixel(u, v);
}

void CameraRenderer::smooth_edges(View* view, RenderedFrame* frame) const {
  const int width = camera_.width_px, height = camera_.height_px;
  const auto first_mesh = static_cast<std::int32_t>(6 * scene_.boxes().size());
  const auto bends = [](float before, float here, float after) {
    // 1/before + 1/after - 2/here, times before * after * here, against kBend / here.
    const float bend = here * (before + after) - 2.0F * before * after;
    return std::fabs(bend) > kBend * before * after;
  };
  std::vector<cv::Point> edges;
  for (int v = 0; v < height; ++v) {
    const std::int32_t* here = frame->surface[v];
    const std::int32_t* above = frame->surface[std::max(v - 1, 0)];
    const std::int32_t* below = frame->surface[std::min(v + 1, height - 1)];
    for (int u = 0; u < width; ++u) {
      const int left = std::max(u - 1, 0), right = std::min(u + 1, width - 1);
      bool edge = here[u] != here[left] || here[u] != here[right] || here[u] != above[u] ||
                  here[u] != below[u];
      if (!edge && here[u] >= first_mesh)
        edge = bends(frame->depth_m(v, left), frame->depth_m(v, u), frame->depth_m(v, right)) ||
               bends(frame->depth_m(std::max(v - 1, 0), u), frame->depth_m(v, u),
                     frame->depth_m(std::min(v + 1, height - 1), u));
      if (edge) edges.emplace_back(u, v);
    }
  }
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
        if (rays.geometry[k] < 0) {
          sum += lighting_.background_bgr;
          continue;
        }
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
  Trace what{cv::Mat_<std::int32_t>(size), cv::Mat_<float>(size), cv::Mat_<float>(size)};
  trace(view, &what, &frame);
  shade(&view, what, &frame);
  if (supersample_) smooth_edges(&view, &frame);
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
