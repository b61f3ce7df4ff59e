// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/table.hpp"
#include "report/text.hpp"
#include "study/page/report_parts.hpp"
#include "study/statistics/study_statistics.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {
namespace {

using report::number, report::Plot, report::Series, report::text_column;

constexpr std::size_t kMostSlices = 7, kMostWhiskers = 60, kMostListed = 300, kMostSpacings = 400;

const std::vector<std::pair<const char*, const char*>> kMapNumbers = {
    {"x_mm", "error of the centre along x"},     {"y_mm", "error of the centre along y"},
    {"z_mm", "error of the centre along z"},     {"size_mm", "error of the diameter"},
    {"form_mm", "form, range of the residuals"}, {"form_95_mm", "form, range of 95 % of the residuals"}};

bool is_error(const std::string& name) { return !name.starts_with("form"); }

std::string place_text(const Eigen::Vector3d& p) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", p.x(), p.y(), p.z());
}

const MapNumber* number_at(const MapPosition& position, const std::string& name) {
  const auto found = position.numbers.find(name);
  return found == position.numbers.end() ? nullptr : &found->second;
}

bool any_has(const VolumeMap& map, const std::string& name) {
  return std::ranges::any_of(map.positions, [&](const MapPosition& p) {
    const MapNumber* n = number_at(p, name);
    return n && !std::isnan(n->mean);
  });
}

/// Values by [z][y from the bottom][x]; y of the world points down, so the greatest is at the bottom.
using Lattice = std::vector<std::vector<std::vector<double>>>;
Lattice lattice(const VolumeMapPlan& plan, const VolumeMap& map, const std::string& name,
                double MapNumber::*value) {
  const auto [nx, ny, nz] = plan.counts;
  Lattice out(nz, std::vector<std::vector<double>>(ny, std::vector<double>(nx, kNan)));
  for (std::size_t i = 0; i < map.positions.size(); ++i) {
    const auto k = static_cast<int>(i);
    if (const MapNumber* n = number_at(map.positions[i], name))
      out[k / (nx * ny)][ny - 1 - k / nx % ny][k % nx] = n->*value;
  }
  return out;
}

/// Returns an empty map with the limits that all slices share.
report::HeatMap slice_style(const VolumeMapPlan& plan, const VolumeMap& map, const Lattice& all,
                            report::Scale scale) {
  report::HeatMap out;
  out.scale = scale;
  std::vector<std::vector<double>> rows;
  for (const auto& slice : all) rows.insert(rows.end(), slice.begin(), slice.end());
  out.limits = report::limits_of(rows, scale);
  const auto [nx, ny, nz] = plan.counts;
  out.x_label = "x [mm]";
  out.y_label = "y [mm], down";
  for (int x = 0; x < nx; ++x) out.x_names.push_back(fmt::format("{:.4g}", map.positions[x].center_mm.x()));
  for (int y = ny - 1; y >= 0; --y)
    out.y_names.push_back(fmt::format("{:.4g}", map.positions[y * nx].center_mm.y()));
  out.height_px = std::clamp(150 + 48 * ny, 200, 520);
  return out;
}

std::string slices(const VolumeMapPlan& plan, const VolumeMap& map, const std::string& name,
                   const std::string& words, FigureSheet* sheet) {
  const Lattice means = lattice(plan, map, name, &MapNumber::mean),
                sigmas = lattice(plan, map, name, &MapNumber::sigma);
  report::HeatMap mean = slice_style(plan, map, means,
                                     is_error(name) ? report::Scale::diverging : report::Scale::viridis),
                  sigma = slice_style(plan, map, sigmas, report::Scale::viridis);
  const std::size_t nz = means.size(), per_slice = map.positions.size() / nz;
  const std::size_t shown = std::min(nz, kMostSlices);
  std::string out;
  for (std::size_t i = 0; i < shown; ++i) {
    const std::size_t z = shown == nz ? i : i * (nz - 1) / (shown - 1);
    const std::string at = fmt::format("z {:.4g} mm", map.positions[z * per_slice].center_mm.z());
    mean.values = means[z];
    sigma.values = sigmas[z];
    mean.title = fmt::format("mean of {} at {}", name, at);
    sigma.title = fmt::format("sigma of {} at {}", name, at);
    const std::string left = sheet->place(fmt::format("{}-{}-mean", name, at), mean);
    out += FigureSheet::row({left, sheet->place(fmt::format("{}-{}-sigma", name, at), sigma)});
  }
  return report::figure_html(
      out, fmt::format("{}: {}, mean and sigma over the trials. All slices share their colours{}.", name,
                       words, shown < nz ? fmt::format("; {} of {} slices", shown, nz) : ""));
}

