// From a turn with uneven angles to the even grid of planar_lidar_t. Pure.
//
// Beam i points at -i * 360 degrees / n (the device turns clockwise, our angles grow
// counter-clockwise: radstep is negative, so that beams stay in the order of time) and counts as
// measured at utime + i * beam_period. n is the time of the turn divided by beam_period: it follows
// the motor.
//
// What is lost: (1) angles move by up to half a beam; between two returns of one surface the range
// is interpolated there, at an edge the nearer return is taken unchanged. (2) Where the device
// measures more often than beam_period, returns between two beams are not used. (3) A near object,
// moved by parallax, gets the time of its angle and not its own: up to 25 degrees, 10 ms at 7 turns
// a second, 5 mm at 0.5 m/s. (4) One beam for one angle: where parallax makes a near and a far
// object overlap, the order by angle decides.
#pragma once

#include "drivers/rplidar/scan_parser.hpp"
#include "libs/robot/robot_model.hpp"

namespace fusion_slam {

constexpr std::size_t kFewestBeams = 8;
constexpr std::size_t kMostBeams = 7'200;  // keeps LIDAR below 60 KB with intensities

// beam_period_s > 0: what ROBOT_MODEL says. `revolution` has at least one measurement. Ranges of 0
// stay: no return; a beam with nothing measured within 1.5 beams is 0 too. Intensities (quality, 0
// to 63) only when the turn has them.
LaserScan to_laser_scan(const Revolution& revolution, double beam_period_s);

}  // namespace fusion_slam
