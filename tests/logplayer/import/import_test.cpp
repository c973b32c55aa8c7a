#include "logplayer/import/import.hpp"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "tests/logplayer/import/decoded_log.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Pair;
using testing::UnorderedElementsAre;

class ImportTest : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root_);
    setenv("FUSION_SLAM_CONFIG", (fs::path(FS_SOURCE_DIR) / "config").c_str(), 1);
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path text(const std::string& file, const std::string& content) {
    std::ofstream(root_ / file) << content;
    return root_ / file;
  }
  ImportOptions options(const std::string& format, const fs::path& source) const {
    ImportOptions o;
    o.format = format;
    o.source = source;
    o.output = root_ / "out.lcm";
    return o;
  }
  std::string error(const ImportOptions& o) const {
    try {
      run_import(o, nullptr);
    } catch (const std::exception& e) {
      return e.what();
    }
    return "no error";
  }
  bool nothing_written() const {
    return !fs::exists(root_ / "out.lcm") && !fs::exists(root_ / "out.lcm.partial");
  }
  fs::path root_ = fs::temp_directory_path() / ("fs_import_test_" + std::to_string(getpid()));
};

const char* const kCarmen =
    "FLASER 3 1.5 2.5 81.91 1 2 0.5 1 2 0.5 10.0 host 0.25\n"
    "FLASER 3 1.5 2.5 3.5 2 2 0.5 2 2 0.5 10.5 host 0.25\n"
    "broken line\n"
    "FLASER 3 1.5 2.5 3.5 3 2 0.5 3 2 0.5 11.25 host 0.25\n";

TEST_F(ImportTest, CarmenGolden) {
  const ImportSummary s = run_import(options("carmen", text("a.log", kCarmen)), nullptr);
  const DecodedLog log(root_ / "out.lcm");
  EXPECT_THAT(log.counts(),
              UnorderedElementsAre(Pair("LIDAR", 3), Pair("ODOMETRY", 3), Pair("ROBOT_MODEL", 2)));
  EXPECT_EQ(s.messages.at("LIDAR"), 3);
  EXPECT_EQ(s.skipped.total(), 1);
  EXPECT_NEAR(s.duration_s, 1.25, 1e-9);
  EXPECT_EQ(log.events[0].channel, "ROBOT_MODEL");
  EXPECT_EQ(log.events[1].channel, "ODOMETRY");  // before the scan of the same time
  EXPECT_EQ(log.events[2].channel, "LIDAR");
  const auto scans = log.messages<bot_core::planar_lidar_t>("LIDAR");
  EXPECT_EQ(scans[0].utime, 10'000'000);
  EXPECT_EQ(scans[0].ranges, (std::vector<float>{1.5F, 2.5F, 81.91F}));
  EXPECT_NEAR(scans[0].rad0, -M_PI / 2, 1e-6);
  EXPECT_NEAR(scans[0].radstep, M_PI / 2, 1e-6);
  const auto poses = log.messages<bot_core::pose_t>("ODOMETRY");
  EXPECT_EQ(poses[1].pos[0], 2.0);
  EXPECT_NEAR(poses[1].orientation[0], std::cos(0.25), 1e-12);
  EXPECT_NEAR(poses[1].orientation[3], std::sin(0.25), 1e-12);
  const auto models = log.messages<robot_model_t>("ROBOT_MODEL");
  EXPECT_EQ(models[0].seq, 1);
  EXPECT_EQ(models[1].seq, 2);
  EXPECT_TRUE(models[0].has_lidar && models[0].has_odometry && models[0].planar &&
              !models[0].has_camera);
  EXPECT_EQ(models[0].reference_frame, "base");
  EXPECT_EQ(models[0].T_base_lidar.trans[0], 0.0);
}

TEST_F(ImportTest, NoOdometryLeavesItOut) {
  ImportOptions o = options("carmen", text("a.log", kCarmen));
  o.no_odometry = true;
  run_import(o, nullptr);
  const DecodedLog log(o.output);
  EXPECT_EQ(log.counts().count("ODOMETRY"), 0u);
  EXPECT_FALSE(log.messages<robot_model_t>("ROBOT_MODEL")[0].has_odometry);
}

