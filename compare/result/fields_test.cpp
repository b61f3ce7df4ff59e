// SPDX-License-Identifier: Apache-2.0
// The description of the result is whole: every key has a meaning, its own standard error, an explanation in
// docs/metrics; and what is written has no key that is not described.
#include "compare/result/fields.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "compare/result/fit_json.hpp"
#include "compare/result/fit_keys.hpp"
#include "compare/result/tables.hpp"
#include "compare/verdict/limits.hpp"
#include "tests/support/compare/synthetic_sides.hpp"

namespace fringetwin::compare::fields_test {
namespace {

using ::testing::IsEmpty;

/// Calls `see(path, is_list, fields)` for every table and every table in a row of it.
template <class See>
void walk(const std::string& path, bool is_list, const std::vector<Field>& all, const See& see) {
  see(path + (is_list ? "[]" : ""), all);
  for (const Field& field : all)
    if (field.kind == Kind::rows) walk(path + (is_list ? "[]." : ".") + field.key, true, field.rows(), see);
}

template <class See>
void walk_all(const See& see) {
  for (const Table& table : tables()) walk(table.key, table.is_list, table.fields(), see);
}

/// One line per fault of the description of a row.
std::vector<std::string> faults(const std::string& path, const std::vector<Field>& all) {
  std::vector<std::string> out;
  std::set<std::string> seen;
  for (const Field& field : all) {
    const auto fault = [&](const std::string& what) { out.push_back(path + " " + field.key + ": " + what); };
    if (!seen.insert(field.key).second) fault("is there twice");
    if (field.meaning.size() < 5) fault("has no meaning");
    if (is_sigma_key(field.key) != (field.role == Field::Role::sigma)) fault("is it a standard error?");
    if (!field.sigma.empty()) {
      const Field* sigma = find_field(all, field.sigma);
      if (!sigma || sigma->role != Field::Role::sigma) fault("its standard error is no field");
    }
    for (const char* unit : {"_mm", "_px", "_rad", "_dn"})
      if (field.key.ends_with(unit) && "_" + field.unit != unit && field.unit != "DN")
        fault("its unit is another");
    if (field.column && field.column->style == Column::Style::with_sigma && field.sigma.empty())
      fault("is shown with a standard error that it lacks");
    if (field.column && !field.column->sigma.empty() && !find_field(all, field.column->sigma))
      fault("is shown with a standard error that is no field");
    if (field.limit && (field.limit->name.empty() || field.limit->meaning.empty()))
      fault("its limit says nothing");
  }
  return out;
}

TEST(Fields, EveryKeyOfEveryTableIsDescribed) {
  walk_all([](const std::string& path, const std::vector<Field>& all) {
    EXPECT_FALSE(all.empty()) << path;
    EXPECT_THAT(faults(path, all), IsEmpty());
  });
  EXPECT_THAT(faults("fits[]", fit_fields()), IsEmpty());
}

TEST(Fields, AFaultInADescriptionIsFound) {
  Fields<GrayRow> f;
  f.add("mean_dn", "", &GrayRow::mean_dn).sigma = "mean_sigma_dn";
  f.add("mean_dn", "mean difference", &GrayRow::rms_dn).in("mm");
  f.add("spread_mm", "scatter of the rows", &GrayRow::rms_dn).in("px");
  EXPECT_EQ(faults("gray[]", f.take()).size(), 5u);
}

TEST(Fields, ALimitIsOneThingAndStandsOnAListOfRows) {
  std::map<std::string, std::string> meanings;
  const auto see = [&](const std::string& path, const std::vector<Field>& all) {
    for (const Field& field : all)
      if (field.limit) {
        EXPECT_EQ(meanings.emplace(field.limit->name, field.limit->meaning).first->second,
                  field.limit->meaning);
        EXPECT_TRUE(path.ends_with("[]") && path.find('.') == std::string::npos) << path << " " << field.key;
      }
  };
  walk_all(see);
  see("fits[]", fit_fields());
  EXPECT_EQ(meanings.size(), limits_by_name().size());
}

/// The keys of a row in JSON that no field describes.
std::vector<std::string> unknown_keys(const report::Json& row, const std::vector<Field>& all) {
  std::vector<std::string> out;
  for (const auto& [key, value] : row.items())
    if (!find_field(all, key)) out.push_back(key);
  return out;
}

TEST(Fields, EveryKeyThatAFitWritesIsDescribed) {
  testing::SyntheticSides scene = testing::make_sides({});
  const Comparison c = compare(scene.twin, scene.real, scene.simulated, {});
  ASSERT_FALSE(c.fits.empty());
  for (const FitRow& row : c.fits) {
    const report::Json json = fit_row_json(row);
    for (const char* side : {"simulated", "real", "difference"})
      EXPECT_THAT(unknown_keys(json[side], fit_fields()), IsEmpty()) << side;
  }
  for (const char* kind : {"sphere", "plane", "cylinder"})
    for (const std::string& key : keys_of_fit(kind)) EXPECT_TRUE(find_field(fit_fields(), key)) << key;
  report::Json planted = fit_row_json(c.fits[0])["simulated"];
  planted["surprise_mm"] = 1.0;
  EXPECT_EQ(unknown_keys(planted, fit_fields()).size(), 1u);
}

struct Reading {
  std::string camera;
  double mean_dn = 0.0, rms_dn = 0.0;
  std::uint64_t n = 0;

