// Pieces of HTML. Pure functions, callable from any thread.
#pragma once

#include <string>
#include <vector>

namespace fusion_slam {

// Safe as text and inside a quoted attribute; what is no UTF-8 becomes U+FFFD.
std::string escape_html(const std::string& text);

// Binary as text (RFC 4648, section 4).
std::string base64(const std::string& bytes);

// printf with one number; "-" for what is not finite.
std::string number(double value, int decimals);
// 1.2 MB, 340 kB: decimal units.
std::string bytes_text(double bytes);

struct HtmlTable {
  std::vector<std::string> head;               // plain text
  std::vector<std::vector<std::string>> rows;  // plain text; numbers are set flush right
};
std::string table_html(const HtmlTable& table);

}  // namespace fusion_slam
