// Puts the pieces of commands' output together to lines with names before them.
#pragma once

#include <map>
#include <string>
#include <utility>

namespace fusion_slam {

class LogLines {
 public:
  // The lines that are whole now: "[robot/rplidar] text\n". A line longer than 4096 bytes is cut.
  std::string add(const std::string& deputy, const std::string& command, const std::string& text) {
    std::string& open = open_[{deputy, command}];
    std::string result;
    for (const char c : text) {
      if (c != '\n') open += c;
      if (c == '\n' && !open.empty() && open.back() == '\r') open.pop_back();  // a terminal's
      if (c == '\n' || open.size() >= kLongestLine) {
        result += prefix(deputy, command) + open + "\n";
        open.clear();
      }
    }
    return result;
  }

  // Lines that have no end yet.
  std::string rest() const {
    std::string result;
    for (const auto& [name, open] : open_)
      if (!open.empty()) result += prefix(name.first, name.second) + open + "\n";
    return result;
  }

 private:
  static constexpr std::size_t kLongestLine = 4096;
  static std::string prefix(const std::string& deputy, const std::string& command) {
    return "[" + deputy + (command.empty() ? "" : "/" + command) + "] ";
  }
  std::map<std::pair<std::string, std::string>, std::string> open_;
};

}  // namespace fusion_slam
