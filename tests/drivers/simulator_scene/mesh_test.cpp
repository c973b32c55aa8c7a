#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "drivers/simulator/mesh_file.hpp"
#include "drivers/simulator/mesh_shapes.hpp"
#include "drivers/simulator/mesh_surface.hpp"
#include "drivers/simulator/world.hpp"
#include "libs/config/yaml_map.hpp"
#include "tests/drivers/simulator_scene/temporary_folder.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;
using MeshFile = TemporaryFolder;

TEST_F(MeshFile, ColladaIsInMetresWithZUp) {
  cv::Mat picture(4, 8, CV_8UC3, cv::Scalar(10, 100, 200));
  ASSERT_TRUE(cv::imwrite((folder_ / "red.png").string(), picture));
  MeshFiles files;
  const auto& meshes = files.load(write("t.dae", triangle_collada("red.png")));
  EXPECT_TRUE(files.warnings().empty());
  ASSERT_EQ(meshes.size(), 1U);
  const Mesh& mesh = meshes[0];
  ASSERT_EQ(mesh.triangles.size(), 1U);
  const auto& c = mesh.triangles[0];
  EXPECT_LT((mesh.vertices_m[c[0]] - Eigen::Vector3f(0, 0.5F, 0)).norm(), 1e-6F);
  EXPECT_LT((mesh.vertices_m[c[1]] - Eigen::Vector3f(1, 0.5F, 0)).norm(), 1e-6F);
  EXPECT_LT((mesh.vertices_m[c[2]] - Eigen::Vector3f(0, 0.5F, 2)).norm(), 1e-6F);
  EXPECT_LT((mesh.normals[0] - Eigen::Vector3f(0, -1, 0)).norm(), 1e-6F);
  ASSERT_TRUE(mesh.picture);
  EXPECT_EQ(mesh.picture->width(), 8);
  EXPECT_FLOAT_EQ(mesh.picture->at(1, 1, 1)[2], 200.0F);
  EXPECT_EQ(&files.load(folder_ / "t.dae"), &meshes) << "read once";
}

TEST_F(MeshFile, MissingAndBrokenPicturesAreSaidAndPlain) {
  write("broken.png", "no picture");
  MeshFiles files;
  EXPECT_FALSE(files.load(write("a.dae", triangle_collada("nowhere/x.png")))[0].picture);
  EXPECT_FALSE(files.load(write("b.dae", triangle_collada("broken.png")))[0].picture);
  ASSERT_EQ(files.warnings().size(), 2U);
  EXPECT_THAT(files.warnings()[0], HasSubstr("x.png: the picture is missing"));
  EXPECT_THAT(files.warnings()[1], HasSubstr("broken.png: not a picture"));
}

TEST_F(MeshFile, ErrorsNameTheFile) {
  MeshFiles files;
  const auto error_of = [&](const std::filesystem::path& path) -> std::string {
    try {
      files.load(path);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(error_of(folder_ / "no.dae"), HasSubstr("no.dae: there is no such model"));
  EXPECT_THAT(error_of(write("bad.dae", "<COLLADA>")), HasSubstr("bad.dae"));
  EXPECT_THAT(error_of(write("bad.obj", "v 0 0 0\n")), HasSubstr("bad.obj"));
}

TEST_F(MeshFile, OurWorldsHoldModelsToo) {
  write("chair_red.dae", triangle_collada("none.png"));
  const auto file = write("w.yaml",
                          "route: [[0, 0], [1, 0]]\n"
                          "things: [{kind: mesh, file: chair_red.dae, at: [1, 2], yaw_deg: 90, "
                          "scale: 2}]\n");
  const World world = load_world(file);
  ASSERT_EQ(world.meshes.size(), 1U);
  EXPECT_EQ(world.meshes[0].obstacle, ObstacleClass::kChair);
  EXPECT_EQ(world.warnings.size(), 1U);
  // (1, 0.5, 0) twice as large, turned to the left.
  EXPECT_LT((world.meshes[0].vertices_m[world.meshes[0].triangles[0][1]] - Eigen::Vector3f(0, 4, 0))
                .norm(),
            1e-5F);
  EXPECT_THROW(world_from_text("route: [[0, 0], [1, 0]]\n"
                               "things: [{kind: mesh, file: none.dae, at: [1, 2]}]\n",
                               "w.yaml"),
               ConfigError);
}

TEST(MeshShapes, NormalsPointOutAndSurfacesClose) {
  for (const Mesh& mesh : {box_mesh({1, 2, 3}), cylinder_mesh(0.5, 2.0), sphere_mesh(0.7)}) {
    double volume = 0.0;  // divergence theorem
    for (const auto& c : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices_m[c[0]].cast<double>();
      const Eigen::Vector3d b = mesh.vertices_m[c[1]].cast<double>();
      const Eigen::Vector3d d = mesh.vertices_m[c[2]].cast<double>();
      volume += a.dot(b.cross(d)) / 6.0;
      EXPECT_GT((b - a).cross(d - a).dot(mesh.normals[c[0]].cast<double>()), -1e-9);
    }
    EXPECT_GT(volume, 1.3);
    EXPECT_LT(volume, 6.0 + 1e-6);
  }
}

// The lattice of a large triangle holds the light that the corners of small ones would.
TEST(MeshSurface, LightOfALargeTriangleIsThatOfSmallOnes) {
  Lighting lighting;
  lighting.lamps_m = {{0.3, 0.1, 1.0}};
  Mesh large = plane_mesh(2.0, 2.0), small;
  constexpr int kParts = 40;
  for (int j = 0; j <= kParts; ++j)
    for (int i = 0; i <= kParts; ++i) {
      small.vertices_m.emplace_back(-1.0F + 2.0F * i / kParts, -1.0F + 2.0F * j / kParts, 0.0F);
      small.normals.emplace_back(0, 0, 1);
    }
  for (std::uint32_t j = 0; j < kParts; ++j)
    for (std::uint32_t i = 0; i < kParts; ++i) {
      const std::uint32_t a = j * (kParts + 1) + i, b = a + kParts + 1;
      small.triangles.push_back({a, a + 1, b + 1});
      small.triangles.push_back({a, b + 1, b});
    }
  const Scene scene({}, {large, small});
  const MeshSurface coarse(scene, lighting, 0), fine(scene, lighting, 1);
  for (double x = -0.95; x < 1.0; x += 0.17)
    for (double y = -0.93; y < 1.0; y += 0.19) {
      const Scene only_large({}, {large}), only_small({}, {small});
      const auto a = only_large.cast({x, y, 1.0}, {0, 0, -1}),
                 b = only_small.cast({x, y, 1.0}, {0, 0, -1});
      ASSERT_TRUE(a && b);
      EXPECT_NEAR(coarse.at(a->triangle, a->u, a->v, 0.001F)[0],
                  fine.at(b->triangle, b->u, b->v, 0.001F)[0], 3.0)
          << x << ", " << y;
    }
}

}  // namespace
}  // namespace fusion_slam
