// SPDX-License-Identifier: Apache-2.0
#include "report/plot/page_drawings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>

#include "report/plot/plot.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::report {
namespace {

constexpr std::string_view kBegin = "<svg role=\"img\"", kEnd = "</svg>", kCanvas = "gnuplot_canvas\"";
constexpr std::size_t kMostBeforeCanvas = 8192;  ///< bytes

/// Returns the id that the ids of a drawing begin with, as drawing_svg() got it, with plain letters alone.
std::string name_of(std::string_view svg) {
  const std::size_t end = svg.find(kCanvas), quote = svg.rfind('"', end);
  if (end == std::string_view::npos || quote == std::string_view::npos) return "";
  std::string name(svg.substr(quote + 1, end - quote - 1));
  while (name.ends_with('-')) name.pop_back();
  std::ranges::replace_if(
      name, [](unsigned char c) { return std::isalnum(c) == 0 && c != '-'; }, '_');
  return name;
}

/// Returns whether a file begins as a drawing that write_drawings() wrote.
bool is_ours(const std::filesystem::path& file) {
  std::string begin(kMostBeforeCanvas, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return begin.find(kBegin) != std::string::npos && begin.find(kCanvas) != std::string::npos;
}

/// Returns the names of our drawings in a folder, which may not exist; files of others stay.
std::vector<std::string> drawings_in(const std::filesystem::path& folder) {
  std::vector<std::string> out;
  std::error_code error;  // no folder: nothing
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".svg" && entry.is_regular_file(error) && is_ours(entry.path()))
      out.push_back(entry.path().filename().string());
  return out;
}

}  // namespace

std::vector<PageDrawing> drawings_of_page(std::string_view html) {
  std::vector<PageDrawing> drawings;
  for (std::size_t begin = html.find(kBegin); begin != std::string_view::npos;
       begin = html.find(kBegin, begin + 1)) {
    const std::size_t end = html.find(kEnd, begin);
    if (end == std::string_view::npos) break;
    const std::string_view svg = html.substr(begin, end + kEnd.size() - begin);
    std::string name = name_of(svg);
    if (name.empty()) continue;  // no plot
    if (std::ranges::find(drawings, name, &PageDrawing::name) != drawings.end())
      name += fmt::format("-{}", drawings.size() + 1);
    drawings.push_back({name, standalone_svg(std::string(svg))});
  }
  return drawings;
}

void write_drawings(const std::filesystem::path& folder, const std::vector<PageDrawing>& drawings) {
  begin_output(folder, drawings_in(folder), Writers::several);
  for (const PageDrawing& drawing : drawings) write_text_file(folder / (drawing.name + ".svg"), drawing.svg);
  say(fmt::format("{} drawings: {}", drawings.size(), folder.string()));
}

void check_all_drawn(const std::filesystem::path& page) {
  const std::string html = read_whole_text(page, {.what = "page"});
  std::string why;
  std::size_t n = 0;
  for (std::size_t at = html.find(kUndrawn); at != std::string::npos; at = html.find(kUndrawn, at)) {
    at += kUndrawn.size();
    const std::string_view sentence = std::string_view(html).substr(at, html.find(".</p>", at) - at);
    if (n++ == 0) why = unescape_html(sentence.substr(0, sentence.find('\n')));
  }
  if (n > 0)
    throw UserError(ExitCode::usage, page.string(),
                    fmt::format("{} of its drawings could not be made ({})", n, why),
                    "run the command that made the page again for them");
}

}  // namespace fringetwin::report
