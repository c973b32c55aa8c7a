// What is expected at a pixel of a depth image by those before it (left, and the two rows above),
// and how sure that is: what encoder and decoder of packed depth share. Depths are ranks (1 is the
// nearest value that the image has, 0: no depth). Pure; one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace fusion_slam {

inline constexpr int kDepthContexts = 64;

class DepthGuess {
 private:
  static constexpr int kMargin = 3;
  static constexpr int kStep = 6;  // ranks; neighbours that differ by more are two surfaces

  struct Above {  // of the rows above a pixel
    int sum = 0;
    int unrest = 0;
    int missing = 0;
    bool level = false;
  };

 public:
  struct Guess {
    int rank = 1;     // 1 ... highest
    int context = 0;  // below kDepthContexts: pixels that are as sure as each other
  };

  // One row, pixel by pixel: guess(), then put() what it turned out to be.
  class Row {
   public:
    Guess guess() const {
      const int up = above_[0], corner = above_[-1];
      const int missing = known_->missing | left_missing_;
      const int unrest = known_->unrest + std::abs(left_ - corner) + std::abs(left_ - left2_);
      Guess guess;
      if (known_->level && std::abs(left_ - up) <= kStep && std::abs(left_ - left2_) <= kStep &&
          std::abs(left_ - left3_) <= kStep) {
        // One surface: weights that gave the least squared error on recordings of structured-light
        // cameras, real and simulated; planes are linear in disparity.
        const int sum = known_->sum + 25 * left_ + 13 * left2_ + 5 * left3_;
        guess.rank = sum >> 6;
        guess.context =
            missing != 0 ? 28 + missing : 4 * kUnrest[std::min(unrest, 9)] + (sum & 63) / 16;
      } else {
        // An edge: LOCO-I's median (Weinberger, Seroussi & Sapiro 2000).
        const int low = std::min(left_, up), high = std::max(left_, up);
        guess.rank = corner >= high ? low : corner <= low ? high : left_ + up - corner;
        guess.context = missing != 0   ? 48 + missing
                        : unrest <= 8  ? 44
                        : unrest <= 16 ? 45
                        : unrest <= 40 ? 46
                                       : 47;
      }
      guess.rank = std::min(highest_, std::max(1, guess.rank));
      return guess;
    }

    // 0: there is no depth; the guess stands in for it.
    void put(int rank, const Guess& guess) {
      left3_ = left2_;
      left2_ = left_;
      left_missing_ = rank == 0 ? 1 : 0;
      left_ = rank != 0 ? rank : guess.rank;
      *here_++ = left_;
      *missing_++ = static_cast<std::uint8_t>(left_missing_);
      ++above_;
      ++known_;
    }

   private:
    friend class DepthGuess;
    static constexpr int kUnrest[10] = {0, 1, 2, 3, 4, 4, 5, 5, 5, 6};

    int left_, left2_, left3_, left_missing_, highest_;
    const int* above_;
    const Above* known_;
    int* here_;
    std::uint8_t* missing_;
  };

  DepthGuess(int width_px, int highest_rank);

  // The next row, the first one first; the one before it has been put to its end.
  Row begin_row();

 private:
  int width_, highest_;
  std::vector<int> row_, above_, above_that_;  // with margins
  std::vector<std::uint8_t> missing_;          // of the row above, then of this one; margin 1
  std::vector<Above> known_;
};

}  // namespace fusion_slam
