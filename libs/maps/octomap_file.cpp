#include "libs/maps/octomap_file.hpp"

#include <sstream>

#include <octomap/octomap.h>

namespace fusion_slam {
namespace {

// OctoMap counts voxels from 32768 below the origin, in 16 bits. In integers, because a coordinate
// of a damaged tile index would not fit OctoMap's own conversion.
std::optional<octomap::OcTreeKey> octree_key(const TileKey& tile, const OctomapVoxel& voxel) {
  const std::int64_t indices[] = {std::int64_t{tile.x} * kOctomapTileVoxels + voxel.x,
                                  std::int64_t{tile.y} * kOctomapTileVoxels + voxel.y,
                                  std::int64_t{tile.z} * kOctomapTileVoxels + voxel.z};
  octomap::OcTreeKey key;
  for (unsigned axis = 0; axis < 3; ++axis) {
    if (indices[axis] < -32768 || indices[axis] > 32767) return std::nullopt;
    key[axis] = static_cast<octomap::key_type>(indices[axis] + 32768);
  }
  return key;
}

std::optional<octomap::OcTree> tree_of(const std::map<TileKey, Tile>& tiles, std::string* why) {
  std::optional<octomap::OcTree> tree;
  for (const auto& [key, tile] : tiles) {
    if (key.submap_id != 0 || tile.encoding != TileEncoding::kOctomap) continue;
    if (!tree) tree.emplace(tile.resolution_m);
    if (tile.resolution_m != tree->getResolution()) continue;
    const auto voxels = decode_octomap_tile(tile);
    if (!voxels) continue;
    for (const OctomapVoxel& voxel : *voxels) {
      if (const auto at = octree_key(key, voxel)) tree->setNodeValue(*at, voxel.log_odds, true);
    }
  }
  if (!tree || tree->size() == 0) return *why = "no voxel of the map is known", std::nullopt;
  tree->updateInnerOccupancy();
  return tree;
}

// Headers as OctoMap's writeBinary() and write() write them, which would also chat on the terminal.
std::string header(const char* kind, const octomap::OcTree& tree) {
  std::ostringstream out;
  out << "# Octomap OcTree " << kind
      << "\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid "
         "OcTree"
         "\nsize "
      << tree.size() << "\nres " << tree.getResolution() << "\ndata\n";
  return out.str();
}

}  // namespace

std::optional<std::string> octomap_bt_bytes(const std::map<TileKey, Tile>& tiles,
                                            std::string* why) {
  auto tree = tree_of(tiles, why);
  if (!tree) return std::nullopt;
  tree->toMaxLikelihood();  // a binary tree only knows occupied and free
  tree->prune();
  std::ostringstream out;
  tree->writeBinaryData(out);
  if (!out) return *why = "OctoMap could not write its tree", std::nullopt;
  return header("binary file", *tree) + out.str();
}

std::optional<std::string> octomap_ot_bytes(const std::map<TileKey, Tile>& tiles,
                                            std::string* why) {
  auto tree = tree_of(tiles, why);
  if (!tree) return std::nullopt;
  tree->prune();
  std::ostringstream out;
  tree->writeData(out);
  if (!out) return *why = "OctoMap could not write its tree", std::nullopt;
  return header("file", *tree) + out.str();
}

}  // namespace fusion_slam
