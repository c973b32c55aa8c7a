// What kind of obstacle stands in a cell of a true map: recall is told apart by it, because each
// kind is hard for another sensor (a LiDAR looks under table tops and over low boxes).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace fusion_slam {

// Values of a class image. Of two things in one cell the one first in this order counts: the one
// that is seen most easily, so that a hard class is never credited with an easy one's cells.
enum class ObstacleClass : std::uint8_t {
  kNone = 0,
  kWall = 1,
  kOther = 2,  // furniture and whatever else
  kChair = 3,
  kTable = 4,
  kLowBox = 5,  // lower than the LiDAR's plane
};

constexpr std::size_t kObstacleClasses = 6;  // with kNone

constexpr std::array<std::string_view, kObstacleClasses> kObstacleClassNames = {
    "none", "wall", "other", "chair", "table", "low_box"};

constexpr std::string_view name_of(ObstacleClass obstacle) {
  return kObstacleClassNames[static_cast<std::size_t>(obstacle)];
}

constexpr std::optional<ObstacleClass> obstacle_class_from(std::string_view name) {
  for (std::size_t i = 1; i < kObstacleClasses; ++i)
    if (kObstacleClassNames[i] == name) return static_cast<ObstacleClass>(i);
  return std::nullopt;
}

}  // namespace fusion_slam
