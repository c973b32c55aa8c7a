// The files of the page, read into memory when the viewer starts: nothing else can be asked for.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace fusion_slam {

struct PageFile {
  std::string content_type;
  std::string content;
};

class PageFiles {
 public:
  // Takes the .html, .js, .css, .svg and .png files of a folder. A folder that is missing gives a
  // page that says how to build it.
  explicit PageFiles(const std::filesystem::path& folder);

  // "/" is index.html. nullptr when there is none.
  const PageFile* find(const std::string& path) const;
  bool complete() const { return complete_; }

 private:
  std::map<std::string, PageFile> files_;
  bool complete_ = false;
};

// The folder beside the running program: build/x/web, or share/fusion-slam/web when installed.
std::filesystem::path page_folder(const std::filesystem::path& program);

}  // namespace fusion_slam
