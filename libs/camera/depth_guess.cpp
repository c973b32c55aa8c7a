#include "libs/camera/depth_guess.hpp"

#include <algorithm>
#include <cstddef>

namespace fusion_slam {

DepthGuess::DepthGuess(int width_px, int highest_rank)
    : width_(width_px),
      highest_(highest_rank),
      row_(static_cast<std::size_t>(width_px + 2 * kMargin), 1),
      above_(row_),
      above_that_(row_),
      missing_(static_cast<std::size_t>(width_px + 2), 1),
      known_(static_cast<std::size_t>(width_px)) {}

DepthGuess::Row DepthGuess::begin_row() {
  above_that_.swap(above_);
  above_.swap(row_);
  std::fill_n(above_.begin(), kMargin, above_[kMargin]);
  std::fill_n(above_.end() - kMargin, kMargin, *(above_.end() - kMargin - 1));
  for (int u = 0; u < width_; ++u) {
    const int* above = above_.data() + kMargin + u;
    const int corner = above[-1], up = above[0], right = above[1], far = above[2];
    const int higher = above_that_.data()[kMargin + u];
    const std::uint8_t* missing = missing_.data() + 1 + u;
    Above& known = known_[static_cast<std::size_t>(u)];
    known.sum = -2 * corner + 10 * up + 12 * right + 16 * far - 15 * higher;
    known.unrest = std::abs(corner - up) + std::abs(up - right) + std::abs(up - higher);
    known.missing = missing[0] << 1 | missing[-1] << 2 | missing[1] << 3;
    known.level =
        std::max({corner, up, right, far, higher}) - std::min({corner, up, right, far, higher}) <=
        kStep;
  }
  Row row;
  row.left_ = row.left2_ = row.left3_ = above_[kMargin];
  row.left_missing_ = 1;
  row.highest_ = highest_;
  row.above_ = above_.data() + kMargin;
  row.known_ = known_.data();
  row.here_ = row_.data() + kMargin;
  row.missing_ = missing_.data() + 1;
  return row;
}

}  // namespace fusion_slam
