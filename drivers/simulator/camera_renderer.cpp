#include "drivers/simulator/camera_renderer.hpp"

#include <algorithm>
#include <cmath>

namespace fusion_slam {
namespace {

constexpr int kTilePx = 16;
constexpr double kNearM = 0.02;  // nearer things are not seen

// Corners of a box's face lattice: bit a of the index says which end of axis a.
Eigen::Vector3d corner(const Box& box, int index) {
  return {(index & 1) != 0 ? box.half_m.x() : -box.half_m.x(),
          (index & 2) != 0 ? box.half_m.y() : -box.half_m.y(),
          (index & 4) != 0 ? box.half_m.z() : -box.half_m.z()};
}

struct Bounds {
  double u_low = 1e9, u_high = -1e9, v_low = 1e9, v_high = -1e9, z_low = 1e9;
  void add(const CameraModel& camera, const Eigen::Vector3d& p) {
    const Eigen::Vector2d uv = camera.project(p);
    u_low = std::min(u_low, uv.x());
    u_high = std::max(u_high, uv.x());
    v_low = std::min(v_low, uv.y());
    v_high = std::max(v_high, uv.y());
    z_low = std::min(z_low, p.z());
  }
};

// Image rectangle of the part of a box before the near plane.
Bounds bounds(const CameraModel& camera, const Box& box, const SE3& T_camera_box) {
  Bounds b;
  std::array<Eigen::Vector3d, 8> p;
  for (int i = 0; i < 8; ++i) p[static_cast<std::size_t>(i)] = T_camera_box * corner(box, i);
  for (std::size_t i = 0; i < 8; ++i) {
    if (p[i].z() >= kNearM) b.add(camera, p[i]);
    for (std::size_t bit = 1; bit < 8; bit *= 2) {
      const std::size_t j = i ^ bit;
      if (j < i || (p[i].z() < kNearM) == (p[j].z() < kNearM)) continue;
      const double f = (kNearM - p[i].z()) / (p[j].z() - p[i].z());
      b.add(camera, p[i] + f * (p[j] - p[i]));
    }
  }
  return b;
}

}  // namespace

struct CameraRenderer::View {
  struct SeenBox {
    int index;
    double z_low;
    Bounds rectangle;
    Eigen::Vector3d origin;  // of the camera in the box's frame
    Eigen::Matrix3d R_box_camera;
    Eigen::Vector3d half;
  };
  std::vector<SeenBox> boxes;           // nearest first
  std::vector<int> where;               // position in `boxes` by box index; -1: out of view
  std::vector<std::vector<int>> tiles;  // positions in `boxes`, nearest first
  int tiles_across = 0;
};

CameraRenderer::CameraRenderer(const Scene& scene, Lighting lighting, CameraModel camera,
                               bool supersample)
    : scene_(scene),
      lighting_(std::move(lighting)),
      camera_(camera),
      supersample_(supersample),
      painted_(scene.boxes().size() * 6) {}

CameraRenderer::View CameraRenderer::look(const SE3& T_world_camera) const {
  View view;
  const SE3 T_camera_world = T_world_camera.inverse();
  const auto& boxes = scene_.boxes();
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const SE3 T_camera_box = T_camera_world * boxes[i].T_world_box;
    const Bounds r = bounds(camera_, boxes[i], T_camera_box);
    if (r.u_high < -0.5 || r.v_high < -0.5 || r.u_low > camera_.width_px - 0.5 ||
        r.v_low > camera_.height_px - 0.5)
      continue;
    const SE3 T_box_camera = T_camera_box.inverse();
    view.boxes.push_back({static_cast<int>(i), r.z_low, r, T_box_camera.translation(),
                          T_box_camera.linear(), boxes[i].half_m});
  }
  std::stable_sort(view.boxes.begin(), view.boxes.end(),
                   [](const auto& a, const auto& b) { return a.z_low < b.z_low; });
  view.where.assign(boxes.size(), -1);
  view.tiles_across = (camera_.width_px + kTilePx - 1) / kTilePx;
  const int tiles_down = (camera_.height_px + kTilePx - 1) / kTilePx;
  view.tiles.resize(static_cast<std::size_t>(view.tiles_across) *
                    static_cast<std::size_t>(tiles_down));
  const auto tile_of = [](double px, int n) {
    return static_cast<int>(std::clamp(std::floor((px) / kTilePx), 0.0, n - 1.0));
  };
  for (std::size_t i = 0; i < view.boxes.size(); ++i) {
    const Bounds& r = view.boxes[i].rectangle;
    view.where[static_cast<std::size_t>(view.boxes[i].index)] = static_cast<int>(i);
    // One pixel wider: supersampling looks half a pixel past the centres.
    for (int y = tile_of(r.v_low - 1, tiles_down); y <= tile_of(r.v_high + 1, tiles_down); ++y)
      for (int x = tile_of(r.u_low - 1, view.tiles_across);
           x <= tile_of(r.u_high + 1, view.tiles_across); ++x)
        view.tiles[static_cast<std::size_t>(y) * static_cast<std::size_t>(view.tiles_across) +
                   static_cast<std::size_t>(x)]
            .push_back(static_cast<int>(i));
  }
  return view;
}

