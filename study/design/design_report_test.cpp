// SPDX-License-Identifier: Apache-2.0
// The page of a design made of rows by hand.
// tolerance: none, numbers as they are printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "study/design/design_figures.hpp"
#include "study/design/design_plan.hpp"
#include "study/design/design_table.hpp"
#include "study/study_file.hpp"
#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"

namespace fringetwin::study::design_report_test {
namespace {

using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::Not;
using testing::write_file, testing::small_twin;

const std::string head = "schema = \"fringetwin-study/1\"\nname = \"a <b>\"\ntwin = \"twin.toml\"\n";
const std::string record = "[[record]]\nresult = \"fits.ball.measured.radius_mm\"\nname = \"r<i>\"\n";

/// A study whose rows are made by `value` of (id, seed).
struct Made {
  StudyFile file;
  StudyIdentity identity;
  std::vector<StoredPoint> rows;
  const DesignPlan& plan() const { return std::get<DesignPlan>(file.plan); }
  StudyReport report() const { return design_report(record(), plan()); }
  DesignTable table() const { return design_table(file.head, plan(), rows, 0.95); }
  StudyRecord record() const { return {file.head, rows, identity, {"fringetwin", "study", "a b"}, "1.2.3"}; }
};
template <class Value>
Made make(const std::string& study, Value value) {
  const auto dir = testing::scratch_folder("design_report");
  write_file(dir / "twin.toml", small_twin());
  write_file(dir / "STUDY.toml", head + study);
  Made out{load_study(dir / "STUDY.toml"), {}, {}};
  for (const StudyPoint& point : design_points(out.plan())) {
    StoredPoint row;
    row.point = point;
    row.status = PointStatus::done;
    row.version = "0.9";
    row.host = "node<1>";
    row.outcome.seconds = 2.0;
    row.outcome.traced = point.id % 2 == 0;
    row.outcome.numbers["r<i>"] = value(point);
    out.rows.push_back(row);
  }
  return out;
}

const std::string grid = R"(noise_seeds = 3
[[vary]]
keys = ["camera.left.sensor.gain_dn", "projector.intensity"]
values = [20, 400]
[[vary]]
key = "fringes.pitches_px"
values = [[13, 14, 15], [26, 28, 30]]
)";

TEST(DesignTable, AxesSettingsAndErrorsAgainstTheTwin) {
  // radius 19 mm is put in
  const Made made = make(grid + record, [](const StudyPoint& p) {
    return 19.0 + (p.settings.at("projector.intensity") == "400" ? 0.5 : 0.25) +
           0.1 * (static_cast<double>(p.seed) - 2.0);
  });
  const DesignTable table = made.table();
  ASSERT_EQ(table.axes.size(), 2u);
  EXPECT_TRUE(table.axes[0].numeric);
  EXPECT_TRUE(table.axes[0].log);  // more than a decade
  EXPECT_THAT(table.axes[0].values, ElementsAre(20.0, 400.0));
  EXPECT_FALSE(table.axes[1].numeric);
  EXPECT_THAT(table.axes[1].names, ElementsAre("[13, 14, 15]", "[26, 28, 30]"));
  EXPECT_EQ(table.settings.size(), 4u);
  ASSERT_EQ(table.numbers.size(), 1u);
  const TableNumber& n = table.numbers[0];
  EXPECT_TRUE(n.is_error);
  EXPECT_EQ(n.unit, "mm");
  EXPECT_NEAR(n.all.mean, 0.375, 1e-12);
  EXPECT_NEAR(n.all.sigma, 0.1, 1e-12);
}

TEST(DesignTable, TheTruthFollowsTheSettings) {
  const Made made = make(
      "[[vary]]\nkey = \"object.ball.radius_mm\"\nrange = [10, 20]\ncount = 3\n"
      "[[vary]]\nkey = \"projector.blur_px\"\nvalues = [0, 1]\n" +
          record,
      [](const StudyPoint& p) { return 1.5 + std::stod(p.settings.at("object.ball.radius_mm")); });
  const TableNumber n = made.table().numbers[0];
  EXPECT_THAT(n.truth, ElementsAre(10.0, 10.0, 15.0, 15.0, 20.0, 20.0));
  EXPECT_NEAR(n.all.mean, 1.5, 1e-12);
}

TEST(DesignReport, MeansBandsAndNamesAsTheyAre) {
  const Made made = make(
      grid + record, [](const StudyPoint& p) { return 19.25 + 0.1 * (static_cast<double>(p.seed) - 2.0); });
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("Study “a &lt;b&gt;”"));
  EXPECT_THAT(report.html, HasSubstr("r&lt;i&gt;"));
  EXPECT_THAT(report.html, Not(HasSubstr("<i>")));
  EXPECT_THAT(report.html, Not(HasSubstr("node<1>")));
  EXPECT_THAT(report.html, HasSubstr("<td class=\"r\">0.2500</td>"));  // the mean error
  EXPECT_THAT(report.html, HasSubstr("0.1000 (0.0521 … 0.628)"));      // chi-square, 2 degrees of freedom
  EXPECT_THAT(report.html, HasSubstr("for 6 of 12: 6 traces saved"));
  EXPECT_THAT(report.html, HasSubstr("Scatter over 3 seeds"));
  EXPECT_THAT(report.html, HasSubstr("fringetwin study &#39;a b&#39;"));
  EXPECT_THAT(report.html, Not(HasSubstr("<!--figure")));
  EXPECT_THAT(report.html, Not(HasSubstr("class=\"failures")));
  // mean and sigma, against two parameters and their pair
  ASSERT_EQ(report.figures.size(), 6u);
  EXPECT_EQ(report.figures[0].first, "r-i-gain_dn-mean");
  EXPECT_THAT(report.figures[0].second, HasSubstr("</svg>"));
}

