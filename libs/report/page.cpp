#include "libs/report/page.hpp"

namespace fusion_slam {
namespace {

// Okabe & Ito (2008): colours that can be told apart by the colour-blind.
const char kStyle[] = R"css(
:root { color-scheme: light dark; --paper: #fbfbfa; --card: #fff; --ink: #21242b; --soft: #6a6f7a;
  --line: #e2e4e8; --unknown: #e6e8ec; --bad: #b3261e; --s1: #0072b2; --s2: #d55e00; --s3: #009e73; --s4: #cc79a7;
  --s5: #8a6d00; --s6: #3a9fd6; --s7: #7a4fbf; --s8: #555; }
@media (prefers-color-scheme: dark) { :root { --paper: #15171b; --card: #1e2127; --ink: #e8e9ec;
  --soft: #a0a5b0; --line: #343842; --unknown: #4a4f5a; --bad: #ff8a80; --s1: #56b4e9; --s2: #ff9a4d; --s3: #2fd3a5;
  --s4: #e8a5cb; --s5: #f0e442; --s6: #9bd4f5; --s7: #b99cf0; --s8: #bbb; } }
@media print { :root { color-scheme: light; --paper: #fff; --card: #fff; --ink: #000; --soft: #444;
  --line: #ccc; --unknown: #e4e4e4; --s1: #0072b2; --s2: #d55e00; --s3: #009e73; --s4: #cc79a7; --s5: #8a6d00;
  --s6: #3a9fd6; --s7: #7a4fbf; --s8: #555; --bad: #b3261e; } figure, tr, .fact { break-inside: avoid; }
  h2, h2 + p { break-after: avoid; } details::details-content { content-visibility: visible; } summary { display: none; }
  * { print-color-adjust: exact; } pre { white-space: pre-wrap; font-size: 8.5px !important; } th, td { white-space: normal !important; }
  body { max-width: none !important; padding: 0 !important; font-size: 12px !important; }
  .figures { grid-template-columns: 1fr !important; } figure svg { max-height: 150mm; } }
@page { margin: 14mm; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 28px 20px 60px; max-width: 1120px; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
h1 { font-size: 26px; margin: 0; letter-spacing: -.01em; }
h2 { font-size: 18px; margin: 36px 0 4px; }
p { margin: 4px 0 12px; } .quiet, .subtitle, .note { color: var(--soft); }
.facts { display: grid; grid-template-columns: repeat(auto-fill, minmax(136px, 1fr)); gap: 10px;
  margin: 20px 0; }
.fact { background: var(--card); border: 1px solid var(--line); border-radius: 8px;
  padding: 10px 12px; }
.fact b { display: block; font-size: 21px; font-weight: 600; font-variant-numeric: tabular-nums; }
.fact.bad { border-color: var(--bad); } .fact.bad b, .problem { color: var(--bad); }
.note { font-size: 12px; }
.problem { border-left: 4px solid var(--bad); padding: 2px 12px; margin: 10px 0; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(460px, 100%), 1fr));
  gap: 14px; }
figure { margin: 0; background: var(--card); border: 1px solid var(--line); border-radius: 8px;
  padding: 12px; }
svg { width: 100%; height: auto; display: block; font: 12px system-ui, "DejaVu Sans", sans-serif; }
svg text { fill: var(--soft); } svg .title { fill: var(--ink); font-size: 14px; font-weight: 600; }
svg path { fill: none; stroke-width: 1.6; stroke-linejoin: round; stroke-linecap: round; }
svg .grid { stroke: var(--line); } svg .bar { fill: var(--s1); } svg .key { stroke-width: 4; }
svg .s1 { stroke: var(--s1); } svg .s2 { stroke: var(--s2); } svg .s3 { stroke: var(--s3); }
svg .s4 { stroke: var(--s4); } svg .s5 { stroke: var(--s5); } svg .s6 { stroke: var(--s6); }
svg .s7 { stroke: var(--s7); } svg .s8 { stroke: var(--s8); } svg .ink { stroke: var(--ink); }
svg .unknown { fill: var(--unknown); } svg image { image-rendering: pixelated; }
svg .truth path { stroke: var(--soft); stroke-width: 1.2; stroke-dasharray: 4 3; }
svg .way path { stroke-width: 2.4; } svg .plain path { stroke: var(--s1); stroke-width: 2; }
svg .closure { stroke: var(--s2); stroke-width: 1.2; opacity: .75; }
svg .off { stroke: var(--bad); stroke-width: 2; stroke-dasharray: 3 3; }
.scroll { overflow-x: auto; } table { border-collapse: collapse; width: 100%; font-size: 14px; }
th, td { text-align: left; padding: 5px 12px 5px 0; border-bottom: 1px solid var(--line);
  white-space: nowrap; } th { color: var(--soft); font-weight: 500; }
td.number { font-variant-numeric: tabular-nums; }
pre { overflow-x: auto; font: 12px/1.45 ui-monospace, "DejaVu Sans Mono", monospace;
  background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 12px; }
summary { cursor: pointer; } img { max-width: 100%; display: block; }
)css";

}  // namespace

std::string page_html(const Page& page) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      escape_html(page.title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" +
      escape_html(page.title) + "</h1>\n<p class=\"subtitle\">" + escape_html(page.subtitle) +
      "</p>\n";
  for (const std::string& problem : page.problems)
    html += "<p class=\"problem\">" + escape_html(problem) + "</p>\n";
  html += "<div class=\"facts\">\n";
  for (const Fact& fact : page.facts)
    html += std::string("<div class=\"fact") + (fact.bad ? " bad" : "") + "\">" +
            escape_html(fact.label) + "<b>" + escape_html(fact.value) +
            "</b><span class=\"note\">" + escape_html(fact.note) + "</span></div>\n";
  html += "</div>\n";
  for (const Section& section : page.sections) {
    html += "<section>\n<h2>" + escape_html(section.title) + "</h2>\n";
    if (!section.intro.empty())
      html += "<p class=\"quiet\">" + escape_html(section.intro) + "</p>\n";
    html += section.body + "</section>\n";
  }
  return html + "</body>\n</html>\n";
}

}  // namespace fusion_slam
