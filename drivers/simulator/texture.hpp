// Colours of surfaces, computed: enough detail at every scale that features behave as on real
// images.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

using Colour = std::array<float, 3>;  // blue, green, red; 0 to 1 (reflectance)

// A thing on a poster or a screen, in fractions of the shorter side.
struct PosterShape {
  float x, y, radius, angle_rad, aspect;
  bool round;
  Colour colour;
};

// One face's pattern. const and thread-safe after construction.
class Texture {
 public:
  Texture(const Material& material, int face, double width_m, double height_m);
  // At s metres to the right and t metres down from the upper left corner.
  Colour at(float s_m, float t_m) const;

 private:
  Colour poster(float s, float t) const;
  Material material_;
  std::uint32_t seed_;
  float width_;
  float height_;
  std::vector<PosterShape> shapes_;
};

// Lattice noise in [0, 1) with smooth interpolation (value noise), and the sum of its octaves with
// halving amplitude and doubling frequency, again in [0, 1).
float value_noise(float x, float y, std::uint32_t seed);
float fractal_noise(float x, float y, int octaves, std::uint32_t seed);

std::vector<std::string> texture_names();
std::optional<TextureKind> texture_from(const std::string& name);
Colour default_colour(TextureKind kind);

}  // namespace fusion_slam
