#include "libs/octree/voxel_pack.hpp"

#include <algorithm>

namespace fusion_slam {
namespace {

constexpr std::size_t kMaskBytes = kOctomapTileVolume / 8;
constexpr int kBlocksPerCube = kOctomapTileVoxels / kBlockVoxels;

int floor_half(int v) { return v >> 1; }  // blocks to cubes; rounds towards minus infinity
static_assert(kBlocksPerCube == 2);

}  // namespace

PackedBytes pack_cells(const VoxelCells& cells) {
  PackedBytes raw(kMaskBytes, 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i] == kUnknownVoxel) continue;
    raw[i / 8] = static_cast<std::uint8_t>(raw[i / 8] | (1U << (i % 8)));
    raw.push_back(static_cast<std::uint8_t>(cells[i]));
  }
  if (raw.size() == kMaskBytes) return {};
  return deflate_bytes(raw);
}

bool unpack_cells(const PackedBytes& bytes, VoxelCells* cells) {
  cells->fill(kUnknownVoxel);
  if (bytes.empty()) return true;
  const auto raw = inflate_bytes(bytes.data(), bytes.size(), kMaskBytes + kOctomapTileVolume);
  if (!raw || raw->size() < kMaskBytes) return false;
  std::size_t next = kMaskBytes;
  for (std::size_t byte = 0; byte < kMaskBytes; ++byte) {
    const unsigned mask = (*raw)[byte];
    if (mask == 0) continue;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((mask >> bit & 1U) == 0) continue;
      if (next == raw->size()) return false;
      const auto steps = static_cast<std::int8_t>((*raw)[next++]);
      if (steps == kUnknownVoxel) return false;
      (*cells)[8 * byte + bit] = steps;
    }
  }
  return next == raw->size();
}

CubeIndex cube_of(const BlockIndex& block) {
  return {floor_half(block.x), floor_half(block.y), floor_half(block.z)};
}

VoxelCells& cube_at(VoxelCubes* cubes, const CubeIndex& index) {
  auto& cube = (*cubes)[index];
  if (!cube) {
    cube = std::make_unique<VoxelCells>();
    cube->fill(kUnknownVoxel);
  }
  return *cube;
}

void copy_block(const BlockIndex& index, const VoxelBlock& block, int low, int high,
                VoxelCubes* cubes) {
  VoxelCells& cube = cube_at(cubes, cube_of(index));
  const int x0 = (index.x & 1) * kBlockVoxels;
  const int y0 = (index.y & 1) * kBlockVoxels;
  const int z0 = (index.z & 1) * kBlockVoxels;
  std::size_t from = 0;
  for (int z = 0; z < kBlockVoxels; ++z)
    for (int y = 0; y < kBlockVoxels; ++y) {
      std::size_t to = voxel_index(x0, y0 + y, z0 + z);
      for (int x = 0; x < kBlockVoxels; ++x, ++from, ++to) {
        const int sum = block[from];
        cube[to] = sum == kUnknownLogOdds ? kUnknownVoxel
                                          : static_cast<std::int8_t>(std::clamp(sum, low, high));
      }
    }
}

PackedCubes pack_cubes(const VoxelCubes& cubes) {
  PackedCubes packed;
  for (const auto& [index, cells] : cubes) {
    PackedBytes bytes = pack_cells(*cells);
    if (bytes.empty()) continue;
    bytes.shrink_to_fit();
    packed.emplace(index, std::move(bytes));
  }
  return packed;
}

VoxelCubes unpack_cubes(const PackedCubes& packed) {
  VoxelCubes cubes;
  for (const auto& [index, bytes] : packed) unpack_cells(bytes, &cube_at(&cubes, index));
  return cubes;
}

std::size_t size_bytes(const PackedCubes& packed) {
  std::size_t sum = 0;
  for (const auto& [index, bytes] : packed) sum += bytes.size();
  return sum;
}

}  // namespace fusion_slam
