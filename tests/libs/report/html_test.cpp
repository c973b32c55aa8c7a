#include "libs/report/html.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "libs/report/page.hpp"

namespace fusion_slam {
namespace {

TEST(Html, NothingOfALogCanBecomeMarkup) {
  EXPECT_EQ(escape_html("<a href=\"x\">'&"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;");
  EXPECT_EQ(escape_html("m\u00b2 \u4e2d \U0001F600"), "m\u00b2 \u4e2d \U0001F600");
  const std::string replaced = "\xEF\xBF\xBD";
  EXPECT_EQ(escape_html("a\xFF"), "a" + replaced);
  EXPECT_EQ(escape_html("\xC0\xAF"), replaced + replaced);                 // overlong '/'
  EXPECT_EQ(escape_html("\xED\xA0\x80"), replaced + replaced + replaced);  // half a surrogate pair
  EXPECT_EQ(escape_html("\xE4\xB8"), replaced + replaced);                 // cut
  EXPECT_EQ(escape_html(std::string("\0\x1B", 2)), replaced + replaced);
}

// The test vectors of RFC 4648, section 10.
TEST(Html, Base64) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFF\xFE\xFB"), "//77");
}

TEST(Html, Numbers) {
  EXPECT_EQ(number(0.12345, 3), "0.123");
  EXPECT_EQ(number(std::numeric_limits<double>::quiet_NaN(), 3), "-");
  EXPECT_EQ(number(-std::numeric_limits<double>::max(), 2).size(), 313U);
  EXPECT_EQ(bytes_text(0), "0 B");
  EXPECT_EQ(bytes_text(1500), "1.5 kB");
  EXPECT_EQ(bytes_text(85839872), "85.8 MB");
  EXPECT_EQ(bytes_text(999.9e6), "1.0 GB");
}

TEST(Html, TablesSetNumbersFlush) {
  EXPECT_EQ(
      table_html({{"a<"}, {{"1.5"}, {"b"}}}),
      "<div class=\"scroll\"><table><thead><tr><th>a&lt;</th></tr></thead><tbody>\n"
      "<tr><td class=\"number\">1.5</td></tr>\n<tr><td>b</td></tr>\n</tbody></table></div>\n");
}

TEST(Html, APageEscapesWhatIsText) {
  Page page{"<t>", "<s>", {"<p>"}, {{"<l>", "<v>", "<n>", true}}, {{"<h>", "<i>", "<b>body</b>"}}};
  const std::string html = page_html(page);
  for (const char* raw : {"<t>", "<s>", "<l>", "<v>", "<n>", "<i>"})
    EXPECT_EQ(html.find(raw), std::string::npos) << raw;
  EXPECT_NE(html.find("<b>body</b>"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("http"), std::string::npos);  // nothing is fetched
}

}  // namespace
}  // namespace fusion_slam
