#include "libs/log_export/lcm_export.hpp"

#include <vector>

#include "fusion_slam/keyframe_image_t.hpp"
#include "tests/libs/log_export/export_fixture.hpp"

namespace fusion_slam {
namespace {

using bot_core::images_t;

constexpr std::int64_t kT0 = 1'700'000'000'000'000;

RgbdFrame frame() {
  RgbdFrame frame{kT0, cv::Mat(48, 64, CV_8UC3, cv::Scalar(40, 80, 120)),
                  cv::Mat(48, 64, CV_16UC1)};
  for (int v = 0; v < 48; ++v)
    for (int u = 0; u < 64; ++u)
      frame.depth_mm.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(900 + 12 * (u / 8 + v));
  return frame;
}

class LcmExport : public ExportFixture {
 protected:
  void write_log() const {
    images_t camera = to_message(frame());
    camera.images[1].utime = kT0 - 5'000;
    images_t colour_alone = camera;
    colour_alone.n_images = 1;
    colour_alone.image_types.resize(1);
    colour_alone.images.resize(1);
    keyframe_image_t keyframe{};
    keyframe.id = 7;
    keyframe.images = camera;
    LogWriter log(log_file());
    put(&log, kT0, "ROBOT_MODEL", to_message(RobotModel{}, kT0));
    put(&log, kT0 + 1, "CAMERA", camera);
    put(&log, kT0 + 2, "CAMERA", colour_alone);
    put(&log, kT0 + 3, "KEYFRAME_IMAGE", keyframe);
    log.write(kT0 + 4, "SOMETHING", std::vector<std::uint8_t>{1, 2, 3});
    log.close();
  }

  static std::vector<LogEvent> events(const std::filesystem::path& log) {
    std::vector<LogEvent> events;
    for_each_event(log, [&](const LogEvent& event) { events.push_back(event); }, {});
    return events;
  }
};

TEST_F(LcmExport, DepthIsPackedAndNothingElseChanges) {
  write_log();
  const ExportSummary summary = export_lcm(log_file(), folder_ / "out.lcm", {});
  EXPECT_EQ(summary.written.at("events"), 5);
  EXPECT_EQ(summary.written.at("of CAMERA coded anew"), 1);
  EXPECT_EQ(summary.skipped.at("CAMERA, left as it was: there is no depth"), 1);
  const auto before = events(log_file()), after = events(folder_ / "out.lcm");
  ASSERT_EQ(after.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(after[i].channel, before[i].channel);
    EXPECT_EQ(after[i].timestamp_us, before[i].timestamp_us);
    if (i == 1 || i == 3) continue;
    EXPECT_EQ(after[i].data, before[i].data) << i;
  }
  const auto old_camera = decode_event<images_t>(before[1]);
  const auto camera = decode_event<images_t>(after[1]);
  ASSERT_TRUE(camera);
  EXPECT_EQ(camera->image_types[1], kDepthPacked);
  EXPECT_EQ(camera->images[1].utime, kT0 - 5'000);
  EXPECT_EQ(camera->images[0].data, old_camera->images[0].data);
  EXPECT_LT(camera->images[1].size, old_camera->images[1].size);
  std::string why;
  const auto depth = decode_depth(*camera, &why);
  ASSERT_TRUE(depth) << why;
  EXPECT_EQ(cv::norm(*depth, frame().depth_mm, cv::NORM_INF), 0.0);
  const auto keyframe = decode_event<keyframe_image_t>(after[3]);
  ASSERT_TRUE(keyframe);
  EXPECT_EQ(keyframe->id, 7);
  EXPECT_EQ(keyframe->images.image_types[1], kDepthPacked);
}

TEST_F(LcmExport, ThereAndBackIsTheSameLog) {
  write_log();
  export_lcm(log_file(), folder_ / "packed.lcm", {});
  LcmExportOptions plain;
  plain.images = ImageCoding::kPlain;
  export_lcm(folder_ / "packed.lcm", folder_ / "plain.lcm", plain);
  const auto before = events(log_file()), after = events(folder_ / "plain.lcm");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) EXPECT_EQ(after[i].data, before[i].data) << i;
}

TEST_F(LcmExport, ColourIsEncodedAnewWhenAsked) {
  write_log();
  LcmExportOptions options;
  options.jpeg_quality = 40;
  export_lcm(log_file(), folder_ / "out.lcm", options);
  const auto before = decode_event<images_t>(events(log_file())[1]);
  const auto after = decode_event<images_t>(events(folder_ / "out.lcm")[1]);
  ASSERT_TRUE(after);
  EXPECT_LT(after->images[0].size, before->images[0].size);
  EXPECT_EQ(after->images[0].utime, kT0);
}

TEST_F(LcmExport, TheLogItselfIsNotOverwritten) {
  write_log();
  EXPECT_THROW(export_lcm(log_file(), log_file(), {}), ExportError);
  EXPECT_EQ(events(log_file()).size(), 5U);
  EXPECT_THROW(export_lcm(log_file(), folder_ / "no" / "such" / "out.lcm", {}), ExportError);
}

}  // namespace
}  // namespace fusion_slam
