// What is expected at a pixel of a depth image by those before it (left, and the two rows above),
// and how sure that is: what encoder and decoder of packed depth share. Depths are ranks (1 is the
// nearest value that the image has, 0: no depth). Pure; one thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace fusion_slam {

inline constexpr int kDepthContexts = 64;

class DepthGuess {
 public:
  struct Guess {
    int rank = 1;     // 1 ... highest
    int context = 0;  // below kDepthContexts: pixels that are as sure as each other
  };

  DepthGuess(int width_px, int highest_rank);

  // Before the first pixel of each row.
  void begin_row();

  // Pixel u of the row; those left of it have been put.
  Guess at(int u) const {
    const int* here = row_.data() + kMargin + u;
    const int* above = above_.data() + kMargin + u;
    const Above& known = known_[static_cast<std::size_t>(u)];
    const int left = here[-1], up = above[0], corner = above[-1];
    const int missing = known.missing | left_missing_;
    const int unrest = known.unrest + std::abs(left - corner) + std::abs(left - here[-2]);
    Guess guess;
    if (known.level && std::abs(left - up) <= kStep && std::abs(left - here[-2]) <= kStep &&
        std::abs(left - here[-3]) <= kStep) {
      // One surface: weights that gave the least squared error on recordings of structured-light
      // cameras, real and simulated; planes are linear in disparity.
      const int sum = known.sum + 25 * left + 13 * here[-2] + 5 * here[-3];
      guess.rank = sum >> 6;
      guess.context =
          missing != 0 ? 28 + missing : 4 * kUnrest[std::min(unrest, 9)] + (sum & 63) / 16;
    } else {
      // An edge: LOCO-I's median (Weinberger, Seroussi & Sapiro 2000).
      const auto [low, high] = std::minmax(left, up);
      guess.rank = corner >= high ? low : corner <= low ? high : left + up - corner;
      guess.context = missing != 0   ? 48 + missing
                      : unrest <= 8  ? 44
                      : unrest <= 16 ? 45
                      : unrest <= 40 ? 46
                                     : 47;
    }
    guess.rank = std::min(highest_, std::max(1, guess.rank));
    return guess;
  }

  // What the pixel turned out to be; where there is no depth the guess stands in for it.
  void put(int u, int rank, const Guess& guess) {
    row_[static_cast<std::size_t>(kMargin + u)] = rank != 0 ? rank : guess.rank;
    missing_[static_cast<std::size_t>(1 + u)] = rank == 0;
    left_missing_ = rank == 0;
  }

 private:
  static constexpr int kMargin = 3;
  static constexpr int kStep = 6;  // ranks; neighbours that differ by more are two surfaces
  static constexpr int kUnrest[10] = {0, 1, 2, 3, 4, 4, 5, 5, 5, 6};

  struct Above {  // of the rows above a pixel
    int sum = 0;
    int unrest = 0;
    int missing = 0;
    bool level = false;
  };

  int width_, highest_;
  int left_missing_ = 1;
  std::vector<int> row_, above_, above_that_;  // with margins
  std::vector<std::uint8_t> missing_;          // of the row above, then of this one; margin 1
  std::vector<Above> known_;
};

}  // namespace fusion_slam