Plot spacing_plot(const char* title, const char* y_label) {
  Plot plot{.title = title,
            .x_label = "nominal distance [mm]",
            .y_label = y_label,
            .width_px = 540,
            .height_px = 360};
  return plot;
}

Series dots(const std::vector<double>& x, const std::vector<double>& y) {
  Series s{.title = "pairs",
           .style = Series::Style::points,
           .color = report::color::kReal,
           .width = x.size() > 100 ? 1.0 : 1.8};
  const std::size_t step = (x.size() + kMostSpacings - 1) / kMostSpacings;
  for (std::size_t i = 0; i < x.size(); i += step) s.add(x[i], y[i]);
  return s;
}

std::string spacing_figures(const VolumeMap& map, double coverage, FigureSheet* sheet) {
  std::vector<double> length, mean, low, high, sigma;
  for (const MapSpacing& s : map.spacings) {
    if (std::isnan(s.error_mm.mean)) continue;
    length.push_back(s.length_mm);
    mean.push_back(s.error_mm.mean);
    low.push_back(s.error_mm.interval.low);
    high.push_back(s.error_mm.interval.high);
    sigma.push_back(s.error_mm.sigma);
  }
  if (length.empty()) return "";
  Plot errors = spacing_plot("spacing error", "error [mm]"),
       spread = spacing_plot("sigma of the spacing", "sigma [mm]");
  errors.zero_line = true;
  const std::string interval = fmt::format("{:g} % of the trials", 100.0 * coverage);
  Series pairs = dots(length, mean);
  if (length.size() <= kMostWhiskers) {
    pairs.style = Series::Style::whiskers;
    pairs.title = "mean, " + interval;
    pairs.y_low = low;
    pairs.y_high = high;
  } else {
    const RunningMean lower = running_mean(length, low, coverage),
                      upper = running_mean(length, high, coverage);
    errors.series.push_back({.title = interval,
                             .x = lower.x,
                             .y = upper.mean,
                             .y_low = lower.mean,
                             .style = Series::Style::band,
                             .color = report::color::kSimulated});
    pairs.title = "means";
  }
  errors.series.push_back(pairs);
  spread.series = {dots(length, sigma)};
  const RunningMean line = running_mean(length, sigma, coverage);
  if (!line.x.empty())
    spread.series.push_back({.title = "running mean",
                             .x = line.x,
                             .y = line.mean,
                             .style = Series::Style::line,
                             .color = report::color::kSimulated,
                             .width = 2.0});
  const std::string left = sheet->place("spacing-error", errors);
  return report::figure_html(
      FigureSheet::row({left, sheet->place("spacing-sigma", spread)}),
      fmt::format(
          "Every pair of positions is a ball bar: distance of the measured centres less the nominal one.{}{}",
          length.size() <= kMostWhiskers
              ? ""
              : " Band: the ends of the pairs' intervals, averaged along the distance.",
          length.size() > kMostSpacings ? fmt::format(" Some of {} pairs are drawn.", length.size()) : ""),
      "|c_b - c_a| - nominal distance");
}

std::string value_text(const MapNumber& n) {
  return fmt::format("{} ({} … {})", number(n.mean, 3), number(n.interval.low, 3),
                     number(n.interval.high, 3));
}

std::string worst_table(const VolumeMapPlan& plan, const VolumeMap& map) {
  report::Table out;
  out.caption = map.measured == map.positions.size()
                    ? "The worst of the volume."
                    : "The worst of the volume, of positions and pairs that were measured in every trial.";
  const std::string percent = fmt::format("{:g} % of the trials", 100.0 * plan.coverage);
  out.columns = {text_column("number"),
                 {"largest mean", percent},
                 text_column("at", "mm"),
                 {"largest sigma"},
                 text_column("at", "mm")};
  for (const auto& [name, words] : kMapNumbers) {
    const auto worst = map.worst.find(name);
    if (worst == map.worst.end()) continue;
    const MapPosition &mean = map.positions[worst->second.mean], &sigma = map.positions[worst->second.sigma];
    out.add_row({name, value_text(mean.numbers.at(name)), place_text(mean.center_mm),
                 number(sigma.numbers.at(name).sigma, 3), place_text(sigma.center_mm)});
  }
  if (map.worst_spacing) {
    const MapSpacing &mean = map.spacings[map.worst_spacing->mean],
                     &sigma = map.spacings[map.worst_spacing->sigma];
    const auto pair = [&](const MapSpacing& s) {
      return place_text(map.positions[s.a].center_mm) + " to " + place_text(map.positions[s.b].center_mm);
    };
    out.add_row(
        {"spacing_mm", value_text(mean.error_mm), pair(mean), number(sigma.error_mm.sigma, 3), pair(sigma)});
  }
  if (map.largest_mm.n > 0)
    out.add_row({fmt::format("largest spacing error of a trial, mm{}",
                             map.largest_mm.n < plan.trials ? fmt::format(" ({} of {} trials have all pairs)",
                                                                          map.largest_mm.n, plan.trials)
                                                            : ""),
                 value_text(map.largest_mm), "", number(map.largest_mm.sigma, 3), ""});
  return out.html();
}

