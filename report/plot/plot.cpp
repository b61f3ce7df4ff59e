// SPDX-License-Identifier: Apache-2.0
#include "report/plot/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>

#include "report/plot/plot_axes.hpp"
#include "report/process.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::report {
namespace {

std::string quoted(const std::string& text) { return gnuplot_text(text); }

constexpr double kHalfBar = 0.16;  // of bars across, whose places are 1 apart or 1/3 side by side

std::string data_row(const Series& s, std::size_t i) {
  if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) return "\n";  // a blank line breaks the curve
  if (s.style == Series::Style::band)
    return fmt::format("{:.10g} {:.10g} {:.10g}\n", s.x[i], s.y_low[i], s.y[i]);
  if (s.style == Series::Style::whiskers)
    return fmt::format("{:.10g} {:.10g} {:.10g} {:.10g}\n", s.x[i], s.y[i], s.y_low[i], s.y_high[i]);
  if (s.style == Series::Style::bars_across)
    return fmt::format("{0:.10g} {1:.10g} {2:.10g} {3:.10g} {4:.10g} {5:.10g}\n", s.x[i], s.y[i],
                       std::min(0.0, s.x[i]), std::max(0.0, s.x[i]), s.y[i] - kHalfBar, s.y[i] + kHalfBar);
  if (s.style == Series::Style::whiskers_across)
    return fmt::format("{:.10g} {:.10g} {:.10g} {:.10g}\n", s.x[i], s.y[i], s.x_low[i], s.x_high[i]);
  return fmt::format("{:.10g} {:.10g}\n", s.x[i], s.y[i]);
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
    case Series::Style::whiskers:
      return fmt::format("with yerrorbars pt {} ps {} lw 1.2 lc rgb {}", s.point_type, 0.3 * s.width,
                         quoted(s.color));
    case Series::Style::bars_across:
      return fmt::format("with boxxyerror fs solid 0.75 noborder lc rgb {}", quoted(s.color));
    case Series::Style::whiskers_across:
      return fmt::format("with xerrorbars pt 0 lw 1.2 lc rgb {}", quoted(s.color));
  }
  return "";
}

/// The labels as a second drawing of the same points.
std::string label_block(const Series& s) {
  std::string out;
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (std::isfinite(s.x[i]) && std::isfinite(s.y[i]) && !s.labels[i].empty())
      out += fmt::format("{:.10g} {:.10g} {}\n", s.x[i], s.y[i], quoted(s.labels[i]));
  return out;
}

bool has_data(const Series& s) {
  for (std::size_t i = 0; i < s.x.size(); ++i)
    if (std::isfinite(s.x[i]) && std::isfinite(s.y[i])) return true;
  return false;
}

/// The lines that are needed: gnuplot writes groups without content, blank lines and all of its symbols.
std::string compact(const std::string& svg) {
  std::vector<std::string> lines;
  std::istringstream in(svg);
  for (std::string line; std::getline(in, line);) {
    line.erase(0, line.find_first_not_of("\t\r "));
    while (!line.empty() && line.back() == ' ') line.pop_back();
    if (line.empty()) continue;
    const bool opens = !lines.empty() && lines.back().starts_with("<g ") &&
                       lines.back().find('>') + 1 == lines.back().size();
    if (line == "</g>" && opens)
      lines.pop_back();
    else
      lines.push_back(line);
  }
  // Symbols refer to earlier ones, so from the last on.
  std::vector<const std::string*> kept;
  for (std::size_t i = lines.size(); i-- > 0;) {
    const std::string& line = lines[i];
    if (const std::size_t at = line.find("id='gpPt"); at != std::string::npos) {
      const std::size_t end = line.find('\'', at + 4);
      const std::string use = "'#" + line.substr(at + 4, end - at - 4) + "'";
      if (std::ranges::none_of(kept, [&](const auto* k) { return k->find(use) != std::string::npos; }))
        continue;
    }
    kept.push_back(&line);
  }
  std::string out;
  for (auto line = kept.rbegin(); line != kept.rend(); ++line) out += **line + "\n";
  return out;
}

