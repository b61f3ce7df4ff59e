// SPDX-License-Identifier: Apache-2.0
#include "report/plot/plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "report/html_page.hpp"
#include "report/process.hpp"
#include "report/text.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::report::plot_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

bool has_gnuplot() {
  const auto result = run_process({"gnuplot", "--version"}, "");
  return result && result->status == 0;
}

Plot example() {
  Plot plot;
  plot.title = "a \"quoted\" \\ title <1>";
  plot.x_label = "column [px]";
  plot.y_label = "Φ [rad]";
  Series s;
  s.title = "real_subscript^no";
  for (int i = 0; i < 500; ++i) {
    s.x.push_back(i);
    s.y.push_back(i == 100 ? std::nan("") : std::sin(0.05 * i));
  }
  plot.series = {s};
  return plot;
}

TEST(Plot, DrawsInlineSvg) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  const std::string svg = plot_svg(example(), "one-");
  EXPECT_TRUE(svg.starts_with("<svg"));
  EXPECT_THAT(svg, HasSubstr("</svg>"));
  EXPECT_THAT(svg, HasSubstr("Φ [rad]"));
  EXPECT_THAT(svg, HasSubstr("real_subscript^no"));
  EXPECT_THAT(svg, HasSubstr("a \"quoted\" \\ title &lt;1>"));
  EXPECT_THAT(svg, Not(HasSubstr("id='gp")));
  EXPECT_THAT(svg, HasSubstr("id='one-gpDot'"));
  EXPECT_EQ(svg, plot_svg(example(), "one-"));
}

TEST(Plot, AllStylesAndLogAxes) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  Plot plot;
  plot.log_x = plot.log_y = true;
  for (auto style : {Series::Style::line, Series::Style::dashed, Series::Style::points, Series::Style::bars,
                     Series::Style::band}) {
    Series s;
    s.style = style;
    s.x = {1, 10, 100};
    s.y = {2, 20, 200};
    s.y_low = {1, 10, 100};
    plot.series.push_back(s);
  }
  EXPECT_THAT(plot_svg(plot, "a-"), HasSubstr("</svg>"));
}

TEST(Plot, IdsAndWordsCannotLeaveTheirPlace) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  Plot plot = example();
  const auto file = std::filesystem::temp_directory_path() / "fringetwin_plot_pwned";
  std::filesystem::remove(file);
  plot.title = "`touch " + file.string() + "`";  // gnuplot runs what stands between back quotes
  // gnuplot takes NUL for the end of its line: the quote, the bracket and the next line would be code
  plot.x_label = std::string("\\\0", 2);
  plot.y_label = "\n!touch " + file.string() + "\nsystem(\"touch " + file.string() + "\")";
  plot.series[0].title = "\033[2J\r\x85";
  const std::string svg = plot_svg(plot, "x'><script>alert(1)</script>");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_EQ(gnuplot_text(std::string("a\\\0b", 4)), "\"a\\\\?b\"");
  EXPECT_NE(safe_id("a b"), safe_id("a_b"));
  EXPECT_EQ(safe_id("gray-left"), "gray-left");
}

TEST(Plot, NamedPositionsAndLabelledPoints) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  Plot plot;
  plot.log_y = true;
  plot.x_tics = {{1.0, "depth of field"}, {2.0, "shadow & light"}};
  Series s;
  s.style = Series::Style::points;
  s.point_type = 8;
  s.x = {1.0, 2.0, 3.0};
  s.y = {1e-3, 2e-2, std::nan("")};
  s.labels = {"the \"first\"", "", "unseen"};
  plot.series = {s};
  const std::string svg = plot_svg(plot, "t-");
  EXPECT_THAT(svg, HasSubstr("depth of field"));
  EXPECT_THAT(svg, HasSubstr("shadow &amp; light"));
  EXPECT_THAT(svg, HasSubstr("the \"first\""));
  EXPECT_THAT(svg, Not(HasSubstr("unseen")));
}

TEST(Plot, WhiskersAndBarsAcross) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  Plot plot;
  plot.many_digits = true;
  Series s{.title = "mean",
           .x = {1, 2},
           .y = {1e6 + 1e-3, 1e6 + 2e-3},
           .y_low = {1e6, 1e6},
           .style = Series::Style::whiskers};
  plot.series = {s};
  EXPECT_THROW(gnuplot_script(plot), std::logic_error);  // whiskers without an upper end
  s.y_high = {1e6 + 3e-3, 1e6 + 3e-3};
  plot.series = {s};
  EXPECT_THAT(gnuplot_script(plot), HasSubstr("1 1000000.001 1000000 1000000.003"));
  EXPECT_THAT(plot_svg(plot, "w-"), HasSubstr("000000.002"));  // the tics tell the values apart
  Plot bars;
  bars.y_tics = {{0.0, "noise"}, {1.0, "a \"calibration\""}};
  Series across{.title = "total", .x = {0.7, -0.1}, .y = {0, 1}, .style = Series::Style::bars_across};
  Series ends = across;
  ends.style = Series::Style::whiskers_across;
  ends.x_low = {0.5, -0.2};
  ends.x_high = {0.9, 0.1};
  bars.series = {across, ends};
  EXPECT_THAT(gnuplot_script(bars), HasSubstr("-0.1 1 -0.1 0 "));
  EXPECT_THAT(gnuplot_script(bars), HasSubstr("0.7 0 0.5 0.9"));
  EXPECT_THAT(plot_svg(bars, "b-"), HasSubstr("a \"calibration\""));
}

