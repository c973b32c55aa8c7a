// link: fs_datasets
// The texts beside RGB-D images, cut at each NUL: rgb.txt, depth.txt and groundtruth.txt of a TUM
// sequence, a pose of 7-Scenes. Opening gives frames in order of time and finite poses, or a
// DatasetError.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "libs/datasets/rgbd_dataset.hpp"
#include "tests/fuzz/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

void require(bool ok) {
  if (!ok) std::abort();
}

void write_text(const fs::path& path, const std::string& text) {
  fusion_slam::write_file(path, text.data(), text.size());
}

struct Folders {
  fs::path tum = fusion_slam::temporary_folder() / "tum";
  fs::path scenes = fusion_slam::temporary_folder() / "scenes";
  Folders() {
    fs::create_directories(tum);
    fs::create_directories(scenes);
    for (const char* image : {"a.png", "b.png", "c.png"}) write_text(tum / image, "no image");
    write_text(scenes / "frame-000000.color.png", "no image");
    write_text(scenes / "frame-000000.depth.png", "no image");
  }
};

void check(const fusion_slam::RgbdDataset& dataset) {
  require(!dataset.entries.empty());
  for (std::size_t i = 1; i < dataset.entries.size(); ++i)
    require(dataset.entries[i].utime_us > dataset.entries[i - 1].utime_us);
  for (std::size_t i = 0; i < dataset.reference.size(); ++i) {
    require(dataset.reference[i].T_world_reference.matrix().allFinite());
    require(i == 0 || dataset.reference[i].utime_us > dataset.reference[i - 1].utime_us);
  }
  std::string why;
  require(!fusion_slam::load_frame(dataset, 0, &why) && !why.empty());
  require(!fusion_slam::load_colour_jpeg(dataset, 0));
}

template <class Open>
void try_open(Open open, const fs::path& folder) {
  try {
    check(open(folder));
  } catch (const fusion_slam::DatasetError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folders folders;
  std::vector<std::string> texts(1);
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] != 0 || texts.size() == 4)
      texts.back() += static_cast<char>(data[i]);
    else
      texts.emplace_back();
  }
  texts.resize(4);
  write_text(folders.tum / "rgb.txt", texts[0]);
  write_text(folders.tum / "depth.txt", texts[1]);
  if (texts[2].empty())
    fs::remove(folders.tum / "groundtruth.txt");
  else
    write_text(folders.tum / "groundtruth.txt", texts[2]);
  try_open(fusion_slam::open_tum_rgbd, folders.tum);
  write_text(folders.scenes / "frame-000000.pose.txt", texts[3]);
  try_open(fusion_slam::open_seven_scenes, folders.scenes);
  return 0;
}
