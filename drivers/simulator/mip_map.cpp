#include "drivers/simulator/mip_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace fusion_slam {
namespace {

constexpr int kOne = 128;  // weights of a level's neighbours are parts of this

std::vector<Texel> half_size(int width, int height, const std::vector<Texel>& texels) {
  const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
  std::vector<Texel> half(static_cast<std::size_t>(half_width) *
                          static_cast<std::size_t>(half_height));
  const auto in = [&](int x, int y) -> const Texel& {
    return texels[static_cast<std::size_t>(std::min(y, height - 1)) *
                      static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(std::min(x, width - 1))];
  };
  auto out = half.begin();
  for (int y = 0; y < half_height; ++y)
    for (int x = 0; x < half_width; ++x, ++out) {
      const Texel &a = in(2 * x, 2 * y), &b = in(2 * x + 1, 2 * y);
      const Texel &c = in(2 * x, 2 * y + 1), &d = in(2 * x + 1, 2 * y + 1);
      for (std::size_t k = 0; k < 4; ++k)
        (*out)[k] = static_cast<std::uint8_t>((a[k] + b[k] + c[k] + d[k] + 2) / 4);
    }
  return half;
}

// Two texels of the upper row and two of the lower, weighted: a to the right, b down.
inline std::array<float, 4> blend(const Texel* top, const Texel* bottom, int a, int b) {
  std::array<float, 4> out;
  constexpr float kScale = 1.0F / (kOne * kOne);
#if defined(__SSE2__)
  const __m128i zero = _mm_setzero_si128();
  const __m128i upper =
      _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(top)), zero);
  const __m128i lower =
      _mm_unpacklo_epi8(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(bottom)), zero);
  const __m128i rows =
      _mm_add_epi16(_mm_mullo_epi16(upper, _mm_set1_epi16(static_cast<short>(kOne - b))),
                    _mm_mullo_epi16(lower, _mm_set1_epi16(static_cast<short>(b))));
  const __m128i pairs = _mm_unpacklo_epi16(rows, _mm_unpackhi_epi64(rows, rows));
  const __m128i sum = _mm_madd_epi16(pairs, _mm_set1_epi32((a << 16) | (kOne - a)));
  _mm_storeu_ps(out.data(), _mm_mul_ps(_mm_cvtepi32_ps(sum), _mm_set1_ps(kScale)));
#else
  for (std::size_t k = 0; k < 4; ++k) {
    const int left = top[0][k] * (kOne - b) + bottom[0][k] * b;
    const int right = top[1][k] * (kOne - b) + bottom[1][k] * b;
    out[k] = static_cast<float>(left * (kOne - a) + right * a) * kScale;
  }
#endif
  return out;
}

// x within [0, width), the picture repeated. |x| below 2^31 widths.
inline float repeated(float x, float width, float inverse) {
  const float turns = x * inverse;
  float whole = static_cast<float>(static_cast<int>(turns));
  whole = whole > turns ? whole - 1.0F : whole;
  x -= whole * width;
  return x < width && x >= 0.0F ? x : 0.0F;
}

}  // namespace

