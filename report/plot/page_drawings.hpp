// SPDX-License-Identifier: Apache-2.0
// Finds the drawings in a page that this program wrote.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace fringetwin::report {

struct PageDrawing {
  std::string name;  ///< fit to be a file's, unique on the page
  std::string svg;   ///< the text of an SVG file
};

/// Returns the plots of a page (HTML) in their order; none of a page of others.
std::vector<PageDrawing> drawings_of_page(std::string_view html);

/// Writes the drawings as files of a folder, which may exist; drawings (.svg) of an earlier run go first.
void write_drawings(const std::filesystem::path& folder, const std::vector<PageDrawing>& drawings);

/// Throws UserError(usage) where the page says of plots that gnuplot did not draw them: how many, and why the
/// first was not.
void check_all_drawn(const std::filesystem::path& page);

}  // namespace fringetwin::report