TEST(DesignReport, FailuresAreCountedAndLeftOut) {
  Made made = make(grid + record, [](const StudyPoint&) { return 20.0; });
  for (const std::size_t i : {0u, 1u, 7u}) {
    made.rows[i].status = PointStatus::failed;
    made.rows[i].outcome = {
        made.rows[i].point.id, true, i == 7 ? "another <reason>" : "the ball is gone", {}, 0.0, true};
  }
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("3 of 12 runs failed"));
  EXPECT_THAT(report.html,
              HasSubstr("<td class=\"r\">2</td><td class=\"r\">0</td><td class=\"l\">the ball is gone</td>"));
  EXPECT_THAT(report.html, HasSubstr("another &lt;reason&gt;"));
  EXPECT_THAT(report.html, HasSubstr("The seeds made no difference"));
  EXPECT_EQ(report.figures.size(), 3u);  // no sigma to draw
}

TEST(DesignReport, NothingMeasuredIsStillAPage) {
  Made made = make(grid + record, [](const StudyPoint&) { return std::nan(""); });
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("there are no data to draw"));
  EXPECT_THAT(report.html, Not(HasSubstr("The seeds made no difference")))
      << "there are no numbers to differ";
}

// What no noise can change says nothing of the seeds.
TEST(DesignReport, TheTheorysNumbersAreNotASignOfATwinWithoutNoise) {
  Made made = make(grid + record + "[[record]]\nresult = \"theory.ball.n\"\nname = \"n\"\n",
                   [](const StudyPoint&) { return std::nan(""); });
  for (StoredPoint& row : made.rows) row.outcome.numbers["n"] = 1000.0;
  EXPECT_THAT(made.report().html, Not(HasSubstr("The seeds made no difference")));
}

TEST(DesignReport, ScatteredPointsGetARunningMean) {
  const Made made = make(
      "design = \"sobol\"\npoints = 64\n[[vary]]\nkey = \"projector.intensity\"\nrange = [10, 20]\n"
      "[[vary]]\nkey = \"projector.blur_px\"\nrange = [0, 1]\n" +
          record,
      [](const StudyPoint& p) { return 19.0 + 0.01 * std::stod(p.settings.at("projector.intensity")); });
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("running mean"));
  EXPECT_THAT(report.html, HasSubstr("One run per setting"));
  EXPECT_EQ(report.figures.size(), 2u);  // no sigma, no pairs
}

