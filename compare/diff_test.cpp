// SPDX-License-Identifier: Apache-2.0
#include "compare/diff.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <sstream>

#include "compare/result/result_json.hpp"
#include "compare/result/tables.hpp"
#include "tests/support/compare/synthetic_sides.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::compare::diff_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::filesystem::path write_run(const std::string& name, const testing::SidesTruth& t,
                                const Provenance& provenance = {}) {
  const auto dir = std::filesystem::temp_directory_path() / ("fringetwin_diff_" + name);
  std::filesystem::create_directories(dir);
  const testing::SyntheticSides scene = testing::make_sides(t);
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  std::ofstream(dir / "result.json") << comparison_json(scene.twin, c, provenance, {});
  return dir;
}

TEST(Diff, PairsNumbersByName) {
  testing::SidesTruth t;
  const auto a = write_run("a", t);
  t.gain_dn = 18.0;
  const auto b = write_run("b", t);
  const std::string text = differences_text(diff_results(a, b / "result.json"));
  EXPECT_THAT(text, HasSubstr("gain left gain_dn"));
  EXPECT_THAT(text, HasSubstr("phase left x rms_rad"));
  EXPECT_THAT(text, HasSubstr("fit ball simulated center_mm[2]"));
  EXPECT_THAT(text, Not(HasSubstr("sigma")));
  EXPECT_THAT(text, Not(HasSubstr("only in")));
  const std::size_t line = text.find("gain left gain_dn");
  double va = 0, vb = 0, d = 0, z = 0;
  ASSERT_EQ(std::sscanf(text.c_str() + line + 17, "%lf %lf %lf %lf", &va, &vb, &d, &z), 4);
  EXPECT_NEAR(va, 17.3, 0.05);
  EXPECT_NEAR(vb, 18.0, 0.05);
  EXPECT_NEAR(d, vb - va, 2e-5);
  EXPECT_GT(z, 20.0);
}

/// The words after a quantity's name: A, B, B - A, z.
std::vector<std::string> fields(const std::string& text, const std::string& name) {
  std::istringstream in(text.substr(text.find("\n" + name + " ") + 1 + name.size()));
  std::vector<std::string> out(4);
  for (std::string& word : out) in >> word;
  return out;
}

TEST(Diff, SharedImagesGiveNoZForWhatIsMadeFromThem) {
  const auto image = std::filesystem::temp_directory_path() / "fringetwin_diff_image.png";
  const auto toml = std::filesystem::temp_directory_path() / "fringetwin_diff_twin.toml";
  std::ofstream(image) << "an image";
  std::ofstream(toml) << "a twin";
  Provenance both;
  both.inputs_sha256 = sha256_of_files({image, toml});
  Provenance twin_only;
  twin_only.inputs_sha256 = sha256_of_files({toml});
  const testing::SidesTruth t;
  const auto a = write_run("shared_a", t, both), b = write_run("shared_b", t, both);
  const auto c = write_run("shared_c", t, twin_only);
  const std::string shared = differences_text(diff_results(a, b)),
                    apart = differences_text(diff_results(a, c));
  EXPECT_EQ(fields(shared, "gain left gain_dn").at(3), "-");
  EXPECT_EQ(fields(shared, "fit ball real radius_mm").at(3), "-");
  EXPECT_EQ(fields(shared, "fit ball simulated radius_mm").at(3), "0.00");
  EXPECT_THAT(shared, HasSubstr("1 image files in common"));
  EXPECT_EQ(fields(apart, "gain left gain_dn").at(3), "0.00");
  EXPECT_THAT(apart, Not(HasSubstr("in common")));
}

