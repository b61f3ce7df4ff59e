// SPDX-License-Identifier: Apache-2.0
// Declares the parts of the comparison page, each a piece of HTML; only files of compare/page include it.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/result/options.hpp"
#include "compare/result/rows.hpp"
#include "compare/result/side.hpp"
#include "compare/verdict/coverage.hpp"
#include "report/map.hpp"
#include "report/plot/plot.hpp"

namespace fringetwin::compare {

/// Everything that a part of the page may show.
struct ReportInput {
  const std::filesystem::path& dir;
  const Twin& twin;
  const Side& real;
  const Side& simulated;
  const Comparison& comparison;
  const CompareOptions& options;
  std::string command;  ///< as typed, quoted for a shell
  bool has_real_images() const { return !real.images.empty(); }
};

// report_tables.cpp: empty where there is nothing to show
std::string verdict_html(const Comparison& c);
std::string fits_html(const ReportInput& in);
std::string gain_table_html(const Comparison& c);
std::string budget_html(const Comparison& c);
std::string phase_table_html(const Comparison& c);
std::string phase_budget_html(const Comparison& c);
std::string timing_html(const std::map<std::string, double>& timing_s);

// report_indicators.cpp
std::string indicators_html(const Comparison& c);

// report_coverage.cpp: also writes the maps as files
std::string coverage_html(const ReportInput& in);
/// Returns 1 for pixels measured on the simulated side only, -1 for those on the real side only, 0 for those
/// on both, NaN for the rest; saturated pixels are hatched with the other of 0 and NaN.
ImageF coverage_map(const Image<PixelState>& real, const Image<PixelState>& simulated);

// report_explained.cpp
std::string explained_summary_html(const Comparison& c);
std::string explained_html(const Comparison& c);
std::string causes_html(const Comparison& c);
std::string refinement_html(const Comparison& c);

/// Returns name and unit of a key of a fit: "center_mm" -> "center", "mm".
std::pair<std::string, std::string> name_and_unit(const std::string& key);
/// Returns a number of a fit (component < 0), or a component of a vector, with its standard error: "1.23 ±
/// 0.01".
std::string fit_value_text(const std::optional<measure::ObjectFit>& fit, const std::string& key,
                           int component);
/// Return the keys that any of the fits has, standard errors and directions left out; of the numbers counts,
/// too, and sizes come before the residual.
std::vector<std::string> vector_keys(const std::vector<const measure::ObjectFit*>& fits);
std::vector<std::string> number_keys(const std::vector<const measure::ObjectFit*>& fits);

/// Returns "5 076 of 5 317": points used, of those within the gate.
std::string points_text(const std::optional<measure::ObjectFit>& fit);

// report_pattern.cpp: empty where a cause is named
std::string pattern_html(const Comparison& c);

// report_gray.cpp, report_phase.cpp, report_geometry.cpp: figures; they also write the maps as files
std::string gray_figures_html(const ReportInput& in);
std::string held_out_figures_html(const ReportInput& in);
std::string phase_figures_html(const ReportInput& in);
std::string geometry_figures_html(const ReportInput& in);

/// One measurement of a fitted object, as the page names it.
struct MeasuredSide {
  const measure::Measurement* measurement;
  const char* name;   ///< "simulated"
  const char* color;  ///< of its histogram
};
/// Returns map and points of each side, coloured by the deviation from the fitted surface, and the histogram
/// of all; empty without deviations. Writes the maps as DIR/deviation_<object>_<name>.png. `command`: as
/// typed.
std::string deviation_html(const std::filesystem::path& dir, const Twin& twin, const std::string& command,
                           const std::string& object, const std::vector<MeasuredSide>& sides);
// report_noise.cpp, report_shift.cpp
std::string noise_html(const ReportInput& in);
std::string shift_html(const ReportInput& in);

/// Part of the picture that holds data.
struct Window {
  int x0 = 0, y0 = 0, width = 0, height = 0;
  std::string text() const;  ///< "pixels x 100…300, y 50…240"
};
/// Returns the bounding box of the non-zero pixels (without the outer 0.3 % on each side) plus a margin; the
/// whole image when there are none.
Window data_window(const ImageU8& mask);
/// Returns 1 where the image has a number.
ImageU8 finite_mask(const ImageF& image);
ImageF crop(const ImageF& image, const Window& window);
/// First and last column of the image that a plot shows.
using Columns = std::pair<int, int>;
/// The part of a camera's image that is valid on the sides that were decoded, and the row of its profiles.
struct ShownPart {
  Window window;
  int row = 0;
  Columns columns;  ///< of that row
};
ShownPart shown_part(const ReportInput& in, std::size_t camera);

/// Returns each value as k x k pixels: a map of blocks at its size in the image.
ImageF enlarged_blocks(const ImageF& blocks, int k);
/// Returns a row of an image as a line over the columns, NaN included.
report::Series row_series(const ImageF& image, int row, const Columns& columns, const std::string& title,
                          const std::string& color, double width = 1.4);
/// Returns a plot over the columns of an image.
report::Plot row_plot(const std::string& y_label, int height_px, const Columns& columns,
                      std::vector<report::Series> series);

/// Returns the style of a map of simulated - real.
report::MapStyle difference_style(const ImageF& difference, const std::string& unit);
/// Returns a map, a plot or a cloud with its title above it.
std::string titled_map(const std::string& title, const std::string& body);

/// Returns the index of the camera of that name, which the twin has.
std::size_t camera_index(const ReportInput& in, const std::string& name);
/// Returns "<h3>Camera “left”</h3>".
std::string camera_heading(const std::string& name);
/// Returns the paragraph that says what to do next; `commands`: HTML behind the text, may be empty.
std::string next_paragraph(const std::string& text, const std::string& commands);

/// Returns the figure as HTML; it tells the command that made it.
std::string figure_html(const ReportInput& in, const std::string& body, const std::string& caption,
                        const std::string& formula = "");

}  // namespace fringetwin::compare