MipMap::MipMap(int width, int height, const std::vector<Texel>& texels, Beyond beyond)
    : beyond_(beyond) {
  if (width <= 0 || height <= 0 ||
      texels.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    throw std::invalid_argument("a picture needs width * height texels");
  append(width, height, texels);
  std::vector<Texel> smaller = texels;
  while (width > 1 || height > 1) {
    smaller = half_size(width, height, smaller);
    width = (width + 1) / 2;
    height = (height + 1) / 2;
    append(width, height, smaller);
  }
  texels_.shrink_to_fit();
}

void MipMap::append(int width, int height, const std::vector<Texel>& texels) {
  Level level;
  level.width = width;
  level.height = height;
  level.begin = texels_.size();
  if (!levels_.empty()) {
    const Level& first = levels_.front();
    const float halvings = 1.0F / static_cast<float>(1U << levels_.size());
    // A repeated picture must fit itself, whatever its size.
    level.scale_x = beyond_ == Beyond::kRepeat
                        ? static_cast<float>(width) / static_cast<float>(first.width)
                        : halvings;
    level.scale_y = beyond_ == Beyond::kRepeat
                        ? static_cast<float>(height) / static_cast<float>(first.height)
                        : halvings;
  }
  for (int y = 0; y <= height; ++y) {
    const int from = y < height ? y : (beyond_ == Beyond::kRepeat ? 0 : height - 1);
    const auto row = texels.begin() + static_cast<std::ptrdiff_t>(from) * width;
    texels_.insert(texels_.end(), row, row + width);
    texels_.push_back(beyond_ == Beyond::kRepeat ? *row : *(row + width - 1));
  }
  levels_.push_back(level);
}

inline std::array<float, 4> MipMap::bilinear(const Level& level, float x, float y) const {
  x = x * level.scale_x - 0.5F;
  y = y * level.scale_y - 0.5F;
  const auto w = static_cast<float>(level.width), h = static_cast<float>(level.height);
  if (beyond_ == Beyond::kRepeat) {
    x = repeated(x, w, 1.0F / w);
    y = repeated(y, h, 1.0F / h);
  } else {
    x = std::min(std::max(x, 0.0F), w - 1.0F);
    y = std::min(std::max(y, 0.0F), h - 1.0F);
  }
  const int fixed_x = static_cast<int>(x * kOne), fixed_y = static_cast<int>(y * kOne);
  const int x0 = fixed_x / kOne, y0 = fixed_y / kOne;
  const int a = fixed_x % kOne, b = fixed_y % kOne;
  const auto stride = static_cast<std::size_t>(level.width) + 1;
  const Texel* top = texels_.data() + level.begin + static_cast<std::size_t>(y0) * stride +
                     static_cast<std::size_t>(x0);
  return blend(top, top + stride, a, b);
}

void MipMap::bilinear(const Level& level, const std::array<float, 8>& x,
                      const std::array<float, 8>& y,
                      std::array<std::array<float, 4>, 8>* out) const {
  const auto w = static_cast<float>(level.width), h = static_cast<float>(level.height);
  const int stride = level.width + 1;
  alignas(32) std::array<int, 8> place, a, b;
  if (beyond_ == Beyond::kRepeat) {
    for (std::size_t i = 0; i < 8; ++i) {
      const float px = repeated(x[i] * level.scale_x - 0.5F, w, 1.0F / w);
      const float py = repeated(y[i] * level.scale_y - 0.5F, h, 1.0F / h);
      const auto fixed_x = static_cast<unsigned>(static_cast<int>(px * kOne));
      const auto fixed_y = static_cast<unsigned>(static_cast<int>(py * kOne));
      a[i] = static_cast<int>(fixed_x % kOne);
      b[i] = static_cast<int>(fixed_y % kOne);
      place[i] = static_cast<int>(fixed_y / kOne) * stride + static_cast<int>(fixed_x / kOne);
    }
  } else {
    for (std::size_t i = 0; i < 8; ++i) {
      const float px = std::min(std::max(x[i] * level.scale_x - 0.5F, 0.0F), w - 1.0F);
      const float py = std::min(std::max(y[i] * level.scale_y - 0.5F, 0.0F), h - 1.0F);
      const auto fixed_x = static_cast<unsigned>(static_cast<int>(px * kOne));
      const auto fixed_y = static_cast<unsigned>(static_cast<int>(py * kOne));
      a[i] = static_cast<int>(fixed_x % kOne);
      b[i] = static_cast<int>(fixed_y % kOne);
      place[i] = static_cast<int>(fixed_y / kOne) * stride + static_cast<int>(fixed_x / kOne);
    }
  }
  // All texels are asked for before the first is used: they come from far memory.
  const Texel* first = texels_.data() + level.begin;
  for (std::size_t i = 0; i < 8; ++i)
    (*out)[i] = blend(first + place[i], first + place[i] + stride, a[i], b[i]);
}

float MipMap::choose(float footprint, std::size_t* fine) const {
  // log2 that is linear between powers of two: its error hides in the blending.
  const float covered = std::max(footprint, 1.0F);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &covered, sizeof bits);
  const float log2 = static_cast<float>(bits - 0x3F800000U) * (1.0F / (1U << 23));
  const float level = std::min(log2, static_cast<float>(levels_.size() - 1));
  *fine = static_cast<std::size_t>(level);
  const float between = level - static_cast<float>(*fine);
  return between < 1.0F / kOne ? 0.0F : between;
}

std::array<float, 3> MipMap::at(float x, float y, float footprint) const {
  std::size_t level = 0;
  const float between = choose(footprint, &level);
  const std::array<float, 4> fine = bilinear(levels_[level], x, y);
  if (between == 0.0F) return {fine[0], fine[1], fine[2]};
  const std::array<float, 4> coarse = bilinear(levels_[level + 1], x, y);
  return {fine[0] + between * (coarse[0] - fine[0]), fine[1] + between * (coarse[1] - fine[1]),
          fine[2] + between * (coarse[2] - fine[2])};
}

void MipMap::at(const std::array<float, 8>& x, const std::array<float, 8>& y, float footprint,
                std::array<std::array<float, 4>, 8>* bgr) const {
  std::size_t level = 0;
  const float between = choose(footprint, &level);
  bilinear(levels_[level], x, y, bgr);
  if (between == 0.0F) return;
  std::array<std::array<float, 4>, 8> coarse;
  bilinear(levels_[level + 1], x, y, &coarse);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t k = 0; k < 4; ++k) (*bgr)[i][k] += between * (coarse[i][k] - (*bgr)[i][k]);
}

}  // namespace fusion_slam