TEST(Diff, IsJsonToo) {
  testing::SidesTruth t;
  const auto a = write_run("a", t);
  t.gain_dn = 18.0;
  t.cameras = 2;
  const auto b = write_run("b", t);
  const Differences found = diff_results(a, b);
  const auto json = nlohmann::json::parse(differences_json(found));
  EXPECT_EQ(json["schema"], "fringetwin-diff/1");
  EXPECT_EQ(json["b"], b.string());
  EXPECT_EQ(json["verdict_a"], found.verdict_a);
  ASSERT_EQ(json["differences"].size(), found.rows.size());
  const auto row = std::ranges::find(json["differences"], "gain left gain_dn",
                                     [](const nlohmann::json& r) { return r["name"].get<std::string>(); });
  ASSERT_NE(row, json["differences"].end());
  EXPECT_NEAR((*row)["difference"].get<double>(), 0.7, 0.1);
  EXPECT_GT((*row)["z"].get<double>(), 20.0);
  EXPECT_TRUE(std::ranges::any_of(json["differences"], [](const auto& r) { return r["z"].is_null(); }));
  EXPECT_THAT(json["only_in_b"].dump(), HasSubstr("gain right gain_dn"));
  EXPECT_TRUE(json["only_in_a"].empty());
}

TEST(Diff, ListsWhatOnlyOneRunHas) {
  testing::SidesTruth t;
  const auto a = write_run("a", t);
  t.cameras = 2;
  const auto b = write_run("c", t);
  EXPECT_THAT(differences_text(diff_results(a, b)), HasSubstr("only in B: gain right gain_dn"));
  EXPECT_THAT(differences_text(diff_results(b, a)), HasSubstr("only in A: gain right gain_dn"));
}

TEST(Diff, CountsManyNumbersOfOnePart) {
  Differences d;
  for (int k = 0; k < 30; ++k) d.only_in_a.push_back("causes tested pose " + std::to_string(k));
  d.only_in_a.emplace_back("gain left sigma");
  const std::string text = differences_text(d);
  EXPECT_THAT(text,
              HasSubstr("only in A: 30 numbers of causes (--json names them)\nonly in A: gain left sigma\n"));
  EXPECT_THAT(text, Not(HasSubstr("pose 7")));
}

/// A value of this field that differs from run to run.
report::Json example(const Field& field, double number);

report::Json example_row(const std::vector<Field>& fields, double number) {
  report::Json row = report::Json::object();
  for (const Field& field : fields) row[field.key] = example(field, number);
  return row;
}

report::Json example(const Field& field, double number) {
  switch (field.kind) {
    case Kind::text:
      return "the_" + field.key;
    case Kind::texts:
      return {"the_" + field.key};
    case Kind::flag:
      return true;
    case Kind::count:
      return static_cast<int>(number);
    case Kind::vector:
      return {number, number, number};
    case Kind::numbers:
      return {number, number};
    case Kind::matrix:
      return {{number}};
    case Kind::rows:
      return report::Json::array({example_row(field.rows(), number)});
    default:
      return number;
  }
}

/// A result with one row in every table.
std::filesystem::path write_full_result(const std::string& name, double number) {
  report::Json json = {{"schema", "fringetwin-result/1"}, {"verdict", "pass"}};
  for (const Table& table : tables()) {
    const report::Json row = example_row(table.fields(), number);
    json[table.key] = table.is_list ? report::Json::array({row}) : row;
  }
  const auto file = std::filesystem::temp_directory_path() / ("fringetwin_diff_" + name + ".json");
  std::ofstream(file) << json;
  return file;
}

/// Every number of a row, and of the rows in it, has a line.
void expect_lines(const std::string& text, const std::string& prefix, const std::vector<Field>& all) {
  std::string row = prefix;
  for (const Field& field : all)
    if (field.role == Field::Role::name) row += " the_" + field.key;
  for (const Field& field : all) {
    const std::string name = row + " " + field.key;
    if (field.kind == Kind::rows)
      expect_lines(text, name, field.rows());
    else if (field.kind == Kind::number || field.kind == Kind::positive || field.kind == Kind::count)
      EXPECT_EQ(text.find("\n" + name + " ") != std::string::npos, field.role != Field::Role::sigma) << name;
    else if (field.kind == Kind::numbers)
      EXPECT_EQ(text.find("\n" + name + "[1] ") != std::string::npos, field.role != Field::Role::sigma)
          << name;
    else if (field.kind == Kind::matrix) {
      EXPECT_THAT(text, HasSubstr("\n" + name + "[0][0] "));
    }
  }
}

