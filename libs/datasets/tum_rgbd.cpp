#include <algorithm>
#include <cstdlib>
#include <set>
#include <utility>

#include "libs/datasets/rgbd_dataset.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kMaxDifferenceUs = 20'000;

struct ListedImage {
  std::int64_t utime_us = 0;
  std::string file;
};

struct ImageList {
  std::vector<ListedImage> images;  // by time
  std::string comments;
};

ImageList read_list(const std::filesystem::path& path, Skipped* skipped) {
  const std::string text = read_text_file(path);
  const std::string name = path.filename().string();
  ImageList list;
  std::string_view rest = text;
  std::string_view line;
  for (std::int64_t number = 1; next_line(&rest, &line); ++number) {
    const std::string_view whole = line;
    const std::string_view stamp = next_word(&line);
    if (stamp.empty()) continue;
    if (stamp.front() == '#') {
      list.comments += std::string(whole) + " ";
      continue;
    }
    const auto utime_us = parse_seconds_us(stamp);
    const std::string_view file = next_word(&line);
    if (!utime_us || file.empty())
      skipped->add(number, name + ": not \"seconds file\"");
    else
      list.images.push_back({*utime_us, std::string(file)});
  }
  std::stable_sort(list.images.begin(), list.images.end(),
                   [](const auto& a, const auto& b) { return a.utime_us < b.utime_us; });
  return list;
}

// Also false for a name that no file can have (too long, say).
bool is_there(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::exists(file, ignored);
}

struct Pair {
  std::int64_t difference_us;
  std::size_t colour;
  std::size_t depth;
  bool operator<(const Pair& o) const {
    return std::tie(difference_us, colour, depth) < std::tie(o.difference_us, o.colour, o.depth);
  }
};

// Nearest in time first, each image once.
std::vector<Pair> associate(const std::vector<ListedImage>& colour,
                            const std::vector<ListedImage>& depth) {
  std::vector<Pair> candidates;
  std::size_t first = 0;
  for (std::size_t c = 0; c < colour.size(); ++c) {
    while (first < depth.size() && depth[first].utime_us < colour[c].utime_us - kMaxDifferenceUs)
      ++first;
    for (std::size_t d = first;
         d < depth.size() && depth[d].utime_us <= colour[c].utime_us + kMaxDifferenceUs; ++d)
      candidates.push_back({std::abs(depth[d].utime_us - colour[c].utime_us), c, d});
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> colour_used(colour.size());
  std::vector<bool> depth_used(depth.size());
  std::vector<Pair> pairs;
  for (const Pair& pair : candidates) {
    if (colour_used[pair.colour] || depth_used[pair.depth]) continue;
    colour_used[pair.colour] = depth_used[pair.depth] = true;
    pairs.push_back(pair);
  }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& a, const Pair& b) { return a.colour < b.colour; });
  return pairs;
}

// What `fusion-slam export tum` says in rgb.txt: "# camera: fx 570 fy 570 cx 319.5 cy 239.5 k1 0 k2
// 0 p1 0 p2 0 k3 0 width 640 height 480". False when it isn't all there.
bool stated_intrinsics(const std::string& comments, CameraModel* camera) {
  const std::size_t at = comments.find("# camera:");
  if (at == std::string::npos) return false;
  std::string_view rest = std::string_view(comments).substr(at + 9);
  auto& k = camera->distortion;
  double width = 0.0, height = 0.0;
  const std::pair<const char*, double*> values[] = {
      {"fx", &camera->fx_px}, {"fy", &camera->fy_px}, {"cx", &camera->cx_px},
      {"cy", &camera->cy_px}, {"k1", &k[0]},          {"k2", &k[1]},
      {"p1", &k[2]},          {"p2", &k[3]},          {"k3", &k[4]},
      {"width", &width},      {"height", &height}};
  for (const auto& [name, target] : values) {
    if (next_word(&rest) != name) return false;
    const auto value = parse_number(next_word(&rest));
    if (!value) return false;
    *target = *value;
  }
  const auto side = [](double px) { return px >= 1.0 && px <= kMaxImageSide; };
  if (!side(width) || !side(height)) return false;
  camera->width_px = static_cast<int>(width);
  camera->height_px = static_cast<int>(height);
  return camera->fx_px > 0.0 && camera->fy_px > 0.0;
}

