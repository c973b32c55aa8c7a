#include "drivers/simulator/sensor_noise.hpp"

#include <functional>
#include <stdexcept>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {
namespace {

struct Switch {
  Effect effect;
  std::function<bool&(SensorNoise&)> flag;
};

const std::vector<Switch>& switches() {
  using N = SensorNoise;
  static const std::vector<Switch> kSwitches = {
      {{"colour-noise", "random grey values"},
       [](N& n) -> bool& { return n.camera.with_colour_noise; }},
      {{"photon-noise", "bright pixels are noisier than dark ones"},
       [](N& n) -> bool& { return n.camera.with_photon_noise; }},
      {{"exposure", "automatic exposure follows the scene, late"},
       [](N& n) -> bool& { return n.camera.with_exposure; }},
      {{"motion-blur", "the shutter is open for a time"},
       [](N& n) -> bool& { return n.camera.with_motion_blur; }},
      {{"rolling-shutter", "rows are exposed one after the other", false},
       [](N& n) -> bool& { return n.camera.with_rolling_shutter; }},
      {{"depth-noise", "depth noise that grows with the square of distance"},
       [](N& n) -> bool& { return n.camera.with_depth_noise; }},
      {{"depth-correlation", "neighbouring depth pixels err alike"},
       [](N& n) -> bool& { return n.camera.with_depth_correlation; }},
      {{"depth-steps", "disparity comes in steps"},
       [](N& n) -> bool& { return n.camera.with_depth_steps; }},
      {{"depth-edges", "depth is missing on edges"},
       [](N& n) -> bool& { return n.camera.with_depth_edges; }},
      {{"depth-shadow", "depth is missing where the projector does not shine"},
       [](N& n) -> bool& { return n.camera.with_depth_shadow; }},
      {{"depth-dropouts", "depth is missing on glancing and dark surfaces"},
       [](N& n) -> bool& { return n.camera.with_depth_dropouts; }},
      {{"depth-delay", "depth is taken a little later than colour"},
       [](N& n) -> bool& { return n.camera.with_depth_delay; }},
      {{"jitter", "time stamps of camera and LiDAR jitter"},
       [](N& n) -> bool& { return n.stamps.with_jitter; }},
      {{"lidar-noise", "range noise"}, [](N& n) -> bool& { return n.lidar.with_noise; }},
      {{"lidar-dropouts", "beams are lost on dark, far and glancing surfaces"},
       [](N& n) -> bool& { return n.lidar.with_dropouts; }},
      {{"lidar-sweep", "beams are spread over the rotation while the robot moves"},
       [](N& n) -> bool& { return n.lidar.with_sweep; }},
      {{"wheel-scale", "wheels are not of the size they are taken for"},
       [](N& n) -> bool& { return n.wheels.with_scale; }},
      {{"slip", "wheels slip"}, [](N& n) -> bool& { return n.wheels.with_slip; }},
  };
  return kSwitches;
}

const Switch& find_switch(const std::string& name) {
  std::vector<std::string> names{"all"};
  for (const Switch& s : switches()) {
    if (s.effect.name == name) return s;
    names.push_back(s.effect.name);
  }
  throw std::invalid_argument("there is no effect '" + name + "'; the nearest is '" +
                              nearest(name, names) + "'");
}

struct Parameter {
  const char* name;
  double low, high;
  std::function<double&(SensorNoise&)> value;
};

#define FS_PARAMETER(group, member, low, high)                                    \
  {                                                                               \
#member, low, high, [](SensorNoise & n) -> double& { return n.group.member; } \
  }

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> kParameters = {
      FS_PARAMETER(camera, colour_sigma, 0.0, 100.0),
      FS_PARAMETER(camera, photon_share, 0.0, 1.0),
      FS_PARAMETER(camera, exposure, 0.05, 20.0),
      FS_PARAMETER(camera, exposure_target, 1.0, 254.0),
      FS_PARAMETER(camera, exposure_time_constant_s, 0.001, 60.0),
      FS_PARAMETER(camera, exposure_min, 0.05, 1.0),
      FS_PARAMETER(camera, exposure_max, 1.0, 20.0),
      FS_PARAMETER(camera, shutter_s, 0.0, 0.1),
      FS_PARAMETER(camera, rolling_readout_s, 0.0, 0.1),
      FS_PARAMETER(camera, baseline_m, 0.01, 1.0),
      FS_PARAMETER(camera, disparity_step_px, 0.001, 2.0),
      FS_PARAMETER(camera, depth_sigma_at_0_4_m, 0.0, 0.1),
      FS_PARAMETER(camera, depth_sigma_per_m, 0.0, 0.1),
      FS_PARAMETER(camera, correlated_share, 0.0, 1.0),
      FS_PARAMETER(camera, edge_drop_fraction, 0.0, 1.0),
      FS_PARAMETER(camera, edge_jump, 0.001, 1.0),
      FS_PARAMETER(camera, grazing_cosine, 0.0, 1.0),
      FS_PARAMETER(camera, dark_signal, 0.0, 100.0),
      FS_PARAMETER(camera, depth_delay_s, -0.05, 0.05),
      FS_PARAMETER(lidar, range_fraction, 0.0, 0.2),
      FS_PARAMETER(lidar, sure_cosine, 0.0, 1.0),
      FS_PARAMETER(lidar, lost_cosine, 0.0, 1.0),
      FS_PARAMETER(lidar, white_reflectance, 0.01, 1.0),
      FS_PARAMETER(lidar, fade, 0.01, 1.0),
      FS_PARAMETER(wheels, wheel_base_m, 0.05, 2.0),
      FS_PARAMETER(wheels, scale_sigma, 0.0, 0.2),
      FS_PARAMETER(wheels, slip_sigma_per_sqrt_m, 0.0, 0.2),
      FS_PARAMETER(stamps, camera_jitter_s, 0.0, 0.02),
      FS_PARAMETER(stamps, depth_jitter_s, 0.0, 0.02),
      FS_PARAMETER(stamps, lidar_jitter_s, 0.0, 0.02),
  };
  return kParameters;
}