CameraRenderer::PixelHit CameraRenderer::cast(const View& view, int tile, double u_px,
                                              double v_px) const {
  const Eigen::Vector3d ray = camera_.unproject(u_px, v_px, 1.0);
  PixelHit best;
  double z = 1e9;
  BoxHit hit;
  for (const int i : view.tiles[static_cast<std::size_t>(tile)]) {
    const View::SeenBox& box = view.boxes[static_cast<std::size_t>(i)];
    if (box.z_low > z) break;
    if (!enter_box(box.half, box.origin, box.R_box_camera * ray, &hit) || hit.t >= z) continue;
    z = hit.t;
    best = {static_cast<float>(z), box.index * 6 + hit.face};
  }
  return best;
}

std::array<float, 3> CameraRenderer::colour(const View& view, const PixelHit& hit, double u_px,
                                            double v_px, float* cosine) const {
  if (hit.surface < 0) return {};
  Painted& painted = painted_[static_cast<std::size_t>(hit.surface)];
  const int index = hit.surface / 6, face = hit.surface % 6;
  std::call_once(painted.once, [&] {
    painted.axes = face_axes(scene_.boxes()[static_cast<std::size_t>(index)], face);
    painted.surface = std::make_unique<Surface>(scene_, lighting_, index, face);
  });
  const View::SeenBox& box =
      view.boxes[static_cast<std::size_t>(view.where[static_cast<std::size_t>(index)])];
  const Eigen::Vector3d ray = box.R_box_camera * camera_.unproject(u_px, v_px, 1.0);
  const Eigen::Vector3d p = box.origin + hit.depth * ray - painted.axes.corner;
  *cosine = static_cast<float>(std::fabs(ray[face / 2]) / ray.norm());
  // A pixel covers an ellipse; a circle of its area blurs and flickers least.
  const float footprint =
      hit.depth / static_cast<float>(camera_.fx_px) / std::sqrt(std::max(*cosine, 0.05F));
  return painted.surface->at(static_cast<float>(p.dot(painted.axes.s)),
                             static_cast<float>(p.dot(painted.axes.t)), footprint);
}

RenderedFrame CameraRenderer::render(const SE3& T_world_camera) const {
  const View view = look(T_world_camera);
  const int width = camera_.width_px, height = camera_.height_px;
  RenderedFrame frame{cv::Mat_<cv::Vec3f>(height, width), cv::Mat_<float>(height, width),
                      cv::Mat_<std::int32_t>(height, width), cv::Mat_<float>(height, width)};
  const auto tile_of = [&](int u, int v) { return v / kTilePx * view.tiles_across + u / kTilePx; };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const PixelHit hit = cast(view, tile_of(u, v), u, v);
      frame.depth_m(v, u) = hit.depth;
      frame.surface(v, u) = hit.surface;
    }
  }
  const auto add = [](const std::array<float, 3>& c, float weight, cv::Vec3f* sum) {
    for (int k = 0; k < 3; ++k) (*sum)[k] += weight * c[static_cast<std::size_t>(k)];
  };
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const PixelHit hit{frame.depth_m(v, u), frame.surface(v, u)};
      const bool edge =
          supersample_ && (hit.surface != frame.surface(v, std::max(u - 1, 0)) ||
                           hit.surface != frame.surface(v, std::min(u + 1, width - 1)) ||
                           hit.surface != frame.surface(std::max(v - 1, 0), u) ||
                           hit.surface != frame.surface(std::min(v + 1, height - 1), u));
      cv::Vec3f sum(0, 0, 0);
      float unused = 0.0F;
      if (edge)
        for (int k = 0; k < 4; ++k) {
          const int row = k / 2;
          const double du = u + (k % 2 - 0.5) / 2, dv = v + (row - 0.5) / 2;
          add(colour(view, cast(view, tile_of(u, v), du, dv), du, dv, &unused), 0.25F, &sum);
        }
      frame.cosine(v, u) = 0.0F;
      const auto centre = colour(view, hit, u, v, &frame.cosine(v, u));
      if (!edge) add(centre, 1.0F, &sum);
      frame.colour_bgr(v, u) = sum;
    }
  }
  return frame;
}

}  // namespace fusion_slam
