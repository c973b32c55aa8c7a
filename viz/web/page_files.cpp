#include "viz/web/page_files.hpp"

#include <fstream>
#include <iterator>

namespace fusion_slam {
namespace {

constexpr const char* kNotBuilt =
    "<!doctype html><html lang=en><meta charset=utf-8><title>Fusion-SLAM viewer</title>"
    "<body style='font:16px system-ui;max-width:38em;margin:15vh auto;padding:0 1em'>"
    "<h1>The page is not built</h1><p>The viewer runs, but its page is missing. It is made by npm:"
    "<pre>apt-get install nodejs npm\n./fusion-slam build</pre>"
    "<p>then start the viewer again. Everything else works without it.</body></html>";

const std::map<std::string, std::string>& content_types() {
  static const std::map<std::string, std::string> kTypes{{".html", "text/html; charset=utf-8"},
                                                         {".js", "text/javascript; charset=utf-8"},
                                                         {".css", "text/css; charset=utf-8"},
                                                         {".svg", "image/svg+xml"},
                                                         {".png", "image/png"},
                                                         {".txt", "text/plain; charset=utf-8"}};
  return kTypes;
}

}  // namespace

PageFiles::PageFiles(const std::filesystem::path& folder) {
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(folder, missing)) {
    const auto type = content_types().find(entry.path().extension().string());
    if (type == content_types().end() || !entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    files_["/" + entry.path().filename().string()] = {
        type->second, {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}};
  }
  complete_ = files_.count("/index.html") > 0;
  if (!complete_) files_["/index.html"] = {"text/html; charset=utf-8", kNotBuilt};
}

const PageFile* PageFiles::find(const std::string& path) const {
  // Browsers ask for the second one by themselves.
  const auto file = files_.find(path == "/"              ? "/index.html"
                                : path == "/favicon.ico" ? "/icon.svg"
                                                         : path);
  return file == files_.end() ? nullptr : &file->second;
}

std::filesystem::path page_folder(const std::filesystem::path& program) {
  const auto bin = program.parent_path();
  auto built = bin.parent_path() / "web";
  if (std::filesystem::exists(built / "index.html")) return built;
  return bin / ".." / ".." / "share" / "fusion-slam" / "web";
}

}  // namespace fusion_slam
