#include "libs/features/orb_extractor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "libs/features/spread_corners.hpp"

namespace fusion_slam {
namespace {

constexpr int kPatchRadius_px = 15;  // orientation and descriptor look this far
constexpr int kMargin_px = 19;       // rotated patch corners and FAST's ring stay inside

// Half-width of the disc of radius kPatchRadius_px at each row.
std::array<int, kPatchRadius_px + 1> disc_half_widths() {
  std::array<int, kPatchRadius_px + 1> widths{};
  for (int v = 0; v <= kPatchRadius_px; ++v)
    widths[v] = static_cast<int>(std::sqrt(kPatchRadius_px * kPatchRadius_px - v * v));
  return widths;
}

// Direction from a corner to the intensity centroid of the disc around it (Rosin 1999), degrees 0
// .. 360.
float centroid_angle_deg(const cv::Mat& image, const cv::Point2f& corner) {
  static const std::array<int, kPatchRadius_px + 1> half_widths = disc_half_widths();
  const int cx = cvRound(corner.x);
  const int cy = cvRound(corner.y);
  int m10 = 0;
  int m01 = 0;
  for (int v = -kPatchRadius_px; v <= kPatchRadius_px; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(cy + v) + cx;
    const int width = half_widths[std::abs(v)];
    int row_sum = 0;
    for (int u = -width; u <= width; ++u) {
      row_sum += row[u];
      m10 += u * row[u];
    }
    m01 += v * row_sum;
  }
  return cv::fastAtan2(static_cast<float>(m01), static_cast<float>(m10));
}

// Where image gradients meet (Foerstner & Guelch 1987), in the 5 x 5 pixels around each corner; one
// that would leave these stays.
void refine_corners(const cv::Mat& level, std::vector<cv::KeyPoint>* kept) {
  constexpr int kRadius_px = 2;
  if (kept->empty()) return;
  std::vector<cv::Point2f> points;
  for (const cv::KeyPoint& corner : *kept) points.push_back(corner.pt);
  cv::cornerSubPix(level, points, {kRadius_px, kRadius_px}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 5, 0.03});
  for (std::size_t i = 0; i < points.size(); ++i) (*kept)[i].pt = points[i];
}

}  // namespace

OrbExtractor::OrbExtractor(const OrbConfig& config) : config_(config) {
  // Equally dense in the pyramid's own "length": quota ~ 1 / scale, so that near views keep their
  // share.
  double total = 0.0;
  for (int i = 0; i < config_.n_levels; ++i) {
    scales_.push_back(std::pow(config_.scale_factor, i));
    total += 1.0 / scales_.back();
  }
  for (const double scale : scales_)
    quotas_.push_back(
        std::max(1, static_cast<int>(std::lround(config_.n_features / scale / total))));
}

double OrbExtractor::scale(int octave) const {
  return scales_[std::clamp(octave, 0, config_.n_levels - 1)];
}

std::vector<cv::KeyPoint> OrbExtractor::corners(const cv::Mat& level, int quota) const {
  const cv::Rect inner(kMargin_px - 3, kMargin_px - 3, level.cols - 2 * (kMargin_px - 3),
                       level.rows - 2 * (kMargin_px - 3));
  std::vector<cv::KeyPoint> kept =
      spread_corners(level(inner), quota, config_.fast_threshold, config_.fast_threshold_low);
  for (cv::KeyPoint& corner : kept) {
    corner.pt += cv::Point2f(static_cast<float>(inner.x), static_cast<float>(inner.y));
    corner.angle = centroid_angle_deg(level, corner.pt);
    corner.octave = 0;
  }
  return kept;
}

FeatureSet OrbExtractor::extract(const cv::Mat& grey) const {
  FeatureSet result;
  // OpenCV's rBRIEF on one level at a time, so that corners and descriptors come from the same
  // pyramid.
  const cv::Ptr<cv::ORB> describe = cv::ORB::create(config_.n_features, 1.2F, 1, 1);
  cv::Mat level = grey;
  for (int octave = 0; octave < config_.n_levels; ++octave) {
    if (octave > 0) {
      cv::Mat smaller;
      const cv::Size size(cvRound(grey.cols / scales_[octave]),
                          cvRound(grey.rows / scales_[octave]));
      if (size.width < 1 || size.height < 1) break;
      cv::resize(level, smaller, size, 0, 0, cv::INTER_LINEAR);
      level = smaller;
    }
    if (level.cols <= 2 * kMargin_px || level.rows <= 2 * kMargin_px) break;
    std::vector<cv::KeyPoint> kept = corners(level, quotas_[octave]);
    cv::Mat bytes;
    describe->compute(level, kept, bytes);
    if (config_.sub_pixel) refine_corners(level, &kept);
    const double sx = static_cast<double>(grey.cols) / level.cols;
    const double sy = static_cast<double>(grey.rows) / level.rows;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      Feature f;
      f.u_px = static_cast<float>((kept[i].pt.x + 0.5) * sx - 0.5);
      f.v_px = static_cast<float>((kept[i].pt.y + 0.5) * sy - 0.5);
      f.angle_rad = static_cast<float>(kept[i].angle * CV_PI / 180.0);
      f.octave = static_cast<std::int8_t>(octave);
      result.features.push_back(f);
      result.descriptors.push_back(descriptor_from_bytes(bytes.ptr(static_cast<int>(i))));
    }
  }
  return result;
}

}  // namespace fusion_slam
