// SPDX-License-Identifier: Apache-2.0
#include "compare/page/report_gain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/page/field_table.hpp"
#include "report/map.hpp"
#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

using report::Plot;
using report::Series;

constexpr std::size_t kGainBins = 80;
constexpr std::size_t kFewestInBin = 20;  ///< a 5 % quantile of fewer is their smallest value

struct GrayOverE {
  double e, dn;
};

/// Collects the usable gray values of all gain images, of up to about 200,000 pixels.
std::vector<GrayOverE> gray_over_e(const GrayPair& pair, const GainFit& fit) {
  std::vector<GrayOverE> out;
  const std::size_t stride = 1 + pair.mask.size() / 200'000;
  const UsableRange& u = fit.usable;
  for (int image : pair.gain_images)
    for (std::size_t i = 0; i < pair.mask.size(); i += stride) {
      const double e = pair.irradiance_at(image, i), predicted = u.gain_dn * e + u.black_level_dn;
      const double dn = pair.real_at(image, i);
      if (pair.mask.data[i] != 0 && dn < u.saturation_dn && predicted >= u.low_dn && predicted <= u.high_dn)
        out.push_back({e, dn});
    }
  return out;
}

/// The band and the medians of one quantity over E.
struct BinSeries {
  Series band, median;
  BinSeries(const std::string& what, const std::string& color) {
    band.style = Series::Style::band;
    band.title = what + ", 5 … 95 %";
    median.style = Series::Style::points;
    median.title = what + ", median";
    median.width = 1.6;
    band.color = median.color = color;
  }
  void add(double e, const std::vector<float>& values) {
    band.x.push_back(e), median.x.push_back(e);
    band.y_low.push_back(report::percentile(values, 5.0)), band.y.push_back(report::percentile(values, 95.0));
    median.y.push_back(report::percentile(values, 50.0));
  }
};

}  // namespace

std::vector<Plot> gain_plots(const GrayPair& pair, const GainFit& fit) {
  const std::vector<GrayOverE> values = gray_over_e(pair, fit);
  const auto [low, high] = std::minmax_element(
      values.begin(), values.end(), [](const GrayOverE& a, const GrayOverE& b) { return a.e < b.e; });
  if (values.empty() || !(low->e < high->e)) return {};
  const double first = low->e, width = (high->e - low->e) / static_cast<double>(kGainBins);
  std::vector<std::vector<float>> real(kGainBins), difference(kGainBins);
  for (const GrayOverE& v : values) {
    const auto bin = std::min(kGainBins - 1, static_cast<std::size_t>((v.e - first) / width));
    real[bin].push_back(static_cast<float>(v.dn));
    difference[bin].push_back(static_cast<float>(fit.row.gain_dn * v.e + fit.row.black_level_dn - v.dn));
  }
  BinSeries gray("real", report::color::kReal), residual("simulated − real", report::color::kDifference);
  Series line{
      .title = fmt::format("{}: {} · E + {}", fit.row.usable ? "fit" : "provisional line",
                           report::number(fit.row.gain_dn, 5), report::number(fit.row.black_level_dn, 4)),
      .color = report::color::kSimulated};
  for (std::size_t b = 0; b < kGainBins; ++b) {
    if (real[b].size() < kFewestInBin) continue;
    const double e = first + (static_cast<double>(b) + 0.5) * width;
    gray.add(e, real[b]);
    residual.add(e, difference[b]);
    line.add(e, fit.row.gain_dn * e + fit.row.black_level_dn);
  }
  if (line.x.size() < 2) return {};
  Plot upper, lower;
  upper.y_label = "real gray value [DN]";
  upper.height_px = 330;
  upper.series = {gray.band, gray.median, line};
  lower.x_label = "simulated irradiance E";
  lower.y_label = "simulated − real [DN]";
  lower.height_px = 220;
  lower.zero_line = true;
  lower.series = {residual.band, residual.median};
  for (Plot* plot : {&upper, &lower}) plot->x_range = {{first, high->e}};
  return {upper, lower};
}

std::string gain_checks_html(const Comparison& comparison) {
  if (comparison.gain_checks.empty()) return "";
  std::string html;
  for (const GainRow& row : comparison.gain)
    html += fmt::format("<p>{}: {}{}.</p>", report::escape_html(row.camera), row.state,
                        row.why.empty() ? "" : ": " + report::escape_html(row.why));
  report::Table table = field_table(comparison.gain_checks);
  table.caption =
      "The line fitted once more to parts of the gray values, weighted with the predicted noise. A gain that "
      "is the sensor's is the same on all of them; z is the distance from the line of all values in standard "
      "errors.";
  return html + table.html();
}

}  // namespace fringetwin::compare