TEST(Plot, AFileOfItsOwnStandsOnWhite) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  const std::string inline_svg = plot_svg(example(), "s-"), file = standalone_svg(inline_svg);
  EXPECT_TRUE(file.starts_with("<?xml"));
  EXPECT_THAT(file, HasSubstr("xmlns=\"http://www.w3.org/2000/svg\""));
  EXPECT_THAT(file, HasSubstr("fill=\"#ffffff\"/>"));
  EXPECT_THAT(inline_svg, Not(HasSubstr("gpPt"))) << "symbols that are not drawn";
}

TEST(Plot, MissingGnuplotIsAClearErrorAndASentenceOnThePage) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nonexistent", 1);
  std::string words;
  try {
    plot_svg(example(), "x-");
  } catch (const UserError& error) {
    words = error.what();
    EXPECT_EQ(error.code(), ExitCode::usage);
  }
  const std::string sentence = plots_or_sentences({example()}, "x")[0];
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(words, HasSubstr("gnuplot-nox"));
  EXPECT_THAT(sentence, HasSubstr("gnuplot-nox"));
  EXPECT_THAT(sentence, StartsWith(std::string(kUndrawn)));
}

TEST(Plot, IsReachedByKeyUnderItsNameWhereItScrolls) {
  if (!has_gnuplot()) GTEST_SKIP() << "SKIPPED: gnuplot is not installed";
  Plot plot = example();
  plot.title = "a \"b\"";
  plot.width_px = 620;
  const std::string framed = plots_or_sentences({plot}, "k")[0];
  EXPECT_THAT(framed,
              StartsWith("<div class=\"drawing\" style=\"--least: 476px\" tabindex=\"0\" role=\"group\" "
                         "aria-label=\"Plot: a &quot;b&quot;\"><svg role=\"img\""));
  EXPECT_TRUE(framed.ends_with("</svg>\n</div>\n")) << framed;
}

TEST(Plot, NoDataIsASentence) {
  Plot plot;
  plot.title = "empty";
  plot.series = {Series{"", {1.0}, {std::nan("")}, {}}};
  EXPECT_THROW(plot_svg(plot, "x-"), UserError);
  const std::string sentence = plots_or_sentences({plot}, "x")[0];
  EXPECT_THAT(sentence, HasSubstr("no data"));
  EXPECT_THAT(sentence, Not(StartsWith(std::string(kUndrawn)))) << "nothing is wrong with gnuplot";
}

TEST(Plot, HistogramCountsEverything) {
  const Histogram h = histogram({-2, -1, -0.5, 0, 0.5, 1, 3, std::nanf("")}, 2, -1, 1);
  EXPECT_EQ(h.n_below, 1u);
  EXPECT_EQ(h.n_above, 1u);
  EXPECT_EQ(h.counts[0], 2u);  // -1, -0.5
  EXPECT_EQ(h.counts[1], 3u);  // 0, 0.5, 1 (the upper end belongs to the last bin)
  const Series s = histogram_series(h, "", color::kReal);
  EXPECT_DOUBLE_EQ(s.x[0], -0.5);
  EXPECT_DOUBLE_EQ(s.y[1], 100.0 * 3 / 7);
}

TEST(Page, VerdictFirstEverythingEscapedNothingLoaded) {
  Page page;
  page.title = "a <b>";
  page.verdict = "fail";
  page.summary_html = "<p>summary</p>";
  page.note = "note & more";
  page.warnings = {"first <w>"};
  page.sections = {{"one", "One & two", figure_html("<svg></svg>", "caption <c>", "y = a < b", "cmd 'x'")}};
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("<h1>a &lt;b&gt;</h1>"));
  EXPECT_THAT(html, HasSubstr("<a href=\"#one\">One &amp; two</a>"));
  EXPECT_THAT(html, HasSubstr("<li>first &lt;w&gt;</li>"));
  EXPECT_THAT(html, HasSubstr("note &amp; more"));
  EXPECT_THAT(html, HasSubstr("y = a &lt; b"));
  EXPECT_THAT(html, HasSubstr("<svg></svg>"));
  EXPECT_LT(html.find("<p>summary</p>"), html.find("id=\"one\""));
  EXPECT_THAT(html, Not(HasSubstr("://")));
  EXPECT_THAT(html, HasSubstr("default-src 'none'"));  // and the browser would load nothing
  EXPECT_THAT(html, Not(HasSubstr("{{")));
  EXPECT_THAT(Page{}.html(), Not(HasSubstr("class=\"warnings\"")));
}

}  // namespace
}  // namespace fringetwin::report::plot_test
