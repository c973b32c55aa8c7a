// report.html: one file that needs nothing else, no script and no network; prints well.
#pragma once

#include <string>
#include <vector>

#include "libs/report/html.hpp"

namespace fusion_slam {

struct Fact {
  std::string label;
  std::string value;
  std::string note;  // small, below; may be empty
  bool bad = false;  // something a person should look at
};

struct Section {
  std::string title;
  std::string intro;  // one sentence; may be empty
  std::string body;   // HTML
};

struct Page {
  std::string title;
  std::string subtitle;
  std::vector<std::string> problems;  // shown first
  std::vector<Fact> facts;
  std::vector<Section> sections;
};

// Titles, facts and problems are plain text and are escaped; bodies are HTML of this library.
std::string page_html(const Page& page);

}  // namespace fusion_slam
