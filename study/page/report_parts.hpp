// SPDX-License-Identifier: Apache-2.0
// What the pages of all kinds of studies have in common; internal to study/.
#pragma once
#include <string>
#include <vector>

#include "report/html_page.hpp"
#include "study/page/study_report.hpp"

namespace fringetwin::study {

/// Bands and intervals of designs.
inline constexpr double kReportCoverage = 0.95;

/// Twin, runs done and failed, traces saved, times, hosts and versions.
std::string head_table(const StudyRecord& study);
/// A section of the reasons with the number of points, where anything failed.
void add_failures(const StudyRecord& study, report::Page* page);
/// Command, versions, files with their SHA-256.
std::string footer_html(const StudyRecord& study);
/// What was uncertain, with its distribution.
std::string inputs_table(const UncertainInputs& inputs);
/// A page with title, subtitle, head and footer; the sections come between.
report::Page page_of(const StudyRecord& study, const std::string& subtitle);

/// "name [unit]", unless the name says it
std::string with_unit(const std::string& name, const std::string& unit);
/// Some of many, and which: "the first 8 of 20"; empty when all are shown.
std::string shown_of(std::size_t shown, std::size_t all);

/// Log axis for values that are positive and span more than a decade.
bool spans_a_decade(const std::vector<double>& values);
/// All values agree to four digits: tics need more.
bool needs_many_digits(const std::vector<double>& values);

}  // namespace fringetwin::study