/// One HTML page holds many plots: gnuplot's ids would collide.
std::string inline_svg(std::string svg, const std::string& unsafe_id) {
  const std::string id = safe_id(unsafe_id);
  svg = compact(svg.substr(svg.find("<svg")));
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

/// "\"a\" 1, \"b\" 2"
std::string named_tics(const std::vector<std::pair<double, std::string>>& tics) {
  std::string out;
  for (const auto& [at, name] : tics)
    out += fmt::format("{}{} {:.10g}", out.empty() ? "" : ", ", quoted(name), at);
  return out;
}

/// Names that would run into each other are written aslant.
bool too_long_for_a_row(const Plot& plot) {
  std::size_t letters = 0;
  for (const auto& [x, name] : plot.x_tics) letters += name.size() + 2;
  return static_cast<int>(letters) * 7 > plot.width_px - 100;
}

/// Returns what gnuplot writes, an SVG. Throws UserError, at once for the plots after one that had no end.
std::string run_gnuplot(const Drawing& drawing) {
  static std::atomic<bool> has_no_end = false;
  if (has_no_end)
    throw UserError(ExitCode::usage, "gnuplot", "did not end with an earlier plot, so no other is drawn",
                    "see which gnuplot is the first in PATH");
  throw_if_cancelled();  // run_process() goes on after a Ctrl-C that came before
  const auto result = run_process({"gnuplot"}, drawing.script);
  const int error = result ? 0 : errno;
  // posix_spawnp reports a missing program as a failure to start, or as status 127 from the child
  if (error == ENOENT || (result && result->status == 127))
    throw UserError(ExitCode::usage, "gnuplot", "the program is not installed, so no plot can be drawn",
                    "install the Debian package gnuplot-nox (make deps)");
  if (!result)
    throw UserError(ExitCode::usage, "gnuplot", fmt::format("cannot be started ({})", std::strerror(error)));
  const std::string& svg = result->out;
  const std::size_t begin = svg.find("<svg"), end = svg.rfind("</svg>");
  const bool whole = begin != std::string::npos && end != std::string::npos && begin < end;
  const bool ended = result->killed_for.empty();
  if (!ended) has_no_end = true;
  if (!ended || result->status != 0 || !whole)
    throw UserError(ExitCode::internal, "gnuplot",
                    "could not draw \"" + drawing.title +
                        "\": " + (ended ? result->err.substr(0, 300) : result->killed_for));
  return svg;
}

void check_sizes(const Series& s) {
  using Style = Series::Style;
  const std::size_t n = s.x.size();
  FT_CHECK(s.y.size() == n, "a plot series has as many x as y values");
  FT_CHECK(s.labels.empty() || s.labels.size() == n, "a plot series has no labels or one per value");
  FT_CHECK((s.style != Style::band && s.style != Style::whiskers) || s.y_low.size() == n,
           "a band has as many lower as upper values");
  FT_CHECK(s.style != Style::whiskers || s.y_high.size() == n, "whiskers have two ends");
  FT_CHECK(s.style != Style::whiskers_across || (s.x_low.size() == n && s.x_high.size() == n),
           "whiskers have two ends");
}

/// Returns what the drawing is called where it is read out.
std::string label_of(const Drawing& drawing) { return drawing.title.empty() ? "plot" : drawing.title; }

/// Returns a drawing's SVG in the frame that it scrolls in on a narrow screen (page_template.cpp).
std::string in_frame(const Drawing& drawing, const std::string& svg) {
  return fmt::format(
      "<div class=\"drawing\" style=\"--least: {}px\" tabindex=\"0\" role=\"group\" "
      "aria-label=\"Plot: {}\">{}</div>\n",
      drawing.least_px, escape_html(label_of(drawing)), svg);
}

}  // namespace

std::string gnuplot_text(const std::string& text) {
  std::string out = "\"";            // enhanced text is off, so only \ and " need care
  for (char c : plain_text(text)) {  // it takes NUL for the end of a line, and runs what follows
    if (c == '"' || c == '\\') out += '\\';
    // between back quotes gnuplot would run a command, in double quotes, too
    out += c == '`' ? '\'' : c;
  }
  return out + '"';
}

std::string gnuplot_head(int width_px, int height_px) {
  return fmt::format(
             "set encoding utf8\nset terminal svg size {},{} dynamic noenhanced font \"Helvetica,{}\"\n",
             width_px, height_px, kLetters_px) +
         "set border 3 lc rgb \"#444444\"\nset tics nomirror out scale 0.6 tc rgb \"#333333\"\n"
         "set grid lt 1 lw 0.6 lc rgb \"#e3e3e3\"\nset key outside top right horizontal samplen 2\n"
         "set boxwidth 0.95 relative\nset minussign\nset lmargin 11\nset rmargin 3\n";
}

int least_width_px(int width_px, int smallest_letters_px) {
  return static_cast<int>(std::ceil(9.2 * width_px / smallest_letters_px));
}

