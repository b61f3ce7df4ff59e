// SPDX-License-Identifier: Apache-2.0
// Draws plots as inline SVG: series of numbers go in, gnuplot draws them (fed through a pipe, no temporary
// files), <svg> elements come out. It also makes histograms as series.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "report/plot/plot_series.hpp"

namespace fringetwin::report {

/// Holds the script that makes gnuplot draw one plot.
struct Drawing {
  std::string title;   ///< for messages, and for readers who hear the page
  std::string script;  ///< empty where there are no data
  int least_px = 0;    ///< narrower than this its letters cannot be read
};

/// Returns any text as a gnuplot string in double quotes, escaped.
std::string gnuplot_text(const std::string& text);
/// Returns the gnuplot commands that all drawings begin with: terminal, fonts, borders and grid.
std::string gnuplot_head(int width_px, int height_px);
inline constexpr int kLetters_px = 12;  ///< what it sets
/// Returns the width to which a page may shrink a drawing of this width: its smallest letters are 9.2 px
/// then.
int least_width_px(int width_px, int smallest_letters_px = kLetters_px);
/// Returns the commands and data that make gnuplot draw the plot, small lengths in µm (plot_axes.hpp).
std::string gnuplot_script(const Plot& plot);
/// Returns the plot as a drawing, whose script is empty when no series has data.
Drawing drawing(const Plot& plot);

/// Returns an inline <svg>, all ids of which begin with `id` so that they are unique in a page. Throws
/// UserError(usage) when gnuplot is missing (says which package brings it) or refuses the plot.
std::string drawing_svg(const Drawing& drawing, const std::string& id);
std::string plot_svg(const Plot& plot, const std::string& id);

/// What the sentence begins with that stands on a page for a plot that gnuplot did not draw.
inline constexpr std::string_view kUndrawn = "<p class=\"missing undrawn\">Plot left out: ";

/// Does the same for several plots at once (gnuplot started once per plot, on all cores), each in a frame
/// that scrolls, by key, too, where a screen is narrower than its least width; a plot that cannot be drawn
/// becomes a sentence that says so (with kUndrawn where there are data), so that the rest of the report is
/// still written. Throws Cancelled.
std::vector<std::string> drawings_or_sentences(const std::vector<Drawing>& drawings,
                                               const std::string& id_prefix);
std::vector<std::string> plots_or_sentences(const std::vector<Plot>& plots, const std::string& id_prefix);

/// Returns an inline <svg> as the text of an SVG file of its own, on white.
std::string standalone_svg(const std::string& inline_svg);

struct Histogram {
  double low = 0.0, bin_width = 0.0;
  std::vector<std::size_t> counts;  ///< values outside [low, high] are not counted
  std::size_t n_below = 0, n_above = 0;
};
/// Counts the values in `bins` equal bins over [low, high]; non-finite values are ignored. Throws on bins < 1
/// or low >= high (programming fault).
Histogram histogram(const std::vector<float>& values, int bins, double low, double high);
/// Returns the histogram as a series of bars, in percent of all finite values.
Series histogram_series(const Histogram& h, const std::string& title, const std::string& color);

}  // namespace fringetwin::report