TEST(DesignReport, MoreLevelsAreHarderToTellFromChance) {
  EXPECT_NEAR(coverage_of_extremes(2), 0.95, 1e-15);
  EXPECT_NEAR(coverage_of_extremes(5), 0.995, 1e-15);
  // Means 1 apart from seeds ± 0.1: Student's half widths (2 degrees of freedom, 0.1/√3) are 0.248 at 95 %,
  // so two levels are told apart; at 1 - 0.05/45 they are 1.73.
  const auto verdict = [](const std::string& levels) {
    return make("noise_seeds = 3\n[[vary]]\nkey = \"projector.intensity\"\n" + levels + record,
                [](const StudyPoint& p) {
                  return 19.0 + (p.settings.at("projector.intensity") == "10" ? 1.0 : 0.0) +
                         0.1 * (static_cast<double>(p.seed) - 2.0);
                })
        .report()
        .html;
  };
  EXPECT_THAT(verdict("values = [10, 20]\n"), HasSubstr("<td class=\"l\">yes</td>"));
  EXPECT_THAT(verdict("values = [10, 11, 12, 13, 14, 15, 16, 17, 18, 19]\n"),
              Not(HasSubstr("<td class=\"l\">yes</td>")));
}

TEST(DesignReport, AGridTooFineForAHeatMapIsSaid) {
  Made made = make(
      "[[vary]]\nkey = \"projector.intensity\"\nrange = [10, 20]\ncount = 600\n"
      "[[vary]]\nkey = \"projector.blur_px\"\nrange = [0, 1]\ncount = 150\n" +
          record,
      [](const StudyPoint& p) { return 19.0 + 0.01 * std::stod(p.settings.at("projector.intensity")); });
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("Heat maps of more than 3600 cells are left out: 1 pair of parameters"));
  EXPECT_THAT(report.html, HasSubstr("Of 600 levels 300 are drawn."));
  EXPECT_THAT(report.html, Not(HasSubstr("Of 150 levels")));
  EXPECT_EQ(report.figures.size(), 2u);  // no sigma, no pair
}

TEST(DesignReport, TimeAgainstUncertainty) {
  Made made = make(
      grid + record + "[[record]]\nresult = \"acquisition.time_s\"\nname = \"t\"\n", [](const StudyPoint& p) {
        return 19.0 + 0.01 * (1.0 + static_cast<double>(p.id / 3)) * (static_cast<double>(p.seed) - 2.0);
      });
  for (StoredPoint& row : made.rows) row.outcome.numbers["t"] = 2.0 - static_cast<double>(row.point.id / 6);
  const StudyReport report = made.report();
  EXPECT_THAT(report.html, HasSubstr("Time against uncertainty"));
  // Two times; at each the setting with the smaller sigma is on the front: 0.03 in 1 s, 0.01 in 2 s.
  EXPECT_THAT(report.html,
              HasSubstr("<td class=\"l\">A</td><td class=\"l\">gain_dn 400, pitches_px [13, 14, 15]</td><td "
                        "class=\"r\">1.000</td><td class=\"r\">0.0300</td>"));
  EXPECT_THAT(report.html,
              HasSubstr("<td class=\"l\">B</td><td class=\"l\">gain_dn 20, pitches_px [13, 14, 15]</td><td "
                        "class=\"r\">2.000</td><td class=\"r\">0.0100</td>"));
  EXPECT_THAT(report.html, Not(HasSubstr("pitches_px [26, 28, 30]</td><td class=\"r\">2.000</td>")));
  // The setting of B with the two seeds that lie closest only (scatter 0.007): it takes no part.
  made.rows[2].status = PointStatus::failed;
  EXPECT_THAT(made.report().html,
              HasSubstr("<td class=\"l\">B</td><td class=\"l\">gain_dn 20, pitches_px [26, 28, 30]</td><td "
                        "class=\"r\">2.000</td><td class=\"r\">0.0200</td>"));
}

}  // namespace
}  // namespace fringetwin::study::design_report_test
