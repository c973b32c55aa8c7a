#include "libs/localization/visual_search.hpp"

#include <algorithm>

#include "libs/places/geometry_check.hpp"

namespace fusion_slam {

std::vector<VisualFix> find_views(const LocalizationMap& map, const FeatureSet& features) {
  std::vector<VisualFix> fixes;
  if (!map.camera() || map.views().empty()) return fixes;
  const GeometryConfig& geometry = map.config().geometry;
  const SE3& T_base_camera = map.robot().T_base_camera;
  for (const PlaceIndex::Place& place : map.index().like(features)) {
    const MapView& view = map.views().at(place.id);
    const GeometryCheck check = check_geometry(*map.camera(), view.features, features, geometry);
    if (check.n_inliers < geometry.min_inliers) continue;
    VisualFix fix;
    fix.keyframe_id = place.id;
    fix.T_map_base =
        view.T_map_base * T_base_camera * check.T_older_newer * T_base_camera.inverse();
    fix.covariance = geometry.optimism * in_base_axes(check.covariance, T_base_camera);
    fix.n_inliers = check.n_inliers;
    fixes.push_back(fix);
  }
  std::stable_sort(fixes.begin(), fixes.end(), [](const VisualFix& a, const VisualFix& b) {
    return a.n_inliers > b.n_inliers;
  });
  return fixes;
}

}  // namespace fusion_slam
