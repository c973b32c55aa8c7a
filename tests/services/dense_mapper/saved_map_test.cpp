// What the dense mapper writes down of itself: bytes, and a mapper that goes on from them.
#include "services/dense_mapper/saved_map.hpp"

#include <gtest/gtest.h>

#include "services/dense_mapper/dense_mapper.hpp"
#include "tests/services/dense_mapper/published.hpp"
#include "tests/services/dense_mapper/synthetic_room.hpp"

namespace fusion_slam {
namespace {

constexpr int kKeyframes = 14;

// A robot that turns to and fro in the room; its graph bends once, after keyframe 9.
class SavedMapTest : public testing::TestWithParam<bool> {
 protected:
  SavedMapTest() {
    robot_.planar = GetParam();
    robot_.T_base_camera.linear() = optical_to_body();
    robot_.T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.35);
    config_.keyframes_per_submap = 2;
    config_.submaps_that_count = 1;  // so that submaps are superseded soon
    config_.submaps_over_map = 0.5;  // and many
  }
  static SE3 pose(int id) {
    return from_xyz_rpy(0.02 * (id % 5), 0.03 * (id % 3), 0.0, 0.0, 0.0, 0.06 * (id % 4));
  }
  RgbdFrame image(int id) const {
    return render_room(pose(id) * robot_.T_base_camera, camera_, id * 1'000'000);
  }
  DenseMapper mapper() const {
    DenseMapper mapper(camera_, robot_, config_);
    mapper.keep_changes();
    return mapper;
  }
  static SE3 in_graph(int id, int now) {
    return now > 9 && id < 6 ? from_xyz_rpy(0.04, 0.03, 0, 0, 0, 0.01) * pose(id) : pose(id);
  }
  static void tell_graph(int now, DenseMapper* mapper) {
    for (int id = 1; id <= now; ++id) mapper->set_pose(id, in_graph(id, now), now * 1'000'000);
  }
  void step(int id, DenseMapper* mapper, Published* published) const {
    EXPECT_TRUE(mapper->add_keyframe(id, image(id)));
    tell_graph(id, mapper);
    mapper->integrate_ready();
    mapper->wish_level(false);
    published->add(mapper->update(false));
  }
  static void finish(DenseMapper* mapper, Published* published) {
    mapper->wish_level(true);
    published->add(mapper->update(true));
  }

