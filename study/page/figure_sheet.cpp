// SPDX-License-Identifier: Apache-2.0
#include "study/page/figure_sheet.hpp"

#include <fmt/format.h>

#include <set>

#include "report/plot/page_drawings.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::study {
namespace {

// No text of the user's can hold it: < is escaped.
const std::string kMarkBegin = "<!--figure ", kMarkEnd = "-->";

/// Returns a text as the name of a file: letters, digits, . and _ as they are, the rest as -.
std::string file_name(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '_' || (c == '.' && !out.empty());
    if (plain)
      out += c;
    else if (!out.empty() && out.back() != '-')
      out += '-';
  }
  return out;
}

}  // namespace

std::string FigureSheet::place(const std::string& name, const report::Drawing& drawing) {
  names_.push_back(name);
  drawings_.push_back(drawing);
  return fmt::format("{}{}{}", kMarkBegin, drawings_.size() - 1, kMarkEnd);
}

std::string FigureSheet::row(const std::vector<std::string>& placed) {
  std::string out = "<div class=\"maps\">";
  for (const std::string& p : placed) out += "<div class=\"map\">" + p + "</div>";
  if (placed.size() == 1) out += "<div class=\"map\"></div>";  // no wider than its neighbours
  return out + "</div>";
}

StudyReport FigureSheet::finish(const std::string& html) const {
  const std::vector<std::string> drawn = report::drawings_or_sentences(drawings_, "f");
  StudyReport out;
  std::set<std::string> taken;
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const std::vector<report::PageDrawing> files = report::drawings_of_page(drawn[i]);
    if (files.empty()) continue;  // the page says why
    std::string name = file_name(names_[i]);
    if (!taken.insert(name).second) taken.insert(name += fmt::format("-{}", i));
    out.figures.emplace_back(name, files[0].svg);
  }
  std::size_t at = 0;
  for (std::size_t mark; (mark = html.find(kMarkBegin, at)) != std::string::npos;) {
    out.html.append(html, at, mark - at);
    const std::size_t digits = mark + kMarkBegin.size(), end = html.find(kMarkEnd, digits);
    out.html += drawn.at(parse_number<std::size_t>(html.substr(digits, end - digits)).value());
    at = end + kMarkEnd.size();
  }
  out.html.append(html, at);
  return out;
}

}  // namespace fringetwin::study