TEST(Diff, CoversEveryTable) {
  const std::string text =
      differences_text(diff_results(write_full_result("full_a", 2.0), write_full_result("full_b", 5.0)));
  for (const Table& table : tables()) expect_lines(text, table.key, table.fields());
  EXPECT_THAT(text, Not(HasSubstr("only in")));
  EXPECT_EQ(fields(text, "refinement parameters the_name after").at(3), "0.56");  // 3 / hypot(2, 5)
  EXPECT_EQ(fields(text, "indicators the_name the_objects real").at(3), "0.56");
  EXPECT_EQ(fields(text, "gray the_camera the_pattern rms_dn").at(3), "-");  // no standard error
}

void expect_refused(const std::string& content, const std::string& words) {
  const testing::ScratchFolder folder;
  const auto file = folder.write("bad.json", content);
  try {
    diff_results(file, file);
    FAIL() << content;
  } catch (const UserError& error) {
    EXPECT_EQ(error.code(), ExitCode::input);
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

TEST(Diff, RefusesWhatIsNoResult) {
  expect_refused("{\"schema\": \"other/1\"}", "no fringetwin result");
  expect_refused("{\"schema\": ", "no JSON");
  expect_refused("[1, 2]", "no fringetwin result");
  EXPECT_THROW(diff_results("/nowhere", "/nowhere"), UserError);
}

std::string result_with(const std::string& rest) {
  return R"({"schema": "fringetwin-result/1", )" + rest + "}";
}

TEST(Diff, RefusesValuesOfTheWrongType) {
  expect_refused("{\"schema\": 1}", "no fringetwin result");
  expect_refused(result_with(R"("gain": 3)"), "gain is number, a list of rows is expected");
  expect_refused(result_with(R"("gain": "none")"), "gain is string, a list of rows is expected");
  expect_refused(result_with(R"("gain": [3])"), "a row of gain is number, a table is expected");
  expect_refused(result_with(R"("fits": "none")"), "fits is string, a list of rows is expected");
  expect_refused(result_with(R"("fits": [{"object": 3}])"), "object is number, a text is expected");
  expect_refused(result_with(R"("fits": [{"object": "b", "real": [1]}])"),
                 "real is array, a table is expected");
  expect_refused(result_with(R"("fits": [{"object": "b", "real": {"radius_mm": "19"}}])"),
                 "fit b real radius_mm is string, a number is expected");
  expect_refused(result_with(R"("fits": [{"object": "b", "real": {"center_mm": [1, {}, 2]}}])"),
                 "fit b real center_mm[1] is object, a number is expected");
  expect_refused(result_with(R"("gain": [{"camera": "left", "gain_dn": "17"}])"),
                 "gain left gain_dn is string, a number is expected");
  expect_refused(result_with(R"("verdict": [])"), "verdict is array, a text is expected");
  expect_refused(result_with(R"("gain": [{"gain_dn": 1e999}])"), "1e999");
  expect_refused(result_with(R"("gain": [{"camera": ")" + std::string(2000, 'a') + R"("}])"), "at most 1000");
  for (const char* rest :
       {R"("provenance": 3)", R"("provenance": {"inputs_sha256": 3})", R"("gain": null)"}) {
    const testing::ScratchFolder folder;
    const auto file = folder.write("odd.json", result_with(rest));
    EXPECT_THAT(differences_text(diff_results(file, file)), HasSubstr("no number is in both"));
  }
}

TEST(Diff, ReadsAHundredThousandNumbersAtOnce) {
  std::string numbers = "1";
  for (int i = 1; i < 100'000; ++i) numbers += ",1";
  const testing::ScratchFolder folder;
  const auto file = folder.write(
      "many.json", result_with(R"("fits": [{"object": "a\u001b[2J", "real": {"x_mm": [)" + numbers + "]}}]"));
  const std::clock_t begin = std::clock();
  const std::string text = differences_text(diff_results(file, file));
  EXPECT_THAT(text, HasSubstr("fit a?[2J real x_mm[99999]"));
  // of computing: half a minute when each name was looked for, without the sanitizers
  EXPECT_LT((std::clock() - begin) / CLOCKS_PER_SEC, 20);
}

}  // namespace
}  // namespace fringetwin::compare::diff_test
