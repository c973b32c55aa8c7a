#include "libs/datasets/rgbd_dataset.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

class RgbdDatasetTest : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(root_); }
  void TearDown() override { fs::remove_all(root_); }
  void colour(const std::string& file) {
    cv::imwrite((root_ / file).string(), cv::Mat(480, 640, CV_8UC3, cv::Scalar(10, 20, 200)));
  }
  void depth(const std::string& file, int value) {
    cv::imwrite((root_ / file).string(), cv::Mat(480, 640, CV_16UC1, cv::Scalar(value)));
  }
  void text(const std::string& file, const std::string& content) {
    std::ofstream(root_ / file) << content;
  }
  fs::path root_ = fs::temp_directory_path() / ("fs_rgbd_test_" + std::to_string(getpid()));
};

const char* const kPose = "0 -1 0 5\n1 0 0 6\n0 0 1 7\n0 0 0 1\n";

TEST_F(RgbdDatasetTest, SevenScenesGolden) {
  colour("frame-000003.color.jpg");
  depth("frame-000003.depth.png", 2000);
  text("frame-000003.pose.txt", kPose);
  colour("frame-000005.color.png");
  depth("frame-000005.depth.png", 65535);
  text("frame-000005.pose.txt", "1 0 0\n");
  colour("frame-000007.color.png");  // without depth
  const RgbdDataset d = open_seven_scenes(root_);
  ASSERT_EQ(d.entries.size(), 2u);
  EXPECT_EQ(d.entries[0].utime_us, kSevenScenesEpochUs + 100'000);
  EXPECT_EQ(d.entries[1].utime_us, kSevenScenesEpochUs + 166'666);
  EXPECT_EQ(d.skipped.reasons().at("frame without depth image").first_place, 7);
  EXPECT_EQ(d.skipped.reasons().at("pose is not a 4x4 matrix").first_place, 5);
  ASSERT_EQ(d.reference.size(), 1u);
  // The colour camera is 2.5 cm to the right of the depth camera, whose x axis points along world y
  // here.
  EXPECT_TRUE(
      d.reference[0].T_world_reference.translation().isApprox(Eigen::Vector3d(5, 6.025, 7), 1e-9));
  std::string why;
  const auto frame = load_frame(d, 0, &why);
  ASSERT_TRUE(frame) << why;
  EXPECT_EQ(frame->depth_mm.at<std::uint16_t>(240, 320), 2000);
  EXPECT_EQ(frame->depth_mm.at<std::uint16_t>(2, 2), 0);  // outside of the depth camera's view
  EXPECT_TRUE(load_colour_jpeg(d, 0));
  EXPECT_FALSE(load_colour_jpeg(d, 1));
  const auto empty = load_frame(d, 1, &why);
  ASSERT_TRUE(empty) << why;
  EXPECT_EQ(empty->depth_mm.at<std::uint16_t>(240, 320), 0);  // 65535 is no reading
}

TEST_F(RgbdDatasetTest, DamagedImagesAreRefusedWithTheirName) {
  text("frame-000000.color.png", "no image");
  depth("frame-000000.depth.png", 1);
  colour("frame-000001.color.png");
  text("frame-000001.depth.png", "");
  colour("frame-000002.color.png");
  colour("frame-000002.depth.png");
  const RgbdDataset d = open_seven_scenes(root_);
  ASSERT_EQ(d.entries.size(), 3u);
  std::string why;
  EXPECT_FALSE(load_frame(d, 0, &why));
  EXPECT_EQ(why, "frame-000000.color.png is not an image or damaged");
  EXPECT_FALSE(load_frame(d, 1, &why));
  EXPECT_FALSE(load_frame(d, 2, &why));
  EXPECT_EQ(why, "frame-000002.depth.png is not of the expected pixel type");
}

TEST_F(RgbdDatasetTest, TumPairsNearestInTimeEachOnce) {
  fs::create_directories(root_ / "rgb");
  fs::create_directories(root_ / "depth");
  for (const char* t : {"1.00", "1.01", "1.05", "2.00"}) colour(std::string("rgb/") + t + ".png");
  for (const char* t : {"1.012", "1.055", "3.00"}) depth(std::string("depth/") + t + ".png", 5000);
  text("rgb.txt",
       "# file: 'rgbd_dataset_freiburg2_x.bag'\n1.00 rgb/1.00.png\n1.01 rgb/1.01.png\n1.05 "
       "rgb/1.05.png\nbad\n2.00 rgb/2.00.png\n");
  text("depth.txt", "1.012 depth/1.012.png\n1.055 depth/1.055.png\n3.00 depth/3.00.png\n");
  text("groundtruth.txt", "# t\n1.0 1 2 3 0 0 0 1\n");
  const RgbdDataset d = open_tum_rgbd(root_);
  EXPECT_EQ(d.camera_name, "TUM freiburg2");
  EXPECT_EQ(d.camera.fx_px, 520.9);
  ASSERT_EQ(d.entries.size(), 2u);
  EXPECT_EQ(d.entries[0].utime_us, 1'010'000);
  EXPECT_EQ(d.entries[0].depth_utime_us, 1'012'000);
  EXPECT_EQ(d.entries[1].utime_us, 1'050'000);
  EXPECT_EQ(
      d.skipped.reasons().at("rgb.txt: colour image without a depth image within 20 ms").count, 2);
  EXPECT_EQ(d.skipped.reasons().at("rgb.txt: not \"seconds file\"").first_place, 5);
  EXPECT_EQ(d.reference.size(), 1u);
  std::string why;
  const auto frame = load_frame(d, 0, &why);
  ASSERT_TRUE(frame) << why;
  EXPECT_EQ(frame->depth_mm.at<std::uint16_t>(0, 0), 1000);  // 5000 units are a metre
}

TEST_F(RgbdDatasetTest, ForeignDirectoriesAreNamed) {
  EXPECT_THROW(open_seven_scenes(root_), DatasetError);
  EXPECT_THROW(open_tum_rgbd(root_), DatasetError);
  EXPECT_THROW(open_seven_scenes(root_ / "none"), DatasetError);
  EXPECT_THROW(open_tum_rgbd(root_ / "none"), DatasetError);
}

TEST_F(RgbdDatasetTest, TumNameThatNoFileCanHaveIsSkipped) {
  colour("a.png");
  depth("b.png", 5000);
  text("rgb.txt", "1.0 " + std::string(300, 'x') + "\n2.0 a.png\n");
  text("depth.txt", "1.0 b.png\n2.0 b.png\n");
  const RgbdDataset d = open_tum_rgbd(root_);
  EXPECT_EQ(d.entries.size(), 1u);
  EXPECT_EQ(d.skipped.reasons().at("image that is listed but not there").count, 1);
}

TEST_F(RgbdDatasetTest, SevenScenesPoseThatOverflowsIsNone) {
  colour("frame-000000.color.png");
  depth("frame-000000.depth.png", 1);
  text("frame-000000.pose.txt", "1e200 -1e200 0 0\n1e200 1e200 0 0\n0 0 1e200 0\n0 0 0 1\n");
  const RgbdDataset d = open_seven_scenes(root_);
  EXPECT_TRUE(d.reference.empty());
  EXPECT_EQ(d.skipped.reasons().at("pose is not a rigid motion").count, 1);
}

}  // namespace
}  // namespace fusion_slam
