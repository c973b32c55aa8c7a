#include "libs/map_directory/manifest.hpp"

#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <vector>

#include <nlohmann/json.hpp>
#include <zlib.h>

namespace fusion_slam {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKind = "fusion-slam map";

std::string hex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "%08x", value);
  return text;
}

Json to_json(const MapSummary& s) {
  return {{"robot", s.robot},
          {"has_lidar", s.has_lidar},
          {"has_camera", s.has_camera},
          {"resolution_m", s.resolution_m},
          {"sessions", s.sessions},
          {"keyframes", s.keyframes},
          {"images", s.images},
          {"lidar_nodes", s.lidar_nodes},
          {"submaps", s.submaps},
          {"loops", s.loops},
          {"first_utime_us", s.first_utime_us},
          {"last_utime_us", s.last_utime_us},
          {"path_length_m", s.path_length_m},
          {"free_area_m2", s.free_area_m2},
          {"grid", s.grid}};
}

MapSummary summary_from(const Json& json) {
  MapSummary s;
  json.at("robot").get_to(s.robot);
  json.at("has_lidar").get_to(s.has_lidar);
  json.at("has_camera").get_to(s.has_camera);
  json.at("resolution_m").get_to(s.resolution_m);
  json.at("sessions").get_to(s.sessions);
  json.at("keyframes").get_to(s.keyframes);
  json.at("images").get_to(s.images);
  json.at("lidar_nodes").get_to(s.lidar_nodes);
  json.at("submaps").get_to(s.submaps);
  json.at("loops").get_to(s.loops);
  json.at("first_utime_us").get_to(s.first_utime_us);
  json.at("last_utime_us").get_to(s.last_utime_us);
  json.at("path_length_m").get_to(s.path_length_m);
  json.at("free_area_m2").get_to(s.free_area_m2);
  json.at("grid").get_to(s.grid);
  return s;
}

}  // namespace

std::string to_json(const Manifest& manifest) {
  Json files = Json::object();
  for (const auto& [name, file] : manifest.files)
    files[name] = {{"size_bytes", file.size_bytes}, {"crc32", hex(file.crc32)}};
  const Json json = {{"kind", kKind},
                     {"format", manifest.format},
                     {"summary", to_json(manifest.summary)},
                     {"files", files}};
  return json.dump(2) + "\n";
}

Manifest parse_manifest(const std::string& text, const std::filesystem::path& directory) {
  const std::string where = (directory / kManifestName).string();
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception&) {
    throw std::runtime_error(where + ": is damaged (not valid JSON): the map was not copied whole");
  }
  if (!json.is_object() || json.value("kind", Json()) != kKind)
    throw std::runtime_error(where + ": is not the manifest of a Fusion-SLAM map");
  Manifest manifest;
  try {
    json.at("format").get_to(manifest.format);
    if (manifest.format > kMapFormat)
      throw std::runtime_error(directory.string() + ": is a map of format " +
                               std::to_string(manifest.format) + "; this program knows up to " +
                               std::to_string(kMapFormat) +
                               ": use the Fusion-SLAM that wrote it, or a newer one");
    if (manifest.format < 1) throw std::runtime_error(where + ": format must be 1 or more");
    manifest.summary = summary_from(json.at("summary"));
    for (const auto& [name, file] : json.at("files").items()) {
      if (name.empty() || name.find('/') != std::string::npos || name[0] == '.')
        throw std::runtime_error(std::string(where).append(": `").append(name).append(
            "` is no name of a file of a map"));
      MapFile entry;
      file.at("size_bytes").get_to(entry.size_bytes);
      entry.crc32 =
          static_cast<std::uint32_t>(std::stoul(file.at("crc32").get<std::string>(), nullptr, 16));
      manifest.files[name] = entry;
    }
  } catch (const Json::exception& error) {
    throw std::runtime_error(where + ": is damaged: " + error.what());
  } catch (const std::logic_error&) {
    throw std::runtime_error(where + ": is damaged: a checksum is no number");
  }
  if (manifest.files.count(kJournalName) == 0)
    throw std::runtime_error(where + ": names no " + kJournalName);
  return manifest;
}

MapFile measure_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(1 << 20);
  MapFile measured;
  uLong crc = ::crc32(0, nullptr, 0);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    measured.size_bytes += in.gcount();
    crc =
        ::crc32(crc, reinterpret_cast<const Bytef*>(block.data()), static_cast<uInt>(in.gcount()));
  }
  if (!in.eof()) throw std::runtime_error(file.string() + ": can't be read");
  measured.crc32 = static_cast<std::uint32_t>(crc);
  return measured;
}

}  // namespace fusion_slam