// Published with the data set (Sturm et al. 2012, "Intrinsic camera calibration of the Kinect").
// Its depth images are registered to colour and already scaled.
CameraModel intrinsics(const std::string& hint, std::string* name) {
  CameraModel camera;
  if (stated_intrinsics(hint, &camera)) {
    *name = "as rgb.txt says";
    return camera;
  }
  camera = {};
  const auto set = [&](const char* n, double fx, double fy, double cx, double cy,
                       std::array<double, 5> distortion) {
    *name = n;
    camera.fx_px = fx;
    camera.fy_px = fy;
    camera.cx_px = cx;
    camera.cy_px = cy;
    camera.distortion = distortion;
  };
  if (hint.find("freiburg1") != std::string::npos)
    set("TUM freiburg1", 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633});
  else if (hint.find("freiburg2") != std::string::npos)
    set("TUM freiburg2", 520.9, 521.0, 325.1, 249.7, {0.2312, -0.7849, -0.0033, -0.0001, 0.9172});
  else if (hint.find("freiburg3") != std::string::npos)
    set("TUM freiburg3", 535.4, 539.2, 320.1, 247.6, {});
  else
    set("ROS default of the Kinect", 525.0, 525.0, 319.5, 239.5, {});
  return camera;
}

}  // namespace

RgbdDataset open_tum_rgbd(const std::filesystem::path& directory) {
  if (!std::filesystem::is_directory(directory))
    throw DatasetError(directory.string() + ": is not a directory; give the one with rgb.txt");
  RgbdDataset dataset;
  const ImageList colour = read_list(directory / "rgb.txt", &dataset.skipped);
  const ImageList depth = read_list(directory / "depth.txt", &dataset.skipped);
  const std::string folder = std::filesystem::absolute(directory).lexically_normal().string();
  dataset.camera = intrinsics(colour.comments + " " + folder, &dataset.camera_name);
  dataset.depth_units_per_mm = 5.0;
  const std::vector<Pair> pairs = associate(colour.images, depth.images);
  const auto unpaired = static_cast<std::int64_t>(colour.images.size() - pairs.size());
  for (std::int64_t i = 0; i < unpaired; ++i)
    dataset.skipped.add(0, "rgb.txt: colour image without a depth image within 20 ms");
  for (const Pair& pair : pairs) {
    const ListedImage& c = colour.images[pair.colour];
    const ListedImage& d = depth.images[pair.depth];
    const RgbdEntry entry{c.utime_us, d.utime_us, directory / c.file, directory / d.file};
    if (!dataset.entries.empty() && entry.utime_us <= dataset.entries.back().utime_us)
      dataset.skipped.add(0, "rgb.txt: two images of one time");
    else if (!is_there(entry.colour) || !is_there(entry.depth))
      dataset.skipped.add(0, "image that is listed but not there");
    else
      dataset.entries.push_back(entry);
  }
  if (dataset.entries.empty())
    throw DatasetError(directory.string() + ": none of the " + std::to_string(pairs.size()) +
                       " colour and depth pairs of rgb.txt and depth.txt is there; unpack the "
                       "images beside the lists");
  if (std::filesystem::exists(directory / "groundtruth.txt")) {
    ReferenceTrajectory reference = read_tum_trajectory(directory / "groundtruth.txt");
    dataset.reference = std::move(reference.poses);
    for (const auto& [reason, entry] : reference.skipped.reasons())
      for (std::int64_t i = 0; i < entry.count; ++i)
        dataset.skipped.add(entry.first_place, "groundtruth.txt: " + reason);
  }
  return dataset;
}

}  // namespace fusion_slam
