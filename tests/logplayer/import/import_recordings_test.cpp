// Real recordings through the importer; skipped where these are not.
#include <gtest/gtest.h>
#include <unistd.h>

#include "bot_core/images_t.hpp"
#include "bot_core/planar_lidar_t.hpp"
#include "bot_core/pose_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "logplayer/import/import.hpp"
#include "tests/logplayer/import/decoded_log.hpp"
#include "tests/support/recordings.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

class ImportRecordings : public testing::Test {
 protected:
  void SetUp() override {
    setenv("FUSION_SLAM_CONFIG", (fs::path(FS_SOURCE_DIR) / "config").c_str(), 1);
  }
  void TearDown() override { fs::remove(output_); }
  ImportSummary import(const std::string& format, const fs::path& source, ImportOptions o = {}) {
    o.format = format;
    o.source = source;
    o.output = output_;
    return run_import(o, nullptr);
  }
  fs::path output_ =
      fs::temp_directory_path() / ("fs_import_recordings_" + std::to_string(getpid()) + ".lcm");
};

TEST_F(ImportRecordings, Maebot) {
  FS_RECORDING(path, "lidar/lcm-maebot-empty/empty_environment.log");
  const ImportSummary s = import("rplidar-lcm", path);
  EXPECT_EQ(s.messages.at("LIDAR"), 403);
  EXPECT_EQ(s.messages.at("GROUND_TRUTH"), 401);
  EXPECT_GT(s.messages.at("ODOMETRY"), 1490);
  EXPECT_NEAR(s.duration_s, 58.9, 0.3);
  const DecodedLog log(output_);
  EXPECT_NEAR(log.messages<robot_model_t>("ROBOT_MODEL").at(0).lidar_rate_hz, 6.83, 0.05);
}

TEST_F(ImportRecordings, Fr079HasScansOnly) {
  FS_RECORDING(path, "lidar/fr079/freiburg-079-corrected.log.gz");
  const ImportSummary s = import("carmen", path);
  EXPECT_EQ(s.messages.at("LIDAR"), 4791);
  EXPECT_EQ(s.messages.count("ODOMETRY") + s.messages.count("GROUND_TRUTH"), 0u);
}

TEST_F(ImportRecordings, CsailWithItsReference) {
  FS_RECORDING(path, "lidar/mit-csail-clf/mit-csail.clf");
  ImportOptions o;
  o.ground_truth = path.parent_path() / "mit-csail_reference_gmapping_406.tum";
  const ImportSummary s = import("carmen", path, o);
  EXPECT_EQ(s.messages.at("LIDAR"), 1988);
  EXPECT_EQ(s.messages.at("ODOMETRY"), 1988);
  EXPECT_EQ(s.messages.at("GROUND_TRUTH"), 406);
  EXPECT_EQ(s.skipped.total(), 0);
}

TEST_F(ImportRecordings, RedkitchenFramesStaySmall) {
  FS_RECORDING(path, "rgbd/7scenes-redkitchen");
  ImportOptions o;
  o.max_frames = 20;
  const ImportSummary s = import("7scenes", path, o);
  EXPECT_EQ(s.messages.at("CAMERA"), 20);
  EXPECT_GE(s.messages.at("GROUND_TRUTH"), 20);
  EXPECT_LT(s.largest_message_bytes, 400'000);
  for (const auto& m : DecodedLog(output_).messages<bot_core::images_t>("CAMERA"))
    EXPECT_EQ(m.n_images, 2);
}

TEST_F(ImportRecordings, TumDesk) {
  FS_RECORDING(path, "rgbd/tum-fr1-desk-9");
  const ImportSummary s = import("tum", path);
  EXPECT_EQ(s.messages.at("CAMERA"), 9);
  EXPECT_EQ(s.messages.at("GROUND_TRUTH"), 46);
  EXPECT_LT(s.largest_message_bytes, 400'000);
}

TEST_F(ImportRecordings, MinesHokuyo) {
  FS_RECORDING(path, "lidar/mines-hokuyo/exp1.dat");
  EXPECT_EQ(import("hokuyo", path).messages.at("LIDAR"), 756);
}

}  // namespace
}  // namespace fusion_slam
