// SPDX-License-Identifier: Apache-2.0
// Warnings of columns that stay empty, on rows made by hand.
// tolerance: none, sentences are compared as they are.
#include "study/kind/empty_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/small_twin.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::empty_columns_test {
namespace {
using namespace fringetwin::study;
using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

const Settings sharp = {{"camera.left.psf_px", "0"}}, blurred = {{"camera.left.psf_px", "2"}},
               no_twin = {{"camera.left.psf_px", "-1"}};

class EmptyColumns : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = scratch_folder("empty_columns");
    write_file(folder / "twin.toml", small_twin());
    head_.file = folder / "STUDY.toml";
    head_.twin = folder / "twin.toml";
    head_.records = {{"fits.ball.measured.radius_mm", "r"},
                     {"theory.ball.radius_sigma_mm", "r.expected_sigma"}};
    head_.content = {{"record[0].result", "as in records"}};
  }
  void add(const Settings& settings, std::map<std::string, double> numbers,
           PointStatus status = PointStatus::done) {
    StoredPoint row;
    row.point = {static_cast<std::int64_t>(rows_.size()), settings, 1};
    row.status = status;
    row.outcome.numbers = std::move(numbers);
    rows_.push_back(row);
  }
  std::vector<std::string> warnings() const { return empty_column_warnings(head_, rows_); }
  StudyHead head_;
  std::vector<StoredPoint> rows_;
};

TEST_F(EmptyColumns, TellsOnceForHowManyPointsTheTheoryHasNoNumber) {
  for (int seed = 0; seed < 2; ++seed) add(sharp, {{"r", 19.0}, {"r.expected_sigma", 0.01}});
  for (int seed = 0; seed < 2; ++seed) add(blurred, {{"r", 19.1}, {"r.expected_sigma", kNan}});
  add(no_twin, {}, PointStatus::failed);
  EXPECT_THAT(warnings(),
              ElementsAre("the theory of the noise has no number for 2 of 4 points, their columns of it are "
                          "empty: it does not know camera.left.psf_px = 2 (2 points)"));
}

TEST_F(EmptyColumns, ReasonsOfManyValuesAreCutShort) {
  for (const char* value : {"1", "2", "3", "4", "5"})
    add({{"camera.left.psf_px", value}}, {{"r", 19.0}, {"r.expected_sigma", kNan}});
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("camera.left.psf_px = 3 (1 point) and 2 more like these")));
}

TEST_F(EmptyColumns, TheFormOfASphereIsNotInTheTheory) {
  add({{"uncertainty.form.ball", "[1, 0.01, 2, 12]"}}, {{"r", 19.0}, {"r.expected_sigma", kNan}});
  EXPECT_THAT(warnings(), ElementsAre(HasSubstr("does not know the uncertain form of \"ball\"")));
}

TEST_F(EmptyColumns, TellsWhatIsNullInAllRuns) {
  head_.records = {{"fits.ball.method_bias.radius_mm", "bias"}, {"acquisition.time_s", ""}, {"fits.n", "n"}};
  add(sharp, {{"bias", kNan}, {"acquisition.time_s", kNan}, {"n", kNan}});
  add(sharp, {{"bias", kNan}, {"acquisition.time_s", kNan}, {"n", 3.0}});
  EXPECT_THAT(warnings(),
              ElementsAre("\"bias\" is null in all 2 runs: a study does not measure the bias of the method; "
                          "`fringetwin measure --method-bias` does, of one capture",
                          "\"acquisition.time_s\" is null in all 2 runs"));
  head_.content.clear();
  EXPECT_THAT(warnings(), IsEmpty()) << "records that the kind of study makes by itself";
  rows_.clear();
  EXPECT_THAT(warnings(), IsEmpty()) << "nothing was run";
}

TEST_F(EmptyColumns, AStudyWhollyOutsideOfTheTheoryIsRefused) {
  EXPECT_NO_THROW(refuse_outside_noise_theory(head_, {{0, blurred, 1}, {1, sharp, 1}}));
  EXPECT_NO_THROW(refuse_outside_noise_theory(head_, {{0, no_twin, 1}}));
  const PointSequence all_outside = {{0, no_twin, 1}, {1, blurred, 1}, {2, blurred, 2}};
  try {
    refuse_outside_noise_theory(head_, all_outside);
    ADD_FAILURE() << "accepted";
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_THAT(e.what(), HasSubstr("no point has a number for \"r.expected_sigma\": the theory of the noise "
                                    "does not know camera.left.psf_px = 2"));
  }
  head_.records.pop_back();
  EXPECT_NO_THROW(refuse_outside_noise_theory(head_, all_outside)) << "nothing asks the theory";
}

}  // namespace
}  // namespace fringetwin::testing::empty_columns_test
