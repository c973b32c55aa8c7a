#include "drivers/simulator/scene.hpp"

#include <cmath>
#include <stdexcept>
#include <utility>

#include <embree3/rtcore.h>

#include "drivers/simulator/texture.hpp"

namespace fusion_slam {
namespace {

constexpr unsigned kBoxGeometry = 0;  // meshes follow

// Corners of a face, counter-clockwise as seen from outside.
std::array<Eigen::Vector3d, 4> face_corners(const Box& box, int face) {
  const Eigen::Vector3d normal = face_normal(face);
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  a[(face / 2 + 1) % 3] = 1.0;
  const Eigen::Vector3d b = normal.cross(a);
  const auto at = [&](double i, double j) {
    return Eigen::Vector3d(box.T_world_box * box.half_m.cwiseProduct(normal + i * a + j * b));
  };
  return {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)};
}

// A ray that leaves a box has started within it: such hits do not count.
void refuse_leaving(const RTCFilterFunctionNArguments* args) {
  const unsigned n = args->N;
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1 || RTCHitN_geomID(args->hit, n, i) != kBoxGeometry) continue;
    const float along = RTCHitN_Ng_x(args->hit, n, i) * RTCRayN_dir_x(args->ray, n, i) +
                        RTCHitN_Ng_y(args->hit, n, i) * RTCRayN_dir_y(args->ray, n, i) +
                        RTCHitN_Ng_z(args->hit, n, i) * RTCRayN_dir_z(args->ray, n, i);
    if (along > 0.0F) args->valid[i] = 0;
  }
}

void commit(RTCDevice device, RTCScene scene, RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree refuses the scene: is there enough memory?");
}

float* new_vertices(RTCGeometry geometry, std::size_t n) {
  return static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                     RTC_FORMAT_FLOAT3, 3 * sizeof(float), n));
}

// Two triangles a face.
void add_boxes(RTCDevice device, RTCScene scene, const std::vector<Box>& boxes) {
  if (boxes.empty()) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* vertex = new_vertices(geometry, boxes.size() * 24);
  auto* index = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), boxes.size() * 12));
  unsigned first = 0;
  for (const Box& box : boxes)
    for (int face = 0; face < 6; ++face) {
      for (const Eigen::Vector3d& corner : face_corners(box, face))
        for (int k = 0; k < 3; ++k) *vertex++ = static_cast<float>(corner[k]);
      for (const unsigned corner : {0U, 1U, 3U, 2U, 3U, 1U}) *index++ = first + corner;
      first += 4;
    }
  commit(device, scene, geometry, kBoxGeometry);
}

void add_mesh(RTCDevice device, RTCScene scene, const Mesh& mesh, unsigned id) {
  if (mesh.triangles.empty()) return;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* vertex = new_vertices(geometry, mesh.vertices_m.size());
  for (const Eigen::Vector3f& v : mesh.vertices_m)
    for (int k = 0; k < 3; ++k) *vertex++ = v[k];
  auto* index = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) {
      if (corner >= mesh.vertices_m.size())
        throw std::runtime_error("model " + mesh.name + ": a triangle names a missing vertex");
      *index++ = corner;
    }
  commit(device, scene, geometry, id);
}

RTCRay ray_of(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double t_max) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tfar = static_cast<float>(t_max);
  ray.mask = ~0U;
  return ray;
}

}  // namespace

// Two trees: `any` leaves out the boxes that a ray starts in and lets no ray slip between two
// triangles; `outside` does neither and takes a third of the time: for the camera, whose rays are
// many. One thread builds them and instructions beyond AVX2 are left alone, so that the same scene
// gives the same answers on all machines that have AVX2.
struct Scene::Tree {
  RTCDevice device = rtcNewDevice("threads=1,max_isa=avx2");
  RTCScene any = nullptr;
  RTCScene outside = nullptr;
  Tree() {
    if (device == nullptr) throw std::runtime_error("Embree does not start on this machine");
    any = rtcNewScene(device);
    outside = rtcNewScene(device);
    rtcSetSceneFlags(any, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST |
                                                     RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
    rtcSetSceneBuildQuality(outside, RTC_BUILD_QUALITY_HIGH);
  }
  Tree(const Tree&) = delete;
  Tree& operator=(const Tree&) = delete;
  ~Tree() {
    rtcReleaseScene(any);
    rtcReleaseScene(outside);
    rtcReleaseDevice(device);
  }
};

Eigen::Vector3d face_normal(int face) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  normal[face / 2] = face % 2 == 1 ? 1.0 : -1.0;
  return normal;
}

