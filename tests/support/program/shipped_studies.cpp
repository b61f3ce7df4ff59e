// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/shipped_studies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing {

namespace fs = std::filesystem;

fs::path shipped_studies() { return dataset_twin("studies").parent_path(); }

/// A shipped study with some of its text replaced, run beside its twins.
std::vector<StudyRow> run_shipped_study(const std::string& name, const Replacements& replace) {
  std::string text = read_file(shipped_studies() / (name + ".toml"));
  Replacements all = replace;
  all.emplace_back("twin = \"", "twin = \"" + shipped_studies().string() + "/");
  for (const auto& [from, to] : all) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << name << " has no " << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
  }
  const fs::path dir = scratch_folder(name);
  write_file(dir / "study.toml", text);
  const RunResult done =
      run_fringetwin({"study", (dir / "study.toml").string(), "--out", (dir / "out").string()});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  std::istringstream lines(read_file(dir / "out/study.csv"));
  const auto cells = [](const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line)
      if (c == ',')
        out.emplace_back();
      else if (c != '\r')
        out.back() += c;
    return out;
  };
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = cells(line);
  std::vector<StudyRow> rows;
  while (std::getline(lines, line)) {
    const std::vector<std::string> values = cells(line);
    EXPECT_EQ(values.size(), names.size());
    StudyRow row;
    for (std::size_t i = 0; i < names.size() && i < values.size(); ++i) row[names[i]] = values[i];
    rows.push_back(row);
  }
  return rows;
}

/// Runs of equal settings follow each other.
std::map<std::string, std::vector<StudyRow>> grouped(const std::vector<StudyRow>& rows,
                                                     const std::vector<std::string>& columns) {
  std::map<std::string, std::vector<StudyRow>> groups;
  for (const StudyRow& row : rows) {
    std::string name;
    for (const std::string& key : columns) name += row.at(key) + " ";
    groups[name].push_back(row);
  }
  return groups;
}

double number(const StudyRow& row, const std::string& key) {
  const std::string& text = row.at(key);
  return text.empty() ? std::nan("") : std::stod(text);
}

double mean(const std::vector<StudyRow>& rows, const std::string& key) {
  double sum = 0.0;
  for (const StudyRow& row : rows) sum += number(row, key);
  return sum / static_cast<double>(rows.size());
}

double deviation(const std::vector<StudyRow>& rows, const std::string& key) {
  const double middle = mean(rows, key);
  double sum = 0.0;
  for (const StudyRow& row : rows) sum += std::pow(number(row, key) - middle, 2);
  return std::sqrt(sum / static_cast<double>(rows.size() - 1));
}

std::map<std::string, double> deviation_ratios(const std::vector<StudyRow>& rows,
                                               const std::vector<std::string>& numbers) {
  std::map<std::string, double> out;
  for (const std::string& name : numbers)
    out[name] = deviation(rows, name) / mean(rows, name + ".expected_sigma");
  return out;
}

}  // namespace fringetwin::testing
