// link: fs_dense_mapper
// The dense map, as it stands in its mapper's journal. What can be read can be gone on with, and is
// written as much again.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "services/dense_mapper/dense_mapper.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::SavedMap map;
  if (!fusion_slam::read_saved(data, size, &map)) return 0;
  fusion_slam::RobotModel robot;
  robot.map_resolution_m = 0.05;
  if (map.values.resolution_m != robot.map_resolution_m) return 0;
  const fusion_slam::CameraModel camera;
  fusion_slam::DenseMapper mapper(camera, robot, {});
  if (!mapper.restore(std::move(map))) std::abort();
  mapper.follow_at_most(8);
  mapper.update(false);
  fusion_slam::SavedMap again;
  mapper.write_all([&](const fusion_slam::SavedBytes& bytes) {
    if (!fusion_slam::read_saved(bytes.data(), bytes.size(), &again)) std::abort();
  });
  if (again.submaps.size() != mapper.submaps()) std::abort();
  mapper.update(true);
  return 0;
}
