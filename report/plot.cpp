// SPDX-License-Identifier: Apache-2.0
#include "report/plot.hpp"

#include <fmt/format.h>

#include <cmath>
#include <future>

#include "report/process.hpp"
#include "report/text.hpp"
#include "twin/errors.hpp"

namespace fringetwin::report {
namespace {

/// gnuplot string in double quotes; enhanced text is off, so only \ and " need care.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    // between back quotes gnuplot would run a command, in double quotes, too
    out += c == '\n' ? ' ' : c == '`' ? '\'' : c;
  }
  return out + '"';
}

std::string data_row(const Series& s, std::size_t i) {
  if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) return "\n";  // a blank line breaks the curve
  if (s.style == Series::Style::band)
    return fmt::format("{:.7g} {:.7g} {:.7g}\n", s.x[i], s.y_low[i], s.y[i]);
  return fmt::format("{:.7g} {:.7g}\n", s.x[i], s.y[i]);
}

std::string style_words(const Series& s) {
  switch (s.style) {
    case Series::Style::line:
      return fmt::format("with lines lw {} lc rgb {}", s.width, quoted(s.color));
    case Series::Style::dashed:
      return fmt::format("with lines lw {} dt (8,5) lc rgb {}", s.width, quoted(s.color));
    case Series::Style::points:
      return fmt::format("with points pt {} ps {} lw 1.5 lc rgb {}", s.point_type, 0.3 * s.width,
                         quoted(s.color));
    case Series::Style::bars:
      return fmt::format("with boxes fs transparent solid 0.45 noborder lc rgb {}", quoted(s.color));
    case Series::Style::band:
      return fmt::format("with filledcurves fs transparent solid 0.2 noborder lc rgb {}", quoted(s.color));
  }
  return "";
}

/// The labels as a second drawing of the same points.
std::string label_block(const Series& s) {
  std::string out;
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (std::isfinite(s.x[i]) && std::isfinite(s.y[i]) && !s.labels[i].empty())
      out += fmt::format("{:.7g} {:.7g} {}\n", s.x[i], s.y[i], quoted(s.labels[i]));
  return out;
}

bool has_data(const Series& s) {
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (std::isfinite(s.x[i]) && std::isfinite(s.y[i])) return true;
  return false;
}

/// One HTML page holds many plots: gnuplot's ids would collide.
std::string inline_svg(std::string svg, const std::string& unsafe_id) {
  const std::string id = safe_id(unsafe_id);
  const std::size_t start = svg.find("<svg");
  FT_CHECK(start != std::string::npos, "gnuplot wrote no <svg>");
  svg.erase(0, start);
  for (const char* name : {"gpDot", "gpPt", "textbox", "greybox", "gnuplot_plot_", "gnuplot_canvas"}) {
    svg = replace_all(svg, std::string("id='") + name, "id='" + id + name);
    svg = replace_all(svg, std::string("id=\"") + name, "id=\"" + id + name);
    svg = replace_all(svg, std::string("#") + name, "#" + id + name);
  }
  const auto drop = [&](const std::string& from, const std::string& to) {
    const std::size_t a = svg.find(from);
    const std::size_t b = a == std::string::npos ? a : svg.find(to, a);
    if (b != std::string::npos) svg.erase(a, b + to.size() - a);
  };
  drop("<title>Gnuplot</title>", "</desc>");
  return svg;
}

}  // namespace