std::string gnuplot_script(const Plot& as_given) {
  const Plot plot = with_fitting_units(as_given);
  std::string s = gnuplot_head(plot.width_px, plot.height_px);
  if (!plot.title.empty()) s += "set title " + quoted(plot.title) + "\n";
  s += "set xlabel " + quoted(plot.x_label) + "\nset ylabel " + quoted(plot.y_label) + "\n";
  if (plot.log_x) s += "set logscale x\nset format x \"%g\"\n";
  if (plot.log_y) s += "set logscale y\nset format y \"%g\"\n";
  if (plot.zero_line)
    s +=
        std::string("set ") + (plot.y_tics.empty() ? "x" : "y") + "zeroaxis lt 1 lw 0.8 lc rgb \"#888888\"\n";
  if (plot.x_range)
    s += fmt::format("set xrange [{:.9g}:{:.9g}]\n", plot.x_range->first, plot.x_range->second);
  const auto [x_low, x_high] = x_extent(plot);
  const auto [y_low, y_high] = y_extent(plot);
  const std::string x_format = plot.log_x || !plot.x_tics.empty() ? "" : tic_format(x_low, x_high),
                    y_format = plot.log_y || !plot.y_tics.empty() ? "" : tic_format(y_low, y_high);
  if (!x_format.empty()) s += "set format x " + quoted(x_format) + "\n";
  if (!y_format.empty()) s += "set format y " + quoted(y_format) + "\nset lmargin 14\n";
  if (plot.many_digits && y_format.empty()) s += "set format y \"%.10g\"\nset lmargin 14\n";
  if (!plot.x_tics.empty())
    s += fmt::format("set xtics ({}){}\nset boxwidth 0.7 absolute\n", named_tics(plot.x_tics),
                     too_long_for_a_row(plot) ? " rotate by 25 right" : "");
  if (!plot.y_tics.empty()) {
    std::size_t longest = 0;
    for (const auto& [y, name] : plot.y_tics) longest = std::max(longest, name.size());
    s += fmt::format("set ytics ({})\nset lmargin {}\n", named_tics(plot.y_tics), longest + 4);
  }
  if (plot.y_range)
    s += fmt::format("set yrange [{:.9g}:{:.9g}]\n", plot.y_range->first, plot.y_range->second);
  std::string blocks, commands;
  int k = 0;
  for (const Series& series : plot.series) {
    check_sizes(series);
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

Drawing drawing(const Plot& plot) {
  const std::string name = !plot.title.empty()    ? plot.title
                           : plot.y_label.empty() ? plot.x_label
                           : plot.x_label.empty() ? plot.y_label
                                                  : plot.y_label + " against " + plot.x_label;
  for (const Series& series : plot.series)
    if (has_data(series)) return {name, gnuplot_script(plot), least_width_px(plot.width_px)};
  return {name, ""};
}

std::string drawing_svg(const Drawing& drawing, const std::string& id) {
  if (drawing.script.empty())
    throw UserError(ExitCode::input, "plot \"" + drawing.title + "\"", "there are no data to draw");
  std::string svg = inline_svg(run_gnuplot(drawing), id);
  // for readers who hear the page
  svg.insert(std::string_view("<svg").size(),
             " role=\"img\" aria-label=\"" + escape_html(label_of(drawing)) + "\"");
  return svg;
}

std::string plot_svg(const Plot& plot, const std::string& id) { return drawing_svg(drawing(plot), id); }

std::vector<std::string> drawings_or_sentences(const std::vector<Drawing>& drawings,
                                               const std::string& id_prefix) {
  std::vector<std::string> out(drawings.size());
  for_each_parallel(static_cast<int>(drawings.size()), [&](int i) {
    try {
      out[i] = in_frame(drawings[i], drawing_svg(drawings[i], fmt::format("{}{}-", id_prefix, i)));
    } catch (const UserError& error) {
      const bool no_data = error.code() == ExitCode::input;
      out[i] = (no_data ? "<p class=\"missing\">Plot left out: " : std::string(kUndrawn)) +
               escape_html(error.what()) + ".</p>";
    }
  });
  return out;
}

std::vector<std::string> plots_or_sentences(const std::vector<Plot>& plots, const std::string& id_prefix) {
  std::vector<Drawing> drawings;
  for (const Plot& plot : plots) drawings.push_back(drawing(plot));
  return drawings_or_sentences(drawings, id_prefix);
}

std::string standalone_svg(const std::string& inline_svg) {
  const std::size_t end = inline_svg.find('>');
  FT_CHECK(inline_svg.starts_with("<svg") && end != std::string::npos, "a drawing as SVG");
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n" + inline_svg.substr(0, end + 1) +
         "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>" + inline_svg.substr(end + 1);
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
  Series s{.title = title, .style = Series::Style::bars, .color = color};
  std::size_t total = h.n_below + h.n_above;
  for (std::size_t c : h.counts) total += c;
  for (std::size_t i = 0; i < h.counts.size(); ++i) {
    s.add(h.low + (static_cast<double>(i) + 0.5) * h.bin_width,
          total == 0 ? 0.0 : 100.0 * static_cast<double>(h.counts[i]) / static_cast<double>(total));
  }
  return s;
}

}  // namespace fringetwin::report