  RobotModel robot_;
  CameraModel camera_ = small_camera();
  DenseMapperConfig config_;
};

TEST_P(SavedMapTest, KilledAfterAKeyframeTheMapIsTheSameByteForByte) {
  DenseMapper undisturbed = mapper();
  Published whole;
  SavedMap saved;
  std::vector<SavedBytes> records;
  std::vector<std::set<std::int64_t>> needed(1);
  std::size_t superseded = 0;
  for (int id = 1; id <= kKeyframes; ++id) {
    step(id, &undisturbed, &whole);
    records.push_back(undisturbed.take_changes());
    ASSERT_TRUE(read_saved(records.back().data(), records.back().size(), &saved));
    needed.push_back(undisturbed.needed_images());
    superseded += saved.submaps.size() < static_cast<std::size_t>((id + 1) / 2) ? 1 : 0;
    for (const auto& [submap_id, submap] : saved.submaps) superseded += submap.visits > 0 ? 1 : 0;
  }
  EXPECT_GT(superseded, 0U) << "the test is to drop something";
  EXPECT_TRUE(undisturbed.take_changes().empty());
  finish(&undisturbed, &whole);
  ASSERT_FALSE(whole.octomap.empty());
  ASSERT_FALSE(whole.cloud.empty());

  for (const int killed : {1, 4, 9, 10, 13, 14}) {
    DenseMapper mapper = this->mapper();
    ASSERT_LE(needed[killed].size(), 2U) << "only an open submap's";
    SavedMap before;
    for (int i = 0; i < killed; ++i) read_saved(records[i].data(), records[i].size(), &before);
    ASSERT_TRUE(mapper.restore(std::move(before)));
    Published again;
    for (const std::int64_t id : needed[killed]) {
      EXPECT_TRUE(mapper.ready(id));
      ASSERT_TRUE(mapper.add_keyframe(id, image(static_cast<int>(id))));
    }
    mapper.integrate_ready();
    tell_graph(killed, &mapper);
    again.add(mapper.update(false));
    EXPECT_EQ(mapper.integrated(), static_cast<std::size_t>(killed));
    for (int id = killed + 1; id <= kKeyframes; ++id) step(id, &mapper, &again);
    finish(&mapper, &again);
    EXPECT_TRUE(again.octomap == whole.octomap) << killed;
    EXPECT_TRUE(again.cloud == whole.cloud) << killed;
    EXPECT_TRUE(again.grid == whole.grid) << killed;
  }
}

// A mapper that is behind: newer keyframes are mapped, and their submap is given up, before the
// images that are to be mapped again come.
TEST_P(SavedMapTest, ImagesToBeMappedAgainMayComeLate) {
  config_.keyframes_per_submap = 3;
  DenseMapper first = mapper();
  Published published;
  SavedMap saved;
  for (int id = 1; id <= 5; ++id) step(id, &first, &published);
  const SavedBytes bytes = first.take_changes();
  ASSERT_TRUE(read_saved(bytes.data(), bytes.size(), &saved));
  const std::set<std::int64_t> needed = first.needed_images();
  ASSERT_EQ(needed.size(), 2U);

  DenseMapper second = mapper();
  ASSERT_TRUE(second.restore(std::move(saved)));
  for (int id = 6; id <= 24; ++id) step(id, &second, &published);
  for (const std::int64_t id : needed) {
    EXPECT_EQ(second.needed_images().count(id), 1U) << "or the journal would leave it out";
    ASSERT_TRUE(second.add_keyframe(id, image(static_cast<int>(id))));
    second.integrate_ready();
    second.update(false);
    EXPECT_EQ(second.needed_images().count(id), 0U);
  }
  EXPECT_EQ(second.integrated(), 24U);
}

TEST_P(SavedMapTest, AllAtOnceSaysWhatTheChangesSaid) {
  DenseMapper mapper = this->mapper();
  Published published;
  SavedMap by_changes;
  for (int id = 1; id <= 7; ++id) {
    step(id, &mapper, &published);
    const SavedBytes bytes = mapper.take_changes();
    ASSERT_TRUE(read_saved(bytes.data(), bytes.size(), &by_changes));
  }
  SavedMap at_once;
  std::vector<SavedBytes> records;
  mapper.write_all([&](const SavedBytes& bytes) { records.push_back(bytes); });
  for (const SavedBytes& bytes : records)
    ASSERT_TRUE(read_saved(bytes.data(), bytes.size(), &at_once));
  EXPECT_TRUE(at_once.base_cubes == by_changes.base_cubes);
  EXPECT_TRUE(at_once.base_clouds == by_changes.base_clouds);
  EXPECT_EQ(at_once.integrated.ranges(), by_changes.integrated.ranges());
  ASSERT_EQ(at_once.open_keyframes.size(), by_changes.open_keyframes.size());
  ASSERT_EQ(at_once.submaps.size(), by_changes.submaps.size());
  for (const auto& [id, submap] : at_once.submaps) {
    const DenseSubmap& other = by_changes.submaps.at(id);
    EXPECT_TRUE(submap.packed == other.packed);
    EXPECT_TRUE(submap.packed_cloud == other.packed_cloud);
    EXPECT_EQ(submap.newer, other.newer);
    EXPECT_TRUE(submap.T_map_submap.matrix() == other.T_map_submap.matrix());
  }
  // Of another resolution: refused, and nothing has happened.
  RobotModel coarse = robot_;
  coarse.map_resolution_m *= 2;
  DenseMapper other(camera_, coarse, config_);
  EXPECT_FALSE(other.restore(std::move(at_once)));
  EXPECT_EQ(other.integrated(), 0U);
}

TEST_P(SavedMapTest, DamagedRecordsAreRefused) {
  DenseMapper mapper = this->mapper();
  Published published;
  for (int id = 1; id <= 3; ++id) step(id, &mapper, &published);
  const SavedBytes bytes = mapper.take_changes();
  SavedMap map;
  EXPECT_FALSE(read_saved(bytes.data(), 0, &map));
  std::size_t refused = 0;
  std::size_t n = 0;
  for (std::size_t size = 1; size < bytes.size(); size += 1 + bytes.size() / 200, ++n) {
    SavedMap cut;
    refused += read_saved(bytes.data(), size, &cut) ? 0 : 1;
  }
  EXPECT_GE(refused + 3, n) << "a cut between two pieces can't be told";
  for (std::size_t at = 0; at < bytes.size(); at += 1 + bytes.size() / 200) {
    SavedBytes damaged = bytes;
    damaged[at] ^= 0xff;
    SavedMap any;
    read_saved(damaged.data(), damaged.size(), &any);  // whatever it says, it comes back
  }
}

INSTANTIATE_TEST_SUITE_P(OnWheelsAndByHand, SavedMapTest, testing::Bool());

TEST(IdRanges, AreASet) {
  IdRanges ranges;
  for (const std::int64_t id : {5, 3, 4, 9, 7, 8, 5}) ranges.insert(id);
  EXPECT_EQ(ranges.size(), 6U);
  EXPECT_EQ(ranges.ranges(), (std::map<std::int64_t, std::int64_t>{{3, 5}, {7, 9}}));
  EXPECT_FALSE(ranges.contains(6));
  EXPECT_TRUE(ranges.contains(4));
  ranges.insert(6);
  EXPECT_EQ(ranges.ranges(), (std::map<std::int64_t, std::int64_t>{{3, 9}}));
  ranges.insert_range(1001, 1010);
  EXPECT_EQ(ranges.size(), 17U);
  EXPECT_TRUE(ranges.contains(1010));
}

}  // namespace
}  // namespace fusion_slam
