// SPDX-License-Identifier: Apache-2.0
// Makes the parts that the pages of all kinds of studies have in common; internal to study/.
#pragma once
#include <string>
#include <vector>

#include "report/html_page.hpp"
#include "study/page/figure_sheet.hpp"
#include "study/plan/study_head.hpp"
#include "study/store/study_store.hpp"
#include "study/uncertain/uncertain_inputs.hpp"

namespace fringetwin::study {

/// Holds what the page of every study is made from (docs/metrics/study.md, "Report of a study").
struct StudyRecord {
  const StudyHead& head;
  const std::vector<StoredPoint>& rows;
  const StudyIdentity& identity;
  std::vector<std::string> argv;  ///< the command as typed
  std::string version;            ///< of the program that writes the page
};

/// The share of the values that bands and intervals of designs hold.
inline constexpr double kReportCoverage = 0.95;

/// Returns the table of runs done and failed, traces saved, times, hosts and versions.
std::string head_table(const StudyRecord& study);
/// Adds a section of the reasons with the number of points, where anything failed.
void add_failures(const StudyRecord& study, report::Page* page);
/// Returns command, versions, and files with their SHA-256.
std::string footer_html(const StudyRecord& study);
/// Returns the table of what was uncertain, with its distribution.
std::string inputs_table(const UncertainInputs& inputs);
/// Returns a page with title, subtitle, head and footer; the sections come between.
report::Page page_of(const StudyRecord& study, const std::string& subtitle);

/// Returns "name [unit]", or the name alone where it says the unit.
std::string with_unit(const std::string& name, const std::string& unit);
/// Returns a name of at most so many letters; a longer one ends in an ellipsis.
std::string shortened(const std::string& name, std::size_t most = 24);
/// Returns which of many are shown, "the first 8 of 20"; an empty string when all are.
std::string shown_of(std::size_t shown, std::size_t all);

/// Returns true for values that are positive and span more than a decade: they take a log axis.
bool spans_a_decade(const std::vector<double>& values);
/// Returns true where all values agree to three digits: tics need more.
bool needs_many_digits(const std::vector<double>& values);

}  // namespace fringetwin::study