#undef FS_PARAMETER

const Parameter& find_parameter(const std::string& name) {
  for (const Parameter& p : parameters())
    if (name == p.name) return p;
  throw std::invalid_argument("there is no noise value '" + name + "'; the nearest is '" +
                              nearest(name, parameter_names()) + "'");
}

}  // namespace

const std::vector<Effect>& effects() {
  static const std::vector<Effect> kEffects = [] {
    std::vector<Effect> all;
    for (const Switch& s : switches()) all.push_back(s.effect);
    return all;
  }();
  return kEffects;
}

void set_effect(const std::string& name, bool on, SensorNoise* noise) {
  if (name == "all") {
    for (const Switch& s : switches()) s.flag(*noise) = on && s.effect.on_by_default;
    return;
  }
  find_switch(name).flag(*noise) = on;
}

bool effect_is_on(const std::string& name, const SensorNoise& noise) {
  SensorNoise copy = noise;
  return find_switch(name).flag(copy);
}

void set_parameter(const std::string& name, double value, SensorNoise* noise) {
  const Parameter& p = find_parameter(name);
  if (!(value >= p.low && value <= p.high))
    throw std::invalid_argument("noise value '" + name + "' must be from " + std::to_string(p.low) +
                                " to " + std::to_string(p.high));
  p.value(*noise) = value;
}

double parameter(const std::string& name, const SensorNoise& noise) {
  SensorNoise copy = noise;
  return find_parameter(name).value(copy);
}

std::vector<std::string> parameter_names() {
  std::vector<std::string> names;
  for (const Parameter& p : parameters()) names.emplace_back(p.name);
  return names;
}

}  // namespace fusion_slam