TEST_F(ImportTest, CorrectedPosesNeverBecomeOdometry) {
  ImportOptions o = options("carmen", text("a.log", std::string(kCarmen) + "NEFF 30\n"));
  const ImportSummary s = run_import(o, nullptr);
  EXPECT_THAT(DecodedLog(o.output).counts(),
              UnorderedElementsAre(Pair("LIDAR", 3), Pair("ROBOT_MODEL", 2)));
  EXPECT_THAT(s.notes.at(0), HasSubstr("not imported as ODOMETRY"));
  o.corrected_as_ground_truth = true;
  run_import(o, nullptr);
  const DecodedLog log(o.output);
  EXPECT_EQ(log.counts().count("ODOMETRY"), 0u);
  EXPECT_EQ(log.messages<bot_core::pose_t>("GROUND_TRUTH").at(2).pos[0], 3.0);
}

TEST_F(ImportTest, ConstantOffsetBetweenTheLogsPosesIsTheMounting) {
  const auto source =
      text("a.log",
           "FLASER 2 1 1 1.2 2 0 1 2 0 1 h 1\nFLASER 2 1 1 1 2.2 1.5707963 1 2 1.5707963 2 h 2\n");
  run_import(options("carmen", source), nullptr);
  const auto models = DecodedLog(root_ / "out.lcm").messages<robot_model_t>("ROBOT_MODEL");
  EXPECT_NEAR(models.at(0).T_base_lidar.trans[0], 0.2, 1e-6);
}

TEST_F(ImportTest, FrameRangeAndGroundTruthFile) {
  ImportOptions o = options("carmen", text("a.log", kCarmen));
  o.ground_truth =
      text("gt.tum", "9.0 0 0 0 0 0 0 1\n10.45 1 2 3 0 0 0 1\n11.0 4 5 6 0 0 0 1\nx\n");
  o.start = 1;
  o.max_frames = 1;
  const ImportSummary s = run_import(o, nullptr);
  const DecodedLog log(o.output);
  EXPECT_THAT(log.counts(), UnorderedElementsAre(Pair("LIDAR", 1), Pair("ODOMETRY", 1),
                                                 Pair("GROUND_TRUTH", 1), Pair("ROBOT_MODEL", 1)));
  EXPECT_EQ(log.messages<bot_core::planar_lidar_t>("LIDAR")[0].utime, 10'500'000);
  EXPECT_EQ(log.messages<bot_core::pose_t>("GROUND_TRUTH")[0].pos[2], 3.0);
  EXPECT_THAT(s.notes.back(),
              HasSubstr("1 lines skipped (time stamp is not a number, first at line 4)"));
}

