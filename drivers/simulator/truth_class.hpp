// What a model of somebody else's world is to the true map, by its name.
#pragma once

#include <string>

#include "libs/evaluation/map_class.hpp"

namespace fusion_slam {

// "aws_robomaker_residential_ChairD_01" -> kChair, "*Table*", "*Desk*" -> kTable, "*Wall*",
// "*Door*", "*Window*", pictures and curtains on walls -> kWall; whatever isn't known is kOther.
// Upper and lower case are alike.
ObstacleClass class_of_model(const std::string& name);

}  // namespace fusion_slam
