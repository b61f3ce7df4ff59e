// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/report_parts.hpp"
#include "report/html_page.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare {
namespace {

std::optional<Eigen::Vector3d> object_center_mm(const Twin& twin) {
  const std::string name = twin.measure.fits.empty() ? (twin.objects.empty() ? "" : twin.objects.front().name)
                                                     : twin.measure.fits.front().object;
  const Object* object = twin.find_object(name);
  if (!object) return std::nullopt;
  return std::visit([](const auto& shape) { return place_mm(shape); }, object->shape);
}

std::size_t valid_in_row(const ImageU8& mask, int row) {
  const auto first = mask.data.begin() + static_cast<std::ptrdiff_t>(mask.index(0, row));
  return static_cast<std::size_t>(std::count(first, first + mask.width, static_cast<unsigned char>(1)));
}

/// Returns the first and last index without the outer 0.3 % of the counts on each side: stray pixels far from
/// the part must not shrink it on the page.
std::optional<std::pair<int, int>> middle_of(const std::vector<std::size_t>& counts) {
  std::size_t total = 0;
  for (std::size_t c : counts) total += c;
  if (total == 0) return std::nullopt;
  const double skip = 0.003 * static_cast<double>(total);
  int first = -1, last = 0;
  double below = 0.0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    const double before = below;
    below += static_cast<double>(counts[i]);
    if (first < 0 && below > skip) first = static_cast<int>(i);
    if (before < static_cast<double>(total) - skip) last = static_cast<int>(i);
  }
  return std::pair{first, last};
}

/// Returns the image row of the profiles: through the first object's centre where that is on the part, else
/// the row with the most valid pixels.
int profile_row(const ReportInput& in, std::size_t camera, const ImageU8& mask) {
  int best = mask.height / 2;
  std::size_t most = 0;
  for (int y = 0; y < mask.height; ++y)
    if (const std::size_t n = valid_in_row(mask, y); n > most) most = n, best = y;
  if (const auto center = object_center_mm(in.twin)) {
    const Camera& c = in.twin.cameras[camera];
    if (const auto q = c.lens.project(c.T_cam_world * *center)) {
      const double row = std::round(q->y());
      if (row >= 0 && row < mask.height && valid_in_row(mask, static_cast<int>(row)) * 2 >= most)
        return static_cast<int>(row);
    }
  }
  return best;
}

/// Returns the columns of a row from its first to its last non-zero pixel, with a margin.
Columns columns_of_row(const ImageU8& mask, int row) {
  constexpr int kMargin = 12;
  int first = -1, last = -1;
  for (int x = 0; x < mask.width; ++x)
    if (mask(x, row) != 0) {
      if (first < 0) first = x;
      last = x;
    }
  if (first < 0) first = 0, last = mask.width - 1;
  return {first - kMargin, last + kMargin};
}

}  // namespace

std::string Window::text() const {
  return fmt::format("pixels x {}…{}, y {}…{}", x0, x0 + width - 1, y0, y0 + height - 1);
}

Window data_window(const ImageU8& mask) {
  std::vector<std::size_t> per_column(static_cast<std::size_t>(mask.width)),
      per_row(static_cast<std::size_t>(mask.height));
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (mask(x, y) != 0) {
        ++per_column[x];
        ++per_row[y];
      }
  const auto columns = middle_of(per_column), rows = middle_of(per_row);
  if (!columns || !rows) return {0, 0, mask.width, mask.height};
  const auto [left, right] = *columns;
  const auto [top, bottom] = *rows;
  const int margin = 8 + std::max(right - left, bottom - top) / 20;
  Window w{.x0 = std::max(0, left - margin), .y0 = std::max(0, top - margin)};
  w.width = std::min(mask.width - 1, right + margin) - w.x0 + 1;
  w.height = std::min(mask.height - 1, bottom + margin) - w.y0 + 1;
  return w;
}

ShownPart shown_part(const ReportInput& in, std::size_t camera) {
  const ImageU8 mask = valid_in_both(in.twin.cameras[camera], camera, in.real, in.simulated);
  const int row = profile_row(in, camera, mask);
  return {data_window(mask), row, columns_of_row(mask, row)};
}

ImageU8 finite_mask(const ImageF& image) {
  ImageU8 mask(image.width, image.height, 0);
  for (std::size_t i = 0; i < image.size(); ++i) mask.data[i] = std::isfinite(image.data[i]) ? 1 : 0;
  return mask;
}

ImageF crop(const ImageF& image, const Window& window) {
  ImageF out(window.width, window.height);
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) out(x, y) = image(x + window.x0, y + window.y0);
  return out;
}

ImageF enlarged_blocks(const ImageF& blocks, int k) {
  ImageF out(blocks.width * k, blocks.height * k);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) out(x, y) = blocks(x / k, y / k);
  return out;
}

report::Series row_series(const ImageF& image, int row, const Columns& columns, const std::string& title,
                          const std::string& color, double width) {
  report::Series s{.title = title, .color = color, .width = width};
  for (int x = std::max(0, columns.first); x <= std::min(columns.second, image.width - 1); ++x) {
    s.x.push_back(x);
    s.y.push_back(static_cast<double>(image(x, row)));
  }
  return s;
}

report::Plot row_plot(const std::string& y_label, int height_px, const Columns& columns,
                      std::vector<report::Series> series) {
  return {.x_label = "image column [px]",
          .y_label = y_label,
          .series = std::move(series),
          .height_px = height_px,
          .x_range = columns};
}

report::MapStyle difference_style(const ImageF& difference, const std::string& unit) {
  return {.scale = report::Scale::diverging,
          .limits = report::symmetric_limits(difference),
          .unit = unit,
          .title = "simulated − real",
          .max_width_px = 720};
}

std::string titled_map(const std::string& title, const std::string& body) {
  return "<div class=\"map\"><h4>" + title + "</h4>" + body + "</div>";
}

std::size_t camera_index(const ReportInput& in, const std::string& name) {
  const std::vector<Camera>& cameras = in.twin.cameras;
  const auto at = std::ranges::find_if(cameras, [&](const Camera& camera) { return camera.name == name; });
  FT_CHECK(at != cameras.end(), "rows are of the twin's cameras");
  return static_cast<std::size_t>(at - cameras.begin());
}

std::string camera_heading(const std::string& name) {
  return "<h3>Camera “" + report::escape_html(name) + "”</h3>\n";
}

std::string next_paragraph(const std::string& text, const std::string& commands) {
  return "<p class=\"next\"><strong>What to do next:</strong> " + report::escape_html(text) + commands +
         "</p>\n";
}

std::string figure_html(const ReportInput& in, const std::string& body, const std::string& caption,
                        const std::string& formula) {
  return report::figure_html(body, caption, formula, in.command);
}

}  // namespace fringetwin::compare
