// The driver against the virtual device in the real OpenNI2 runtime: setting up, faults,
// recordings, colour from elsewhere.
#include <chrono>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "drivers/openni2_camera/camera_process.hpp"
#include "libs/camera_messages/images.hpp"
#include "tests/drivers/openni2_camera/rig.hpp"

namespace fusion_slam {
namespace {

using testing::HasSubstr;

const FramePair& last_pair(const CameraRig::Diary& diary) {
  for (auto it = diary.rbegin(); it != diary.rend(); ++it)
    if (it->text.empty()) return it->pair;
  throw std::runtime_error("there is no pair");
}

int differing(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type()
             ? cv::countNonZero(a.reshape(1) != b.reshape(1))
             : INT_MAX;
}

TEST(OpenniDriver, SetsTheDeviceUpAndPairsItsImages) {
  CameraRig rig;
  rig.config().connection.auto_exposure = false;
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(10));
  EXPECT_TRUE(rig.wait_for_text("running: Fusion-SLAM virtual RGB-D camera"));
  EXPECT_EQ(rig.feed().header().mirrored, 0U);
  EXPECT_EQ(rig.feed().header().registered, 1U);
  EXPECT_EQ(rig.feed().header().auto_exposure, 0U);
  EXPECT_FALSE(rig.setup()->registration);
  rig.stop();
  const auto diary = rig.diary();
  const FramePair& pair = last_pair(diary);
  EXPECT_EQ(differing(pair.colour.image, rig.scene().colour_bgr), 0);
  EXPECT_EQ(differing(pair.depth.image, rig.scene().registered_mm), 0);
  EXPECT_NEAR(pair.error_us(), 3000, 1);
  const auto wall_us = std::chrono::duration_cast<std::chrono::microseconds>(
                           std::chrono::system_clock::now().time_since_epoch())
                           .count();
  EXPECT_GT(pair.colour.utime_us, wall_us - 60'000'000);
  EXPECT_LE(pair.colour.utime_us, wall_us);
  EXPECT_EQ(rig.driver().statistics().damaged, 0);
}

TEST(OpenniDriver, RegistersDepthItselfWhenTheDeviceCannot) {
  FeedFormat format = rig_format();
  format.can_register = false;
  CameraRig rig(format);
  rig.config().connection.intrinsics = "device";
  rig.config().connection.T_colour_depth = from_xyz_rpy(kRigBaseline_m, 0, 0, 0, 0, 0);
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(2));
  rig.stop();
  ASSERT_TRUE(rig.setup()->registration);
  EXPECT_NEAR(rig.setup()->model.fx_px, 140.0, 1e-3);
  EXPECT_NEAR(rig.setup()->registration->depth_camera.fx_px, 150.0, 1e-3);
  const auto diary = rig.diary();
  const FramePair& pair = last_pair(diary);
  EXPECT_EQ(differing(pair.depth.image, rig.scene().depth_mm), 0);
  const bot_core::images_t message = to_message(pair, *rig.setup(), 90);
  EXPECT_EQ(message.utime, pair.colour.utime_us);
  EXPECT_EQ(message.images[0].utime, pair.colour.utime_us);
  EXPECT_EQ(message.images[1].utime, pair.depth.utime_us);
  std::string why;
  const auto frame = from_message(message, &why);
  ASSERT_TRUE(frame) << why;
  // But for the box's edges and what the depth camera can't see, depth is colour's.
  int wrong = 0;
  for (int v = 0; v < 120; ++v)
    for (int u = 0; u < 160; ++u) {
      const int got = frame->depth_mm.at<std::uint16_t>(v, u);
      wrong += got != 0 && got != rig.scene().registered_mm.at<std::uint16_t>(v, u) ? 1 : 0;
    }
  EXPECT_LT(wrong, 120);
  EXPECT_GT(cv::countNonZero(frame->depth_mm), 160 * 120 * 8 / 10);
}

TEST(OpenniDriver, SaysWhatIsMissingForRegistration) {
  FeedFormat format = rig_format();
  format.can_register = false;
  CameraRig rig(format);
  rig.plug_in();
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("depth_mount_xyz_m_rpy_deg"));
}

TEST(OpenniDriver, SaysWhichModesThereAre) {
  CameraRig rig;
  rig.config().camera.width_px = 200;
  rig.config().camera.height_px = 100;
  rig.plug_in();
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("it offers: 160 x 120 at 30 Hz"));
}

TEST(OpenniDriver, WaitsForADeviceThatIsNotThere) {
  CameraRig rig;
  rig.start();
  ASSERT_TRUE(rig.wait_for_text("no OpenNI2 device is plugged in"));
  rig.plug_in();
  EXPECT_TRUE(rig.wait_for_pairs(3));
  EXPECT_TRUE(rig.wait_for_text("; again after"));
}

