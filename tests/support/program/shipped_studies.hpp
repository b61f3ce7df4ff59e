// SPDX-License-Identifier: Apache-2.0
// Runs the studies that come with the program, with some of their text replaced, and reads their tables.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace fringetwin::testing {

/// One line of study.csv by column.
using StudyRow = std::map<std::string, std::string>;
using Replacements = std::vector<std::pair<std::string, std::string>>;

/// <source>/datasets/studies
std::filesystem::path shipped_studies();

/// Runs NAME.toml of them, each first text replaced by the second; a failure of the test when one is not
/// there.
std::vector<StudyRow> run_shipped_study(const std::string& name, const Replacements& replace);

/// Rows of equal values of these columns.
std::map<std::string, std::vector<StudyRow>> grouped(const std::vector<StudyRow>& rows,
                                                     const std::vector<std::string>& columns);

/// NaN where the cell is empty.
double number(const StudyRow& row, const std::string& column);
double mean(const std::vector<StudyRow>& rows, const std::string& column);
/// n - 1.
double deviation(const std::vector<StudyRow>& rows, const std::string& column);

/// A study of noise against the closed form: of each number the standard deviation over the seeds by the
/// expected one.
std::map<std::string, double> deviation_ratios(const std::vector<StudyRow>& rows,
                                               const std::vector<std::string>& numbers);

}  // namespace fringetwin::testing
