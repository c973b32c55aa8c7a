#include "drivers/simulator/texture.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/random.hpp"

namespace fusion_slam {
namespace {

struct Kind {
  const char* name;
  Colour bgr;
};
// In the order of TextureKind.
constexpr Kind kKinds[] = {
    {"plaster", {0.74F, 0.80F, 0.82F}}, {"carpet", {0.42F, 0.38F, 0.34F}},
    {"wood", {0.30F, 0.48F, 0.66F}},    {"brick", {0.28F, 0.34F, 0.62F}},
    {"paper", {0.86F, 0.88F, 0.88F}},   {"poster", {0.70F, 0.78F, 0.82F}},
    {"books", {0.35F, 0.40F, 0.45F}},   {"drawers", {0.62F, 0.62F, 0.60F}},
    {"screen", {0.20F, 0.16F, 0.14F}},  {"cardboard", {0.38F, 0.55F, 0.70F}},
    {"tiles", {0.86F, 0.86F, 0.86F}},   {"fabric", {0.45F, 0.28F, 0.22F}},
};

std::uint32_t hash(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = seed + static_cast<std::uint32_t>(x) * 0x8DA6B343U +
                    static_cast<std::uint32_t>(y) * 0xD8163841U;
  h = (h ^ (h >> 16)) * 0x7FEB352DU;
  h = (h ^ (h >> 15)) * 0x846CA68BU;
  return h ^ (h >> 16);
}

float unit(std::uint32_t h) { return static_cast<float>(h >> 8) * 0x1p-24F; }
float cell(float x, float y, std::uint32_t seed) {
  return unit(hash(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y)), seed));
}
float fraction(float x) { return x - std::floor(x); }
Colour scaled(const Colour& c, float k) { return {c[0] * k, c[1] * k, c[2] * k}; }
// A colour of its own for each hash.
Colour any_colour(std::uint32_t h) {
  return {0.15F + 0.7F * unit(h * 0x9E3779B1U), 0.15F + 0.7F * unit(h * 0x85EBCA6BU),
          0.15F + 0.7F * unit(h * 0xC2B2AE35U)};
}

// 0 on ink, 1 on paper: lines of words of strokes.
float text_marks(float s, float t, float line_m, std::uint32_t seed) {
  const float row = std::floor(t / line_m);
  const float in_row = fraction(t / line_m);
  if (in_row < 0.3F || cell(0.5F, row, seed) < 0.15F) return 1.0F;
  const float letter = s / (0.5F * line_m);
  const bool space = cell(letter / 1.7F, row, seed + 1) < 0.22F;
  const float end = 0.55F + 0.45F * cell(0.5F, row, seed + 2);  // ragged right
  if (space || fraction(s / 0.4F) > end) return 1.0F;
  const std::uint32_t glyph =
      hash(static_cast<int>(std::floor(letter)), static_cast<int>(row), seed);
  const int column = static_cast<int>(fraction(letter) * 4.0F);
  const int line = static_cast<int>((in_row - 0.3F) / 0.7F * 5.0F);
  return column < 3 && ((glyph >> (column * 5 + line)) & 1U) != 0 ? 0.15F : 1.0F;
}

Colour plaster(const Colour& base, float s, float t, std::uint32_t seed) {
  float k = 0.88F + 0.2F * fractal_noise(s * 2.0F, t * 2.0F, 6, seed);
  k += 0.05F * (cell(s * 150.0F, t * 150.0F, seed + 1) - 0.5F);
  // Scuffs: dark strokes, few, of several sizes.
  for (int scale = 0; scale < 2; ++scale) {
    const float size = scale == 0 ? 0.5F : 0.17F;
    const float u = s / size, v = t / size;
    const std::uint32_t h = hash(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v)),
                                 seed + 7U + static_cast<std::uint32_t>(scale));
    if ((h & 7U) != 0) continue;
    const float x = fraction(u) - 0.3F - 0.4F * unit(h * 3U);
    const float y = fraction(v) - 0.3F - 0.4F * unit(h * 5U);
    const float slope = 2.0F * unit(h * 7U) - 1.0F;
    if (std::fabs(x) < 0.22F && std::fabs(y - slope * x) < 0.02F + 0.04F * unit(h * 11U))
      k *= 0.72F;
  }
  return scaled(base, k);
}

Colour carpet(const Colour& base, float s, float t, std::uint32_t seed) {
  const float tile = cell(s / 0.5F, t / 0.5F, seed + 3);
  const float weave = fractal_noise(s * 60.0F, t * 60.0F, 3, seed);
  const float wear = fractal_noise(s * 3.0F, t * 3.0F, 4, seed + 1);
  const bool seam = fraction(s / 0.5F) < 0.012F || fraction(t / 0.5F) < 0.012F;
  const bool fleck = cell(s * 55.0F, t * 55.0F, seed + 2) > 0.965F;
  return scaled(base, (0.45F + 0.55F * weave + 0.35F * wear + 0.2F * tile) * (seam ? 0.7F : 1.0F) *
                          (fleck ? 1.6F : 1.0F));
}