TEST(OpenniDriver, ComesBackByItselfAfterEachFault) {
  const std::vector<std::pair<CameraFault, std::string>> faults = {
      {CameraFault::kUnplug, "unplugged?"},
      {CameraFault::kStall, "went silent: nothing for 500 ms"},
      {CameraFault::kStallColour, "only depth comes"},
      {CameraFault::kStallDepth, "only colour comes"},
      {CameraFault::kCorrupt, "damaged on the way"},
      {CameraFault::kWrongSize, "it is 80 x 120 and not 160 x 120"},
      {CameraFault::kClockRestart, "clock jumped"}};
  CameraRig rig;
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(5));
  for (const auto& [fault, text] : faults) {
    std::size_t from = rig.now();
    rig.feed().set_fault(fault);
    EXPECT_TRUE(rig.wait_for_text(text, from)) << to_string(fault);
    rig.feed().set_fault(CameraFault::kNone);
    from = rig.now();
    EXPECT_TRUE(rig.wait_for_pairs(5, from)) << to_string(fault);
  }
  rig.stop();
  std::int64_t before_us = 0;
  for (const auto& entry : rig.diary()) {
    if (!entry.text.empty()) continue;  // what came was whole, and time never ran backwards
    EXPECT_EQ(differing(entry.pair.colour.image, rig.scene().colour_bgr), 0);
    EXPECT_EQ(differing(entry.pair.depth.image, rig.scene().registered_mm), 0);
    EXPECT_GT(entry.pair.colour.utime_us, before_us);
    before_us = entry.pair.colour.utime_us;
  }
}

TEST(OpenniDriver, ADeviceInUseIsSaidToBe) {
  CameraRig rig;
  rig.plug_in();
  rig.feed().set_fault(CameraFault::kBusy);
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("in use by another program"));
  rig.feed().set_fault(CameraFault::kNone);
  EXPECT_TRUE(rig.wait_for_pairs(2));
}

TEST(OpenniDriver, RestartOpensTheDeviceAgain) {
  CameraRig rig;
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(3));
  const std::size_t from = rig.now();
  rig.driver().restart();
  EXPECT_TRUE(rig.wait_for_text("restart asked for", from));
  EXPECT_TRUE(rig.wait_for_pairs(3, rig.now()));
  EXPECT_GE(rig.driver().statistics().opened, 2);
}

// The runtime records the virtual device, the driver plays the recording. (The runtime's recorder
// counts each stream's time from that stream's first frame: what lay between the two is lost.)
TEST(OpenniDriver, PlaysWhatTheRuntimeRecorded) {
  CameraRig rig;
  const std::filesystem::path file = rig.folder() / "recording.oni";
  rig.plug_in();
  const std::string command =
      std::string(FS_BINARY_DIR) + "/bin/record_oni " + file.string() + " 1.5";
  ASSERT_EQ(std::system(command.c_str()), 0);
  rig.unplug();
  rig.config().file = file;
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(15));
  for (int i = 0; i < 1500 && !rig.ended(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(rig.ended());
  rig.stop();
  const auto diary = rig.diary();
  const FramePair& pair = last_pair(diary);
  EXPECT_EQ(differing(pair.colour.image, rig.scene().colour_bgr), 0);
  EXPECT_EQ(differing(pair.depth.image, rig.scene().registered_mm), 0);
  EXPECT_LE(std::abs(pair.error_us()), 16'667);
  EXPECT_FALSE(rig.setup()->registration);  // as it was recorded
}

// There is no UVC camera here: a video file goes the same way.
TEST(UvcColour, IsPairedWithTheDevicesDepth) {
  FeedFormat format = rig_format();
  CameraRig rig(format);
  const std::string video = (rig.folder() / "colour.avi").string();
  cv::VideoWriter writer(video, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                         30.0, {format.width_px, format.height_px});
  ASSERT_TRUE(writer.isOpened());
  for (int i = 0; i < 60; ++i) writer.write(rig.scene().colour_bgr);
  writer.release();
  rig.config().connection.colour = video;
  rig.config().connection.T_colour_depth = from_xyz_rpy(kRigBaseline_m, 0, 0, 0, 0, 0);
  rig.plug_in();
  rig.start();
  ASSERT_TRUE(rig.wait_for_pairs(10));
  EXPECT_EQ(rig.feed().header().registered, 0U);  // not to a colour camera that isn't its own
  EXPECT_TRUE(rig.setup()->registration);
  EXPECT_TRUE(rig.wait_for_text("gives no images any more"));
  rig.stop();
  const auto diary = rig.diary();
  const FramePair& pair = last_pair(diary);
  cv::Mat difference;
  cv::absdiff(pair.colour.image, rig.scene().colour_bgr, difference);
  EXPECT_LT(cv::mean(difference)[0], 12.0);  // JPEG
  EXPECT_LE(std::abs(pair.error_us()), 16'667);
}

TEST(UvcColour, AMissingCameraIsNamed) {
  CameraRig rig;
  rig.config().connection.colour = "/dev/video-that-is-not";
  rig.config().connection.registration = "none";
  rig.plug_in();
  rig.start();
  EXPECT_TRUE(rig.wait_for_text("there is no colour camera /dev/video-that-is-not"));
}

}  // namespace
}  // namespace fusion_slam