  static void describe(auto& f) {
    f.add("n", "values used", &Reading::n);
    f.name("camera", "camera of the twin", &Reading::camera);
    f.add("mean_dn", "mean of the values", &Reading::mean_dn);
    f.positive("rms_dn", "rms of the values", &Reading::rms_dn);
  }
};

TEST(Fields, ARowBecomesAnObjectInTheOrderOfItsFields) {
  EXPECT_EQ(row_json(Reading{"left", 0.5, std::nan(""), 7}).dump(),
            R"({"n":7,"camera":"left","mean_dn":0.5,"rms_dn":null})");
  ExplainedRow explained;
  EXPECT_FALSE(row_json(explained).contains("worst"));
  explained.worst = "radius_mm";
  EXPECT_EQ(row_json(explained)["worst"], "radius_mm");
  EXPECT_TRUE(row_json(BudgetVerdict{})["gray"].is_null());
}

/// Every text in backticks.
std::vector<std::string> in_backticks(const std::string& text) {
  static const std::regex span("`([^`\n]+)`");
  std::vector<std::string> out;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), span); at != std::sregex_iterator(); ++at)
    out.push_back((*at)[1]);
  return out;
}

/// The sections of the pages in docs/metrics, by what stands in backticks in their headings: "gain[]".
std::map<std::string, std::string> metrics_sections() {
  const char* root = std::getenv("FRINGETWIN_SOURCE");
  std::map<std::string, std::string> out;
  for (const auto& page :
       std::filesystem::directory_iterator(std::filesystem::path(root ? root : ".") / "docs/metrics")) {
    std::ifstream in(page.path());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    for (std::size_t at = text.find("\n## "); at != std::string::npos;) {
      const std::size_t next = text.find("\n## ", at + 1);
      const std::string section = text.substr(at + 1, next - at - 1);
      for (const std::string& name : in_backticks(section.substr(0, section.find('\n'))))
        EXPECT_TRUE(out.emplace(name, section).second) << name << " has two sections";
      at = next;
    }
  }
  return out;
}

/// The keys of a row, and the limits on them, that this section does not explain.
std::vector<std::string> unexplained(const std::string& section, const std::vector<Field>& all) {
  static const std::regex word("[A-Za-z0-9_]+");
  std::set<std::string> explained;
  for (const std::string& inside : in_backticks(section))
    for (auto w = std::sregex_iterator(inside.begin(), inside.end(), word); w != std::sregex_iterator(); ++w)
      explained.insert(w->str());
  std::vector<std::string> out;
  for (const Field& field : all) {
    if (!explained.contains(field.key)) out.push_back(field.key);
    if (field.limit && !explained.contains(field.limit->name)) out.push_back(field.limit->name);
  }
  return out;
}

TEST(Fields, TheSectionOfATableExplainsEveryKeyAndEveryLimit) {
  std::map<std::string, std::string> sections = metrics_sections();
  const auto see = [&](const std::string& path, const std::vector<Field>& all) {
    const std::string table = path.substr(0, path.find('.'));
    EXPECT_TRUE(sections.contains(table)) << "no heading in docs/metrics names " << table;
    EXPECT_THAT(unexplained(sections[table], all), IsEmpty()) << path;
  };
  walk_all(see);
  see("fits[]", fit_fields());
  Fields<GrayRow> planted;
  planted.add("surprise_dn", "a number that no document explains", &GrayRow::mean_dn)
      .limited({"surprise", "a limit that no document explains"});
  EXPECT_EQ(unexplained(sections["gray[]"], planted.take()).size(), 2u);
}

}  // namespace
}  // namespace fringetwin::compare::fields_test
