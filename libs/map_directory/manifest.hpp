// manifest.json of a map directory: which format, what is in it, and the checksum of every file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace fusion_slam {

constexpr int kMapFormat = 1;  // grows when a reader of the number before could not read the map
constexpr const char* kManifestName = "manifest.json";
constexpr const char* kJournalName = "journal.lcmlog";

struct MapFile {
  std::int64_t size_bytes = 0;
  std::uint32_t crc32 = 0;  // zlib's
};

struct MapSummary {
  std::string robot;
  bool has_lidar = false;
  bool has_camera = false;
  double resolution_m = 0.0;
  std::int64_t sessions = 1;  // recordings joined in it
  std::int64_t keyframes = 0;
  std::int64_t images = 0;  // keyframes whose image is in the journal
  std::int64_t lidar_nodes = 0;
  std::int64_t submaps = 0;
  std::int64_t loops = 0;
  std::int64_t first_utime_us = 0;  // of the nodes
  std::int64_t last_utime_us = 0;
  double path_length_m = 0.0;
  double free_area_m2 = 0.0;
  std::string grid;  // channel that map.pgm was made of; empty: no grid
  // Not in manifest.json: messages the session lacks, by channel (gaps in its sequence numbers).
  std::map<std::string, std::int64_t> lost;
};

struct Manifest {
  int format = kMapFormat;
  MapSummary summary;
  std::map<std::string, MapFile> files;  // by name; all but the manifest itself
};

std::string to_json(const Manifest& manifest);

// Throws std::runtime_error, for people, naming `directory`: no manifest of a map, a damaged one,
// one of a newer format.
Manifest parse_manifest(const std::string& text, const std::filesystem::path& directory);

// Size and checksum of a file. Throws std::runtime_error when it can't be read.
MapFile measure_file(const std::filesystem::path& file);

}  // namespace fusion_slam
