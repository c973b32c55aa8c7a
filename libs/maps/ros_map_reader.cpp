#include "libs/maps/ros_map_reader.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include <opencv2/imgcodecs.hpp>
#include <yaml-cpp/yaml.h>

namespace fusion_slam {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& reason) {
  throw std::runtime_error(file.string() + ": " + reason);
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file) {
    try {
      root_ = YAML::LoadFile(file.string());
    } catch (const YAML::BadFile&) {
      fail(file, "can't be read; a map is given by its .yaml file");
    } catch (const YAML::Exception& error) {
      fail(file, "line " + std::to_string(error.mark.line + 1) + ": not valid YAML: " + error.msg);
    }
    if (!root_.IsMap()) fail(file, "is no map.yaml: expected keys image, resolution, origin");
  }

  YAML::Node child(const std::string& key) const {
    if (!root_[key]) fail(file_, "the key '" + key + "' is missing");
    return root_[key];
  }
  double number(const YAML::Node& node, const std::string& key) const {
    double value = NAN;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value))
      fail(file_, "'" + key + "' must be a number");
    return value;
  }
  double number(const std::string& key) const { return number(child(key), key); }
  double number_or(const std::string& key, double otherwise) const {
    return root_[key] ? number(key) : otherwise;
  }
  std::string text_or(const std::string& key, const std::string& otherwise) const {
    if (!root_[key]) return otherwise;
    if (!root_[key].IsScalar()) fail(file_, "'" + key + "' must be a word");
    return root_[key].Scalar();
  }

 private:
  std::filesystem::path file_;
  YAML::Node root_;
};

}  // namespace

GreyRaster read_grey(const std::filesystem::path& file) {
  cv::Mat picture;
  try {
    if (std::filesystem::is_regular_file(file))
      picture = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
    picture.release();
  }
  if (picture.empty()) fail(file, "is no picture that can be read (PGM or PNG); check the path");
  GreyRaster grey;
  grey.width = picture.cols;
  grey.height = picture.rows;
  for (int row = picture.rows - 1; row >= 0; --row)
    grey.values.insert(grey.values.end(), picture.ptr(row), picture.ptr(row) + picture.cols);
  return grey;
}

MapRaster read_ros_map(const std::filesystem::path& yaml_file) {
  const Reader reader(yaml_file);
  const std::string mode = reader.text_or("mode", "trinary");
  if (mode != "trinary") fail(yaml_file, "mode '" + mode + "': only trinary maps can be read");
  MapRaster raster;
  raster.resolution_m = reader.number("resolution");
  if (!(raster.resolution_m > 0.0)) fail(yaml_file, "'resolution' must be above 0");
  const YAML::Node origin = reader.child("origin");
  if (!origin.IsSequence() || origin.size() != 3) fail(yaml_file, "'origin' must be [x, y, yaw]");
  raster.origin_x_m = reader.number(origin[0], "origin");
  raster.origin_y_m = reader.number(origin[1], "origin");
  if (reader.number(origin[2], "origin") != 0.0)
    fail(yaml_file, "the map is turned (yaw of 'origin'); save it with yaw 0");
  const double occupied_above = reader.number_or("occupied_thresh", 0.65);
  const double free_below = reader.number_or("free_thresh", 0.25);
  const bool negate = reader.number_or("negate", 0.0) != 0.0;

  if (reader.text_or("image", "").empty()) fail(yaml_file, "the key 'image' is missing");
  const std::filesystem::path image = reader.text_or("image", "");
  const GreyRaster grey = read_grey(image.is_absolute() ? image : yaml_file.parent_path() / image);
  raster.width = grey.width;
  raster.height = grey.height;
  raster.provenance.assign(grey.values.size(), 0);
  raster.probability.reserve(grey.values.size());
  for (const std::uint8_t value : grey.values) {
    const double p = (negate ? value : 255 - value) / 255.0;
    raster.probability.push_back(p > occupied_above ? cell_from_probability(1.0)
                                 : p < free_below   ? cell_from_probability(0.0)
                                                    : kUnknownCell);
  }
  return raster;
}

}  // namespace fusion_slam
