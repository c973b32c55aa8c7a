#include "drivers/simulator/truth_class.hpp"

#include <algorithm>
#include <cctype>

namespace fusion_slam {
namespace {

struct Pattern {
  const char* part;  // in lower case
  ObstacleClass obstacle;
};

// The first that occurs in the name decides: "deskportrait" is a picture on a desk, no desk.
constexpr Pattern kPatterns[] = {
    {"portrait", ObstacleClass::kWall},  {"tableware", ObstacleClass::kOther},
    {"tablet", ObstacleClass::kOther},   {"tablelamp", ObstacleClass::kOther},
    {"chair", ObstacleClass::kChair},    {"stool", ObstacleClass::kChair},
    {"table", ObstacleClass::kTable},    {"desk", ObstacleClass::kTable},
    {"wall", ObstacleClass::kWall},      {"door", ObstacleClass::kWall},
    {"window", ObstacleClass::kWall},    {"curtain", ObstacleClass::kWall},
    {"column", ObstacleClass::kWall},    {"pillar", ObstacleClass::kWall},
    {"lowbox", ObstacleClass::kLowBox},  {"low_box", ObstacleClass::kLowBox},
    {"dumbbell", ObstacleClass::kLowBox}};

}  // namespace

ObstacleClass class_of_model(const std::string& name) {
  std::string low = name;
  std::transform(low.begin(), low.end(), low.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const Pattern& pattern : kPatterns)
    if (low.find(pattern.part) != std::string::npos) return pattern.obstacle;
  return ObstacleClass::kOther;
}

}  // namespace fusion_slam