std::string gnuplot_script(const Plot& plot) {
  std::string s =
      fmt::format("set encoding utf8\nset terminal svg size {},{} dynamic noenhanced font \"Helvetica,12\"\n",
                  plot.width_px, plot.height_px);
  s += "set border 3 lc rgb \"#444444\"\nset tics nomirror out scale 0.6 tc rgb \"#333333\"\n"
       "set grid lt 1 lw 0.6 lc rgb \"#e3e3e3\"\nset key outside top right horizontal samplen 2\n"
       "set boxwidth 0.95 relative\nset minussign\nset lmargin 11\nset rmargin 3\n";
  if (!plot.title.empty()) s += "set title " + quoted(plot.title) + "\n";
  s += "set xlabel " + quoted(plot.x_label) + "\nset ylabel " + quoted(plot.y_label) + "\n";
  if (plot.log_x) s += "set logscale x\nset format x \"%g\"\n";
  if (plot.log_y) s += "set logscale y\nset format y \"%g\"\n";
  if (plot.zero_line) s += "set xzeroaxis lt 1 lw 0.8 lc rgb \"#888888\"\n";
  if (plot.x_range)
    s += fmt::format("set xrange [{:.9g}:{:.9g}]\n", plot.x_range->first, plot.x_range->second);
  if (!plot.x_tics.empty()) {
    std::string tics;
    for (const auto& [x, name] : plot.x_tics)
      tics += fmt::format("{}{} {:.7g}", tics.empty() ? "" : ", ", quoted(name), x);
    s += "set xtics (" + tics + ")\nset boxwidth 0.7 absolute\n";
  }
  if (plot.y_range)
    s += fmt::format("set yrange [{:.9g}:{:.9g}]\n", plot.y_range->first, plot.y_range->second);
  std::string blocks, commands;
  int k = 0;
  for (const Series& series : plot.series) {
    FT_CHECK(series.x.size() == series.y.size(), "a plot series has as many x as y values");
    FT_CHECK(series.labels.empty() || series.labels.size() == series.x.size(),
             "a plot series has no labels or one per value");
    FT_CHECK(series.style != Series::Style::band || series.y_low.size() == series.y.size(),
             "a band has as many lower as upper values");
    if (!has_data(series)) continue;
    blocks += fmt::format("$d{} << EOD\n", k);
    for (std::size_t i = 0; i < series.x.size(); ++i) blocks += data_row(series, i);
    blocks += "EOD\n";
    commands += fmt::format("{} $d{} {} title {}", commands.empty() ? "plot" : ",", k, style_words(series),
                            quoted(series.title));
    ++k;
    const std::string labels = series.labels.empty() ? "" : label_block(series);
    if (labels.empty()) continue;
    blocks += fmt::format("$d{} << EOD\n{}EOD\n", k, labels);
    commands +=
        fmt::format(", $d{} with labels left offset 0.9,0.5 tc rgb {} notitle", k, quoted(series.color));
    ++k;
  }
  return s + blocks + commands + "\n";
}

std::string plot_svg(const Plot& plot, const std::string& id) {
  bool drawable = false;
  for (const Series& series : plot.series) drawable = drawable || has_data(series);
  if (!drawable) throw UserError(ExitCode::input, "plot \"" + plot.title + "\"", "there are no data to draw");
  const auto result = run_process({"gnuplot"}, gnuplot_script(plot));
  // posix_spawnp reports a missing program as a failure to start, or as status 127 from the child
  if (!result || result->status == 127)
    throw UserError(ExitCode::usage, "gnuplot", "the program is not installed, so no plot can be drawn",
                    "install the Debian package gnuplot-nox (make deps)");
  if (result->status != 0 || result->out.find("</svg>") == std::string::npos)
    throw UserError(ExitCode::internal, "gnuplot",
                    "could not draw \"" + plot.title + "\": " + result->err.substr(0, 300));
  return inline_svg(result->out, id);
}

std::vector<std::string> plots_or_sentences(const std::vector<Plot>& plots, const std::string& id_prefix) {
  std::vector<std::future<std::string>> pending;
  for (std::size_t i = 0; i < plots.size(); ++i)
    pending.push_back(std::async(std::launch::async, [&plots, i, &id_prefix] {
      try {
        return plot_svg(plots[i], fmt::format("{}{}-", id_prefix, i));
      } catch (const UserError& error) {
        return "<p class=\"missing\">Plot left out: " + escape_html(error.what()) + ".</p>";
      }
    }));
  std::vector<std::string> out;
  for (auto& p : pending) out.push_back(p.get());
  return out;
}

Histogram histogram(const std::vector<float>& values, int bins, double low, double high) {
  FT_CHECK(bins >= 1 && low < high, "a histogram needs a positive number of bins and low < high");
  Histogram h{low, (high - low) / bins, std::vector<std::size_t>(static_cast<std::size_t>(bins), 0)};
  for (float value : values) {
    const double v = static_cast<double>(value);
    if (!std::isfinite(v)) continue;
    if (v < low)
      ++h.n_below;
    else if (v > high)
      ++h.n_above;
    else
      ++h.counts[std::min(static_cast<std::size_t>((v - low) / h.bin_width), h.counts.size() - 1)];
  }
  return h;
}

Series histogram_series(const Histogram& h, const std::string& title, const std::string& color) {
  Series s;
  s.title = title;
  s.style = Series::Style::bars;
  s.color = color;
  std::size_t total = h.n_below + h.n_above;
  for (std::size_t c : h.counts) total += c;
  for (std::size_t i = 0; i < h.counts.size(); ++i) {
    s.x.push_back(h.low + (static_cast<double>(i) + 0.5) * h.bin_width);
    s.y.push_back(total == 0 ? 0.0 : 100.0 * static_cast<double>(h.counts[i]) / static_cast<double>(total));
  }
  return s;
}

}  // namespace fringetwin::report
