#include "libs/log_export/tum_export.hpp"

#include <opencv2/imgcodecs.hpp>

#include "libs/camera_messages/images.hpp"
#include "libs/datasets/rgbd_dataset.hpp"
#include "tests/libs/log_export/export_fixture.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kT0 = 1'700'000'000'000'123;

class TumExport : public ExportFixture {
 protected:
  static RgbdFrame frame(int i) {
    RgbdFrame frame{kT0 + i * 50'000, cv::Mat(24, 32, CV_8UC3), cv::Mat(24, 32, CV_16UC1)};
    for (int v = 0; v < 24; ++v)
      for (int u = 0; u < 32; ++u) {
        frame.colour_bgr.at<cv::Vec3b>(v, u) = cv::Vec3b(4 * u, 5 * v, 20 * i);
        frame.depth_mm.at<std::uint16_t>(v, u) =
            static_cast<std::uint16_t>(u == 0 ? 0 : 600 + 10 * u + v + i);
      }
    frame.depth_mm.at<std::uint16_t>(5, 5) = 14'000;  // more than TUM's units can say
    return frame;
  }
  // Base moves along y; the camera sits 0.1 m ahead and 0.4 m up in base.
  static SE3 T_world_base(int i) { return from_xyz_rpy(1.0, 0.5 * i, 0.0, 0.0, 0.0, 0.3 * i); }
  RobotModel write_log(bool with_camera = true, bool with_robot = true) const {
    RobotModel robot;
    robot.has_camera = true;
    robot.T_base_camera = from_xyz_rpy(0.1, 0.0, 0.4, 0.0, 0.0, 0.0);
    robot.T_base_camera.linear() *= optical_to_body();
    CameraModel camera;
    camera.width_px = 32;
    camera.height_px = 24;
    camera.fx_px = 571.25;
    camera.cy_px = 11.5;
    camera.distortion = {0.1, -0.2, 0.001, 0.002, 0.03};
    LogWriter log(log_file());
    if (with_robot) put(&log, kT0, "ROBOT_MODEL", to_message(robot, kT0));
    put(&log, kT0, "CAMERA_MODEL", to_message(camera, kT0));
    for (int i = 0; i < 3; ++i) {
      const std::int64_t t = kT0 + i * 50'000;
      put(&log, t, "GROUND_TRUTH", to_pose_message(T_world_base(i), t));
      auto message = to_message(frame(i));
      message.images[1].utime = t + 4'000;
      if (with_camera) put(&log, t, "CAMERA", message);
    }
    log.write(kT0, "CAMERA", std::vector<std::uint8_t>{1, 2, 3});  // damage
    log.close();
    return robot;
  }
};

TEST_F(TumExport, ImporterReadsBackWhatWasInTheLog) {
  const RobotModel robot = write_log();
  const ExportSummary summary = export_tum(log_file(), folder_ / "tum", {});
  EXPECT_EQ(summary.written.at("colour images"), 3);
  EXPECT_EQ(summary.skipped.at("CAMERA: not a message of its type"), 1);
  EXPECT_EQ(summary.skipped.at("depth pixels beyond 13.1 m"), 3);
  const RgbdDataset dataset = open_tum_rgbd(folder_ / "tum");
  EXPECT_EQ(dataset.camera.fx_px, 571.25);
  EXPECT_EQ(dataset.camera.cy_px, 11.5);
  EXPECT_EQ(dataset.camera.distortion[4], 0.03);
  EXPECT_EQ(dataset.skipped.total(), 0);
  ASSERT_EQ(dataset.entries.size(), 3U);
  ASSERT_EQ(dataset.reference.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_EQ(dataset.entries[k].utime_us, kT0 + i * 50'000);
    EXPECT_EQ(dataset.entries[k].depth_utime_us, kT0 + i * 50'000 + 4'000);
    std::string why;
    const auto read = load_frame(dataset, k, &why);
    ASSERT_TRUE(read) << why;
    RgbdFrame written = frame(i);
    const auto as_sent = decode_jpeg(encode_jpeg(written.colour_bgr), 32, 24, &why);
    EXPECT_EQ(cv::norm(read->colour_bgr, *as_sent, cv::NORM_INF), 0.0);
    written.depth_mm.at<std::uint16_t>(5, 5) = 0;
    EXPECT_EQ(cv::norm(read->depth_mm, written.depth_mm, cv::NORM_INF), 0.0);
    const SE3 expected = T_world_base(i) * robot.T_base_camera;
    EXPECT_TRUE(dataset.reference[k].T_world_reference.isApprox(expected, 1e-5));
  }
}

TEST_F(TumExport, FilesAreAsTheFormatSays) {
  write_log();
  export_tum(log_file(), folder_ / "tum", {});
  EXPECT_EQ(text_of(folder_ / "tum/rgb.txt"),
            "# color images\n# from log.lcm by fusion-slam export\n"
            "# camera: fx 571.25 fy 525 cx 319.5 cy 11.5 k1 0.1 k2 -0.2 p1 0.001 p2 0.002 k3 0.03 "
            "width 32 height 24\n"
            "1700000000.000123 rgb/1700000000.000123.png\n"
            "1700000000.050123 rgb/1700000000.050123.png\n"
            "1700000000.100123 rgb/1700000000.100123.png\n");
  EXPECT_EQ(text_of(folder_ / "tum/depth.txt"),
            "# depth maps\n# from log.lcm by fusion-slam export\n"
            "1700000000.004123 depth/1700000000.004123.png\n"
            "1700000000.054123 depth/1700000000.054123.png\n"
            "1700000000.104123 depth/1700000000.104123.png\n");
  // Base looks along x: the camera's x axis is -y, its z axis x.
  const std::string truth = text_of(folder_ / "tum/groundtruth.txt");
  EXPECT_NE(truth.find("1700000000.000123 1.100000 0.000000 0.400000 "
                       "-0.50000000 0.50000000 -0.50000000 0.50000000\n"),
            std::string::npos)
      << truth;
  const cv::Mat depth =
      cv::imread((folder_ / "tum/depth/1700000000.004123.png").string(), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(depth.type(), CV_16UC1);
  EXPECT_EQ(depth.at<std::uint16_t>(3, 7), 5 * (600 + 70 + 3));
}

TEST_F(TumExport, KeepsTheLogsOwnJpegs) {
  write_log();
  TumExportOptions options;
  options.keep_jpeg = true;
  export_tum(log_file(), folder_ / "tum", options);
  const std::string bytes = text_of(folder_ / "tum/rgb/1700000000.000123.jpg");
  const Bytes sent = encode_jpeg(frame(0).colour_bgr);
  EXPECT_EQ(bytes, std::string(sent.begin(), sent.end()));
}

TEST_F(TumExport, SaysWhyItCannotAndLeavesNothing) {
  write_log(false);
  EXPECT_THROW(export_tum(log_file(), folder_ / "tum", {}), ExportError);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tum"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tum.partial"));
  write_log(true, false);
  EXPECT_THROW(export_tum(log_file(), folder_ / "tum", {}), ExportError);
  write_log();
  std::filesystem::create_directories(folder_ / "full/of");
  EXPECT_THROW(export_tum(log_file(), folder_ / "full", {}), ExportError);
  EXPECT_THROW(export_tum(log_file(), folder_ / "log.lcm" / "sub", {}), ExportError);
}

}  // namespace
}  // namespace fusion_slam