Scene::Scene(std::vector<Box> boxes, std::vector<Mesh> meshes)
    : boxes_(std::move(boxes)), meshes_(std::move(meshes)), tree_(std::make_unique<Tree>()) {
  for (const Box& box : boxes_) T_box_world_.push_back(box.T_world_box.inverse());
  for (RTCScene scene : {tree_->any, tree_->outside}) {
    add_boxes(tree_->device, scene, boxes_);
    for (std::size_t i = 0; i < meshes_.size(); ++i)
      add_mesh(tree_->device, scene, meshes_[i], kBoxGeometry + 1 + static_cast<unsigned>(i));
    rtcCommitScene(scene);
  }
  if (rtcGetDeviceError(tree_->device) != RTC_ERROR_NONE)
    throw std::runtime_error("Embree refuses the scene: is there enough memory?");
}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

std::optional<SceneHit> Scene::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                    double t_max) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.filter = refuse_leaving;
  RTCRayHit query{};
  // A little further than asked: floats may disagree about the end.
  query.ray = ray_of(origin, direction, t_max * (1.0 + 1e-6));
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(tree_->any, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  SceneHit hit;
  hit.t = static_cast<double>(query.ray.tfar);
  double exact = NAN;
  if (query.hit.geomID == kBoxGeometry) {
    hit.box = static_cast<int>(query.hit.primID / 12);
    hit.face = static_cast<int>(query.hit.primID / 2 % 6);
    const auto i = static_cast<std::size_t>(hit.box);
    const int axis = hit.face / 2;
    const double o = (T_box_world_[i] * origin)[axis];
    const double d = (T_box_world_[i].linear() * direction)[axis];
    exact = ((hit.face % 2 == 1 ? boxes_[i].half_m[axis] : -boxes_[i].half_m[axis]) - o) / d;
  } else {
    hit.mesh = static_cast<int>(query.hit.geomID - kBoxGeometry - 1);
    hit.triangle = static_cast<int>(query.hit.primID);
    hit.u = query.hit.u;
    hit.v = query.hit.v;
    const Mesh& mesh = meshes_[static_cast<std::size_t>(hit.mesh)];
    const auto corner =
        mesh.vertices_m[mesh.triangles[static_cast<std::size_t>(hit.triangle)][0]].cast<double>();
    const Eigen::Vector3d n = normal(hit);
    exact = n.dot(corner - origin) / n.dot(direction);
  }
  if (std::fabs(exact - hit.t) < 1e-4 * (1.0 + hit.t)) hit.t = exact;
  if (!(hit.t > 0.0 && hit.t < t_max)) return std::nullopt;
  return hit;
}

bool Scene::blocked(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                    double t_max) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.filter = refuse_leaving;
  RTCRay ray = ray_of(origin, direction, t_max);
  rtcOccluded1(tree_->any, &context, &ray);
  return ray.tfar < 0.0F;
}

