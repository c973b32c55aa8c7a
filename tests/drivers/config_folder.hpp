// A folder with robots/ and sensors/, gone after the test.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

#include "libs/config/yaml_map.hpp"

namespace fusion_slam {

class ConfigFolder {
 public:
  explicit ConfigFolder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / (name + "-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_ / "robots");
    std::filesystem::create_directories(path_ / "sensors");
  }
  ~ConfigFolder() { std::filesystem::remove_all(path_); }
  ConfigFolder(const ConfigFolder&) = delete;
  ConfigFolder& operator=(const ConfigFolder&) = delete;

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
  }
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

// What load_setup says against these options; empty: nothing.
template <typename Options>
std::string error_of_setup(const Options& options) {
  try {
    load_setup(options);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

}  // namespace fusion_slam
