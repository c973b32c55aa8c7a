#include "drivers/simulator/gazebo_world.hpp"

#include <set>

#include <gmock/gmock.h>

#include "libs/config/yaml_map.hpp"
#include "tests/drivers/simulator_scene/temporary_folder.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;
using GazeboWorld = TemporaryFolder;

std::pair<Eigen::Vector3f, Eigen::Vector3f> bounds(const std::vector<Mesh>& meshes) {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(1e9F), high = -low;
  for (const Mesh& mesh : meshes)
    for (const Eigen::Vector3f& v : mesh.vertices_m) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
  return {low, high};
}

TEST_F(GazeboWorld, PlacesModelsOnModels) {
  write("models/post/t.dae", triangle_collada("none.png"));
  write("models/post/model.sdf", R"(<sdf version="1.6"><model name="post"><pose>9 9 9 0 0 0</pose>
    <link name="l"><pose>0 0 1 0 0 0</pose><visual name="v"><pose>1 0 0 0 0 0</pose>
    <geometry><mesh><uri>model://post/t.dae</uri><scale>1 1 0.5</scale></mesh></geometry></visual></link>
    </model></sdf>)");
  const auto file = write("worlds/w.world", R"(<sdf version="1.6"><world name="small">
    <scene><background>1 0.5 0 1</background></scene>
    <light name="lamp" type="point"><pose>1 2 3 0 0 0</pose><diffuse>1 1 1 1</diffuse></light>
    <model name="DeskOne"><pose>10 0 0 0 0 1.5707963267948966</pose>
      <include><uri>model://post</uri><pose>0 0 2 0 0 0</pose></include></model>
    <include><uri>model://gone</uri></include>
    <model name="ChairBall"><link name="l"><visual name="v"><geometry><sphere><radius>0.5</radius></sphere></geometry>
      <material><diffuse>0.1 0.2 0.3 1</diffuse></material></visual></link></model>
    </world></sdf>)");
  const World world = load_world(file);
  EXPECT_EQ(world.name, "small");
  ASSERT_EQ(world.meshes.size(), 2U);
  const Mesh& post = world.meshes[0];
  EXPECT_EQ(post.name, "DeskOne");
  EXPECT_EQ(post.obstacle, ObstacleClass::kTable);
  // Corner (1, 0.5, 0) of the model: +1 in x, +1 and +2 in z, turned to the left, +10 in x. The
  // include's pose replaces the model's own.
  EXPECT_LT((post.vertices_m[post.triangles[0][1]] - Eigen::Vector3f(9.5F, 2, 3)).norm(), 1e-5F);
  EXPECT_LT((post.vertices_m[post.triangles[0][2]] - Eigen::Vector3f(9.5F, 1, 4)).norm(), 1e-5F);
  EXPECT_FLOAT_EQ(world.meshes[1].bgr[0], 0.3F);
  ASSERT_EQ(world.lighting.lamps_m.size(), 1U);
  EXPECT_TRUE(world.lighting.lamps_m[0].isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_FLOAT_EQ(world.lighting.background_bgr[2], 255.0F);
  ASSERT_EQ(world.warnings.size(), 2U);
  EXPECT_THAT(world.warnings[0], HasSubstr("w.world:6: model 'model://gone' is not there"));
  EXPECT_THAT(world.warnings[1], HasSubstr("none.png"));
}

TEST_F(GazeboWorld, WhatIsNoWorldIsRefused) {
  EXPECT_THROW(load_world(write("a.world", "<sdf><world")), ConfigError);
  EXPECT_THROW(load_world(write("b.world", "<sdf/>")), ConfigError);
  EXPECT_THROW(load_world(folder_ / "none.world"), ConfigError);
}

TEST(GazeboWorlds, SmallHouseIsWhole) {
  FS_RECORDING(file, "worlds/small-house/worlds/small_house.world");
  const World world = load_world(file);
  std::set<std::string> models;
  std::size_t triangles = 0;
  for (const Mesh& mesh : world.meshes)
    if (mesh.name.rfind("Ball_01", 0) != 0) {  // two spheres, which no file describes
      models.insert(mesh.name);
      triangles += mesh.triangles.size();
    }
  EXPECT_EQ(models.size(), 85U);
  EXPECT_EQ(triangles, 145844U);
  const auto [low, high] = bounds(world.meshes);
  EXPECT_LT((low - Eigen::Vector3f(-9.5F, -5.7F, 0)).norm(), 0.01F);
  EXPECT_LT((high - Eigen::Vector3f(9.5F, 5.7F, 3)).norm(), 0.01F);
  EXPECT_EQ(world.lighting.lamps_m.size(), 7U);
}

}  // namespace
}  // namespace fusion_slam