std::string positions_table(const VolumeMap& map) {
  report::Table out;
  out.columns = {text_column("position", "mm"), {"trials"}, {"failed"}};
  for (const auto& [name, words] : kMapNumbers) out.columns.push_back({name, "mean ± sigma"});
  for (std::size_t i = 0; i < std::min(map.positions.size(), kMostListed); ++i) {
    const MapPosition& p = map.positions[i];
    std::vector<std::string> row = {place_text(p.center_mm), std::to_string(p.n), std::to_string(p.failed)};
    for (const auto& [name, words] : kMapNumbers) {
      const MapNumber* n = number_at(p, name);
      row.push_back(n ? number(n->mean, 3) + " ± " + number(n->sigma, 2) : "–");
    }
    out.add_row(row);
  }
  const std::string shown = shown_of(out.rows.size(), map.positions.size());
  return fmt::format("<details><summary>{} positions{}</summary>{}</details>", map.positions.size(),
                     shown.empty() ? "" : " (" + shown + "; all: result.json)", out.html());
}

std::string note_of(const VolumeMapPlan& plan) {
  std::string out =
      "A mean is what is wrong with the method itself at that place, a sigma what the uncertain inputs add. ";
  const Interval s = sigma_interval(1.0, static_cast<double>(plan.trials) - 1.0, kReportCoverage);
  out += fmt::format(
      "With {} trials the true sigma lies between {:.2f} and {:.2f} times the one shown (95 %, normal "
      "scatter), and the largest of {} positions is larger by chance. ",
      plan.trials, s.low, s.high, plan.positions().size());
  const auto n = static_cast<double>(plan.trials);
  out += fmt::format(
      "A mean over the trials is known to ±{:.2f} sigma only (Student, sigma/√n). The draws of the rig are "
      "common to all positions: chance moves all of them together, and averaging over positions does not "
      "help. ",
      student_t_quantile(0.5 + 0.5 * kReportCoverage, n - 1.0) / std::sqrt(n));
  if (interval_is_range(plan.trials, plan.coverage))
    out += "So few trials: an interval is the range of all of them. ";
  return out +
         "The artefacts are exact but for a stated form deviation; this is no acceptance test by VDI/VDE "
         "2634.";
}

}  // namespace

StudyReport volume_map_report(const StudyRecord& study, const VolumeMapPlan& plan, const VolumeMap& map) {
  FigureSheet sheet;
  report::Page page = page_of(
      study, fmt::format("A sphere of {:.6g} mm radius at {} × {} × {} positions, {} trials, on the twin {}",
                         plan.radius_mm, plan.counts[0], plan.counts[1], plan.counts[2], plan.trials,
                         study.head.twin.filename().string()));
  page.summary_html = worst_table(plan, map) + inputs_table(plan.inputs) + page.summary_html;
  page.note = note_of(plan);
  if (map.measured < map.positions.size())
    page.warnings.push_back(
        fmt::format("{} of {} positions were measured in every trial; empty cells were in none.",
                    map.measured, map.positions.size()));
  page.sections.push_back({"positions", "Positions", positions_table(map)});
  add_failures(study, &page);
  if (const std::string spacing = spacing_figures(map, plan.coverage, &sheet); !spacing.empty())
    page.sections.push_back({"spacing", "Spacing", spacing});
  for (const auto& [name, words] : kMapNumbers)
    if (any_has(map, name))
      page.sections.push_back({std::string("map-") + name, name, slices(plan, map, name, words, &sheet)});
  return sheet.finish(page.html());
}

}  // namespace fringetwin::study