Colour wood(const Colour& base, float s, float t, std::uint32_t seed) {
  const float plank = std::floor(t / 0.14F);
  const std::uint32_t own = seed + hash(0, static_cast<int>(plank), seed);
  const float bend = fractal_noise(s * 1.5F, t * 6.0F, 3, own);
  const float grain = value_noise(s * 3.0F, t * 90.0F + 12.0F * bend, own + 1);
  const float fine = value_noise(s * 20.0F, t * 400.0F, own + 2);
  const float knot = value_noise(s * 4.0F, t * 9.0F, own + 3) > 0.93F ? 0.6F : 1.0F;
  const float seam = fraction(t / 0.14F) < 0.03F ? 0.6F : 1.0F;
  return scaled(base, (0.65F + 0.4F * grain + 0.15F * fine + 0.15F * unit(own)) * seam * knot);
}

Colour brick(const Colour& base, float s, float t, std::uint32_t seed) {
  const float row = std::floor(t / 0.075F);
  const float u = s / 0.24F + 0.5F * std::fmod(row, 2.0F);
  const float rough = fractal_noise(s * 40.0F, t * 40.0F, 4, seed);
  if (fraction(u) < 0.05F || fraction(t / 0.075F) < 0.15F)
    return scaled({0.62F, 0.64F, 0.66F}, 0.7F + 0.5F * rough);
  return scaled(base, 0.6F + 0.5F * cell(u, row, seed + 1) + 0.4F * rough);
}

Colour books(const Colour& base, float s, float t, std::uint32_t seed) {
  const float row = std::floor(t / 0.32F);
  const float y = t - row * 0.32F;
  if (y < 0.025F) return scaled(base, 0.9F + 0.5F * value_noise(s * 5.0F, t * 90.0F, seed));
  const float u = s / 0.04F;
  const float at = std::floor(u);
  // Edges between books wander by a third of a cell.
  const float edge = 0.33F * cell(at, row, seed);
  const float book = fraction(u) < edge ? at - 1.0F : at;
  const std::uint32_t h = hash(static_cast<int>(book), static_cast<int>(row), seed + 1);
  const float top = 0.05F + 0.09F * unit(h);
  if (y < top || unit(h * 13U) < 0.08F) return scaled(base, 0.25F);
  const float x = fraction(u) < edge ? fraction(u) + 1.0F : fraction(u);
  const float shade = 0.75F + 0.3F * fractal_noise(s * 50.0F, t * 12.0F, 2, h);
  const float band = top + 0.03F + 0.1F * unit(h * 17U);
  if (y > band && y < band + 0.035F)
    return scaled({0.8F, 0.85F, 0.85F}, text_marks(t, s, 0.012F, h));
  return scaled(any_colour(h), shade * (x - edge < 0.06F ? 0.5F : 1.0F));
}

Colour drawers(const Colour& base, float s, float t, std::uint32_t seed) {
  const float u = fraction(s / 0.45F), v = fraction(t / 0.33F);
  const float k = 0.82F + 0.2F * fractal_noise(s * 3.0F, t * 120.0F, 3, seed);
  if (u < 0.015F || v < 0.02F) return scaled(base, 0.3F);
  if (std::fabs(u - 0.5F) < 0.14F && std::fabs(v - 0.25F) < 0.03F) return scaled(base, 0.35F);
  if (std::fabs(u - 0.5F) < 0.10F && std::fabs(v - 0.5F) < 0.08F)
    return scaled({0.9F, 0.9F, 0.9F}, text_marks(s, t, 0.014F, seed));
  const bool sticker = std::fabs(u - 0.8F) < 0.09F && std::fabs(v - 0.7F) < 0.15F;
  const std::uint32_t h = hash(static_cast<int>(s / 0.45F), static_cast<int>(t / 0.33F), seed + 5);
  return sticker && unit(h) < 0.4F ? any_colour(h) : scaled(base, k);
}

Colour cardboard(const Colour& base, float s, float t, std::uint32_t seed) {
  const float k = 0.8F + 0.3F * fractal_noise(s * 8.0F, t * 60.0F, 4, seed);
  if (fraction(s / 0.31F + 0.3F) < 0.14F) return scaled({0.5F, 0.68F, 0.8F}, k);
  return scaled(base, k * text_marks(s, t, 0.035F, seed));
}

Colour tiles(const Colour& base, float s, float t, std::uint32_t seed) {
  if (fraction(s / 0.6F) < 0.03F || fraction(t / 0.6F) < 0.03F) return scaled(base, 0.65F);
  const float holes = fractal_noise(s * 70.0F, t * 70.0F, 2, seed) > 0.72F ? 0.7F : 1.0F;
  return scaled(base, (0.85F + 0.2F * fractal_noise(s * 3.0F, t * 3.0F, 4, seed)) * holes);
}

Colour fabric(const Colour& base, float s, float t, std::uint32_t seed) {
  const bool check = (cell(s * 25.0F, 0.5F, seed) > 0.5F) != (cell(0.5F, t * 25.0F, seed) > 0.5F);
  return scaled(base,
                (check ? 0.75F : 1.15F) * (0.6F + 0.7F * fractal_noise(s * 30, t * 30, 4, seed)));
}

}  // namespace