void Scene::cast(const Eigen::Vector3f& origin, bool within_a_box, float t_min,
                 RayPacket* rays) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  if (within_a_box) context.filter = refuse_leaving;
  RTCRayHit8 query;
  alignas(32) constexpr int kAll[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
  for (std::size_t i = 0; i < 8; ++i) {
    query.ray.org_x[i] = origin.x();
    query.ray.org_y[i] = origin.y();
    query.ray.org_z[i] = origin.z();
    query.ray.dir_x[i] = rays->x[i];
    query.ray.dir_y[i] = rays->y[i];
    query.ray.dir_z[i] = rays->z[i];
    query.ray.tnear[i] = t_min;
    query.ray.tfar[i] = std::numeric_limits<float>::infinity();
    query.ray.time[i] = 0.0F;
    query.ray.mask[i] = ~0U;
    query.ray.flags[i] = 0;
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    query.hit.primID[i] = 0;
    query.hit.Ng_x[i] = query.hit.Ng_y[i] = query.hit.Ng_z[i] = 0.0F;
    query.hit.u[i] = query.hit.v[i] = 0.0F;
  }
  rtcIntersect8(kAll, within_a_box ? tree_->any : tree_->outside, &context, &query);
  for (std::size_t i = 0; i < 8; ++i) {
    rays->t[i] = query.ray.tfar[i];
    rays->u[i] = query.hit.u[i];
    rays->v[i] = query.hit.v[i];
    rays->geometry[i] = static_cast<std::int32_t>(query.hit.geomID[i]);
    const unsigned primitive = query.hit.primID[i];
    rays->primitive[i] =
        static_cast<std::int32_t>(query.hit.geomID[i] == kBoxGeometry ? primitive / 2 : primitive);
    const float nx = query.hit.Ng_x[i], ny = query.hit.Ng_y[i], nz = query.hit.Ng_z[i];
    const float x = rays->x[i], y = rays->y[i], z = rays->z[i];
    const float lengths = (nx * nx + ny * ny + nz * nz) * (x * x + y * y + z * z);
    rays->cosine[i] = std::fabs(nx * x + ny * y + nz * z) / std::sqrt(lengths + 1e-30F);
  }
}

bool Scene::within_a_box(const Eigen::Vector3d& p) const {
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    if (((T_box_world_[i] * p).cwiseAbs().array() <= boxes_[i].half_m.array() + 1e-5).all())
      return true;
  return false;
}

Eigen::Vector3d Scene::normal(const SceneHit& hit) const {
  if (hit.mesh < 0)
    return boxes_[static_cast<std::size_t>(hit.box)].T_world_box.linear() * face_normal(hit.face);
  const Mesh& mesh = meshes_[static_cast<std::size_t>(hit.mesh)];
  const auto& corners = mesh.triangles[static_cast<std::size_t>(hit.triangle)];
  const Eigen::Vector3d a = mesh.vertices_m[corners[0]].cast<double>();
  const Eigen::Vector3d b = mesh.vertices_m[corners[1]].cast<double>();
  const Eigen::Vector3d c = mesh.vertices_m[corners[2]].cast<double>();
  return (b - a).cross(c - a).normalized();
}

double Scene::reflectance(const SceneHit& hit) const {
  std::array<float, 3> bgr{};
  if (hit.mesh < 0) {
    bgr = boxes_[static_cast<std::size_t>(hit.box)].material.bgr;
  } else {
    const Mesh& mesh = meshes_[static_cast<std::size_t>(hit.mesh)];
    bgr = mesh.bgr;
    if (mesh.picture && !mesh.uv.empty()) {
      const auto& corners = mesh.triangles[static_cast<std::size_t>(hit.triangle)];
      const Eigen::Vector2f uv = (1.0F - hit.u - hit.v) * mesh.uv[corners[0]] +
                                 hit.u * mesh.uv[corners[1]] + hit.v * mesh.uv[corners[2]];
      const auto width = static_cast<float>(mesh.picture->width());
      const auto height = static_cast<float>(mesh.picture->height());
      const auto seen = mesh.picture->at(uv.x() * width, (1.0F - uv.y()) * height, 16.0F);
      for (std::size_t k = 0; k < 3; ++k) bgr[k] *= seen[k] / 255.0F;
    }
  }
  return static_cast<double>(bgr[0] + bgr[1] + bgr[2]) / 3.0;
}

ObstacleClass Scene::obstacle(const SceneHit& hit) const {
  return hit.mesh < 0 ? boxes_[static_cast<std::size_t>(hit.box)].obstacle
                      : meshes_[static_cast<std::size_t>(hit.mesh)].obstacle;
}

}  // namespace fusion_slam
