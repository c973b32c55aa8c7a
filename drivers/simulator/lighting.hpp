// Light of a world whose lamps and things never move.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "drivers/simulator/scene.hpp"

namespace fusion_slam {

constexpr float kWhiteGrey = 235.0F;  // grey value of full reflectance in unit light

struct Lighting {
  std::vector<Eigen::Vector3d> lamps_m;  // world; shine in all directions
  std::vector<double> lamp_scale;        // of each lamp's power; 1 where there is none
  double ambient = 0.50;                 // light from everywhere: walls scatter most of it
  double lamp_power = 1.7;               // at distance d: lamp_power / (1 + d^2)
  cv::Vec3f background_bgr{0, 0, 0};     // where there is nothing; 0 to 255
};

// Irradiance at p of a surface with this unit normal, 1 being what full reflectance turns into
// white: Lambert's cosine for every lamp that is not in the shadow, and the ambient light. p should
// lie a few millimetres above its surface.
double light_at(const Scene& scene, const Lighting& lighting, const Eigen::Vector3d& p,
                const Eigen::Vector3d& normal);

// Part of the ambient light that reaches p past what stands within reach_m of it (ambient
// occlusion, Zhukov et al. 1998), 0 to 1: n_rays rays spread with the cosine of their angle.
double open_sky(const Scene& scene, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                double reach_m, int n_rays);

}  // namespace fusion_slam
