// A keyframe as a picture: its features, and where the last keyframe saw the same landmarks.
#pragma once

#include <map>

#include <opencv2/imgproc.hpp>

#include "services/visual_odometry/tracking_result.hpp"

namespace fusion_slam {

// Green: a landmark the last keyframe saw too, with a line to where it was there; blue: known from
// earlier; yellow: new, with depth; red: bearing only. The size of a circle is the feature's
// octave.
inline cv::Mat draw_keyframe(const cv::Mat& colour_bgr, const Keyframe& now, const Keyframe& last,
                             std::int64_t newest_known) {
  cv::Mat picture = colour_bgr.clone();
  std::map<std::int64_t, cv::Point2f> before;
  for (std::size_t i = 0; i < last.features.size(); ++i)
    before[last.landmark_of_feature[i]] = {last.features.features[i].u_px,
                                           last.features.features[i].v_px};
  for (std::size_t i = 0; i < now.features.size(); ++i) {
    const Feature& f = now.features.features[i];
    const std::int64_t id = now.landmark_of_feature[i];
    const cv::Point2f at(f.u_px, f.v_px);
    cv::Scalar colour(0, 0, 230);
    if (id > newest_known) colour = {0, 220, 230};
    if (id != 0 && id <= newest_known) colour = {230, 140, 0};
    const auto seen = id == 0 ? before.end() : before.find(id);
    if (seen != before.end()) {
      colour = {40, 200, 0};
      cv::line(picture, seen->second, at, colour, 1, cv::LINE_AA);
    }
    cv::circle(picture, at, 2 + f.octave, colour, 1, cv::LINE_AA);
  }
  return picture;
}

}  // namespace fusion_slam