float value_noise(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const float u = x - fx, v = y - fy;
  const float a = u * u * (3.0F - 2.0F * u), b = v * v * (3.0F - 2.0F * v);
  const float low = unit(hash(ix, iy, seed)) * (1.0F - a) + unit(hash(ix + 1, iy, seed)) * a;
  const float high =
      unit(hash(ix, iy + 1, seed)) * (1.0F - a) + unit(hash(ix + 1, iy + 1, seed)) * a;
  return low * (1.0F - b) + high * b;
}

float fractal_noise(float x, float y, int octaves, std::uint32_t seed) {
  float sum = 0.0F, amplitude = 0.5F, total = 0.0F;
  for (int i = 0; i < octaves; ++i) {
    sum += amplitude * value_noise(x, y, seed + static_cast<std::uint32_t>(i) * 1013U);
    total += amplitude;
    amplitude *= 0.5F;
    x *= 2.0F;
    y *= 2.0F;
  }
  return sum / total;
}

Texture::Texture(const Material& material, int face, double width_m, double height_m)
    : material_(material),
      seed_(static_cast<std::uint32_t>(
          mix_bits(material.seed * 8 + static_cast<std::uint64_t>(face)) >> 32)),
      width_(static_cast<float>(width_m)),
      height_(static_cast<float>(height_m)) {
  if (material.kind != TextureKind::kPoster && material.kind != TextureKind::kScreen) return;
  Random random(material.seed, 1, static_cast<std::uint64_t>(face));
  const float shorter = std::min(width_, height_);
  for (int i = 0; i < 28; ++i) {
    PosterShape shape{};
    const double big = i < 6 ? 0.3 : 0.1;  // small ones on top of big ones
    shape.x = static_cast<float>(random.uniform()) * width_;
    shape.y = static_cast<float>(random.uniform()) * height_;
    shape.radius = shorter * static_cast<float>(random.uniform(0.3 * big, big));
    shape.angle_rad = static_cast<float>(random.uniform(0.0, M_PI));
    shape.aspect = static_cast<float>(random.uniform(0.4, 1.0));
    shape.round = random.uniform() < 0.4;
    for (float& c : shape.colour) c = static_cast<float>(random.uniform(0.05, 0.95));
    shapes_.push_back(shape);
  }
}

Colour Texture::poster(float s, float t) const {
  const float frame = 0.03F * std::min(width_, height_);
  if (s < frame || t < frame || s > width_ - frame || t > height_ - frame)
    return {0.12F, 0.12F, 0.14F};
  const float tone = 0.85F + 0.3F * fractal_noise(s * 12.0F, t * 12.0F, 4, seed_);
  for (auto shape = shapes_.rbegin(); shape != shapes_.rend(); ++shape) {
    const float dx = s - shape->x, dy = t - shape->y;
    if (dx * dx + dy * dy > 2.0F * shape->radius * shape->radius) continue;
    const float c = std::cos(shape->angle_rad), sn = std::sin(shape->angle_rad);
    const float x = c * dx + sn * dy, y = (c * dy - sn * dx) / shape->aspect;
    const bool inside = shape->round ? x * x + y * y < shape->radius * shape->radius
                                     : std::max(std::fabs(x), std::fabs(y)) < shape->radius * 0.9F;
    if (inside) return scaled(shape->colour, tone);
  }
  const float marks = material_.kind == TextureKind::kScreen
                          ? 1.0F + 3.0F * (1.0F - text_marks(s, t, 0.016F, seed_))
                          : text_marks(s, t, 0.02F, seed_);
  return scaled(material_.bgr, tone * marks);
}

Colour Texture::at(float s, float t) const {
  const Colour& base = material_.bgr;
  switch (material_.kind) {
    case TextureKind::kPlaster:
      return plaster(base, s, t, seed_);
    case TextureKind::kCarpet:
      return carpet(base, s, t, seed_);
    case TextureKind::kWood:
      return wood(base, s, t, seed_);
    case TextureKind::kBrick:
      return brick(base, s, t, seed_);
    case TextureKind::kPaper:
      return scaled(base, text_marks(s, t, 0.012F, seed_));
    case TextureKind::kPoster:
    case TextureKind::kScreen:
      return poster(s, t);
    case TextureKind::kBooks:
      return books(base, s, t, seed_);
    case TextureKind::kDrawers:
      return drawers(base, s, t, seed_);
    case TextureKind::kCardboard:
      return cardboard(base, s, t, seed_);
    case TextureKind::kTiles:
      return tiles(base, s, t, seed_);
    case TextureKind::kFabric:
      return fabric(base, s, t, seed_);
  }
  return base;
}

std::vector<std::string> texture_names() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  return names;
}

std::optional<TextureKind> texture_from(const std::string& name) {
  for (std::size_t i = 0; i < std::size(kKinds); ++i)
    if (name == kKinds[i].name) return static_cast<TextureKind>(i);
  return std::nullopt;
}

Colour default_colour(TextureKind kind) { return kKinds[static_cast<std::size_t>(kind)].bgr; }

}  // namespace fusion_slam
