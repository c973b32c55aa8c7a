#include "libs/maps/octomap_file.hpp"

#include <sstream>

#include <octomap/octomap.h>

namespace fusion_slam {

std::optional<std::string> octomap_bt_bytes(const std::map<TileKey, Tile>& tiles,
                                            std::string* why) {
  std::optional<octomap::OcTree> tree;
  for (const auto& [key, tile] : tiles) {
    if (key.submap_id != 0 || tile.encoding != TileEncoding::kOctomap) continue;
    if (!tree) tree.emplace(tile.resolution_m);
    if (tile.resolution_m != tree->getResolution()) continue;
    const auto voxels = decode_octomap_tile(tile);
    if (!voxels) continue;
    for (const OctomapVoxel& voxel : *voxels) {
      const Eigen::Vector3d p = voxel_centre_m(tile, voxel);
      octomap::OcTreeKey at;
      if (tree->coordToKeyChecked(p.x(), p.y(), p.z(), at))
        tree->setNodeValue(at, voxel.log_odds, true);
    }
  }
  if (!tree || tree->size() == 0) return *why = "no voxel of the map is known", std::nullopt;
  tree->updateInnerOccupancy();
  tree->toMaxLikelihood();  // a binary tree only knows occupied and free
  tree->prune();
  // The header as OctoMap's writeBinary() writes it, which would also chat on the terminal.
  std::ostringstream out;
  out << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first "
         "line as it is!)\n#\nid OcTree\nsize "
      << tree->size() << "\nres " << tree->getResolution() << "\ndata\n";
  tree->writeBinaryData(out);
  if (!out) return *why = "OctoMap could not write its tree", std::nullopt;
  return out.str();
}

}  // namespace fusion_slam
