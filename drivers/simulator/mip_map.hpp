// A picture at several resolutions, each half the one before (mip map, Williams 1983), so that a
// pixel that covers many texels costs as little as one that covers few. Eight bits a channel.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace fusion_slam {

using Texel = std::array<std::uint8_t, 4>;  // blue, green, red, unused

// What lies beyond the picture: its border's colour, or the picture again.
enum class Beyond { kBorder, kRepeat };

// const and thread-safe after construction.
class MipMap {
 public:
  // Row by row from the upper left. Throws std::invalid_argument unless texels.size() is
  // width * height and both are above 0.
  MipMap(int width, int height, const std::vector<Texel>& texels, Beyond beyond);

  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

  // Blue, green, red, 0 to 255, at (x, y) in texels of the full resolution (texel centres at .5) as
  // seen by a pixel that covers `footprint` texels: bilinear in two levels and linear between them.
  // Weights are multiples of 1/128 within a level: integers, the same on every machine.
  std::array<float, 3> at(float x, float y, float footprint) const;
  // The same for eight pixels next to each other, which have one footprint.
  void at(const std::array<float, 8>& x, const std::array<float, 8>& y, float footprint,
          std::array<std::array<float, 4>, 8>* bgr) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    float scale_x = 1.0F;  // texels of this level by texel of the first
    float scale_y = 1.0F;
    std::size_t begin = 0;  // of its first texel; rows are width + 1 texels, and there is one more:
                            // right and lower neighbours can be read without asking
  };
  void append(int width, int height, const std::vector<Texel>& texels);
  // Which two levels, and how much of the coarser one.
  float choose(float footprint, std::size_t* fine) const;
  std::array<float, 4> bilinear(const Level& level, float x, float y) const;
  void bilinear(const Level& level, const std::array<float, 8>& x, const std::array<float, 8>& y,
                std::array<std::array<float, 4>, 8>* out) const;

  Beyond beyond_;
  std::vector<Level> levels_;
  std::vector<Texel> texels_;
};

}  // namespace fusion_slam