TEST_F(ImportTest, SevenScenesGolden) {
  cv::Mat colour(480, 640, CV_8UC3, cv::Scalar(10, 20, 200));
  cv::imwrite((root_ / "frame-000000.color.jpg").string(), colour);
  cv::imwrite((root_ / "frame-000030.color.png").string(), colour);
  for (const char* f : {"frame-000000.depth.png", "frame-000030.depth.png"})
    cv::imwrite((root_ / f).string(), cv::Mat(480, 640, CV_16UC1, cv::Scalar(2000)));
  text("frame-000000.pose.txt", "1 0 0 0.5\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  run_import(options("7scenes", root_), nullptr);
  const DecodedLog log(root_ / "out.lcm");
  EXPECT_THAT(log.counts(), UnorderedElementsAre(Pair("CAMERA", 2), Pair("CAMERA_MODEL", 2),
                                                 Pair("ROBOT_MODEL", 2), Pair("GROUND_TRUTH", 1)));
  const auto images = log.messages<bot_core::images_t>("CAMERA");
  std::ifstream file(root_ / "frame-000000.color.jpg", std::ios::binary);
  const Bytes own((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  EXPECT_EQ(images[0].images[0].data, own);  // not encoded a second time
  EXPECT_EQ(images[1].utime - images[0].utime, 1'000'000);
  std::string why;
  const auto frame = from_message(images[1], &why);
  ASSERT_TRUE(frame) << why;
  EXPECT_EQ(frame->depth_mm.at<std::uint16_t>(240, 320), 2000);
  const auto camera = log.messages<camera_model_t>("CAMERA_MODEL").at(0);
  EXPECT_EQ(camera.fx, 528.0);
  EXPECT_EQ(camera.width, 640);
  const auto robot = log.messages<robot_model_t>("ROBOT_MODEL").at(0);
  EXPECT_EQ(robot.reference_frame, "camera");
  EXPECT_TRUE(robot.has_camera && !robot.has_lidar && !robot.planar);
  EXPECT_NEAR(log.messages<bot_core::pose_t>("GROUND_TRUTH")[0].pos[0], 0.525, 1e-12);
}

TEST_F(ImportTest, UnreadableFramesAreSkippedAndNoneAtAllIsAnError) {
  text("frame-000000.color.png", "x");
  text("frame-000000.depth.png", "x");
  EXPECT_THAT(error(options("7scenes", root_)), HasSubstr("not one frame could be read"));
  EXPECT_TRUE(nothing_written());
  cv::imwrite((root_ / "frame-000001.color.png").string(),
              cv::Mat(480, 640, CV_8UC3, cv::Scalar(1, 2, 3)));
  cv::imwrite((root_ / "frame-000001.depth.png").string(),
              cv::Mat(480, 640, CV_16UC1, cv::Scalar(2000)));
  const ImportSummary s = run_import(options("7scenes", root_), nullptr);
  EXPECT_EQ(s.messages.at("CAMERA"), 1);
  EXPECT_EQ(s.skipped.reasons().count("frame-000000.color.png is not an image or damaged"), 1u);
}

TEST_F(ImportTest, HokuyoGolden) {
  std::string content;
  for (int k = 1; k <= 2; ++k) {
    content += std::to_string(100000 * k) + " 0 " + std::to_string(1000 * k) + " " +
               std::to_string(1000 * k);
    for (int i = 4; i < 24; ++i) content += " 0";
    for (int i = 0; i < 683; ++i) content += " 1500";
    content += "\n";
  }
  run_import(options("hokuyo", text("a.dat", content)), nullptr);
  const DecodedLog log(root_ / "out.lcm");
  EXPECT_THAT(log.counts(),
              UnorderedElementsAre(Pair("LIDAR", 2), Pair("ODOMETRY", 2), Pair("ROBOT_MODEL", 1)));
  const auto poses = log.messages<bot_core::pose_t>("ODOMETRY");
  EXPECT_NEAR(poses[1].pos[0] - poses[0].pos[0], M_PI * 0.077, 1e-9);  // half a turn of the wheels
}

TEST_F(ImportTest, ForeignFilesAreNamedAndNothingIsWritten) {
  const auto foreign = text("foreign.txt", "hello\nworld\n");
  const auto empty = text("empty.log", "");
  for (const char* format : {"carmen", "hokuyo", "rplidar-lcm"}) {
    EXPECT_THAT(error(options(format, foreign)), HasSubstr("foreign.txt")) << format;
    EXPECT_THAT(error(options(format, empty)), HasSubstr("empty")) << format;
    EXPECT_THAT(error(options(format, root_)), HasSubstr(root_.string())) << format;
  }
  for (const char* format : {"7scenes", "tum"}) {
    EXPECT_THAT(error(options(format, root_)), HasSubstr(root_.string())) << format;
    EXPECT_THAT(error(options(format, foreign)), HasSubstr("is not a directory")) << format;
  }
  EXPECT_TRUE(nothing_written());
}

TEST_F(ImportTest, OtherErrorsNameWhatToDo) {
  const auto source = text("a.log", kCarmen);
  ImportOptions o = options("carmen", source);
  o.robot_file = fs::path(FS_SOURCE_DIR) / "config/robots/hand-held-kinect.yaml";
  EXPECT_THAT(error(o), HasSubstr("add the key 'lidar'"));
  o = options("carmen", source);
  o.start = 3;
  EXPECT_THAT(error(o), HasSubstr("no frame is left after --start 3"));
  o = options("carmen", source);
  o.output = source;
  EXPECT_THAT(error(o), HasSubstr("is the recording itself"));
  o.output = root_ / "none" / "out.lcm";
  EXPECT_THAT(error(o), HasSubstr("out.lcm"));
  EXPECT_TRUE(nothing_written());
}

}  // namespace
}  // namespace fusion_slam
