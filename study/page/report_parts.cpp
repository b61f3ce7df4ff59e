// SPDX-License-Identifier: Apache-2.0
#include "study/page/report_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "report/provenance.hpp"
#include "report/table.hpp"
#include "report/text.hpp"
#include "study/plan/recorded_numbers.hpp"

namespace fringetwin::study {
namespace {

using report::number, report::text_column;

/// Counts and times of the runs that finished.
struct Totals {
  std::size_t done = 0, failed = 0, pending = 0, traced = 0;
  double traced_s = 0.0, other_s = 0.0;
  std::set<std::string> hosts, versions;
  std::string first, last;
};
Totals totals(const std::vector<StoredPoint>& rows) {
  Totals out;
  for (const StoredPoint& row : rows) {
    if (row.status == PointStatus::pending) {
      ++out.pending;
      continue;
    }
    ++(row.status == PointStatus::done ? out.done : out.failed);
    out.hosts.insert(row.host);
    out.versions.insert(row.version);
    if (out.first.empty() || row.finished_at < out.first) out.first = row.finished_at;
    out.last = std::max(out.last, row.finished_at);
    if (row.status != PointStatus::done) continue;
    out.traced += row.outcome.traced ? 1 : 0;
    (row.outcome.traced ? out.traced_s : out.other_s) += row.outcome.seconds;
  }
  return out;
}

std::string some(const std::set<std::string>& all) {
  constexpr std::size_t kMost = 4;
  std::vector<std::string> out;
  for (const std::string& name : all)
    if (out.size() < kMost) out.push_back(name.empty() ? "?" : name);
  return fmt::format("{}{}", fmt::join(out, ", "),
                     all.size() > kMost ? fmt::format(" and {} more", all.size() - kMost) : "");
}

}  // namespace

std::string head_table(const StudyRecord& study) {
  const Totals t = totals(study.rows);
  report::Table table;
  table.columns = {text_column("runs"), text_column("")};
  table.add_row({"finished", fmt::format("{} measured, {} failed{}", t.done, t.failed,
                                         t.pending > 0 ? fmt::format(", {} not yet run", t.pending) : "")});
  table.add_row(
      {"light traced", fmt::format("for {} of {}: {} traces saved", t.traced, t.done, t.done - t.traced)});
  const auto mean = [](double sum, std::size_t n) {
    return n == 0 ? "–" : number(sum / static_cast<double>(n), 3) + " s";
  };
  table.add_row({"time of a run", fmt::format("{} with a trace, {} with another run's; {} s of work in all",
                                              mean(t.traced_s, t.traced), mean(t.other_s, t.done - t.traced),
                                              number(t.traced_s + t.other_s, 4))});
  table.add_row({"run by", fmt::format("{} on {}", some(t.versions), some(t.hosts))});
  table.add_row({"finished between", fmt::format("{} and {}", t.first, t.last)});
  return table.html();
}

void add_failures(const StudyRecord& study, report::Page* page) {
  struct Reason {
    std::size_t n = 0;
    std::int64_t first = 0;
  };
  std::map<std::string, Reason> reasons;
  std::size_t failed = 0;
  for (const StoredPoint& row : study.rows) {
    if (row.status != PointStatus::failed) continue;
    ++failed;
    Reason& r = reasons[row.outcome.reason];
    if (r.n++ == 0) r.first = row.point.id;
  }
  if (failed == 0) return;
  std::vector<std::pair<std::string, Reason>> order(reasons.begin(), reasons.end());
  std::ranges::stable_sort(order, [](const auto& a, const auto& b) { return a.second.n > b.second.n; });
  constexpr std::size_t kMost = 20;
  report::Table table;
  table.columns = {{"runs"}, {"first id"}, text_column("reason")};
  for (std::size_t i = 0; i < std::min(kMost, order.size()); ++i)
    table.add_row({std::to_string(order[i].second.n), std::to_string(order[i].second.first), order[i].first});
  const std::string shown = shown_of(table.rows.size(), order.size());
  const std::string body = fmt::format(
      "<p>{} of {} runs failed; they are left out of every mean{}.</p>{}", failed, study.rows.size(),
      shown.empty() ? "" : " (" + shown + " reasons are listed)", table.html());
  page->sections.push_back({"failures", "Failures", body});
}

std::string footer_html(const StudyRecord& study) {
  report::Table content;
  content.columns = {text_column("key"), text_column("value")};
  for (const auto& [key, value] : study.head.content) content.add_row({key, value});
  return report::provenance_html({{"study", study.head.file.string()},
                                  {"twin", study.head.twin.string()},
                                  {"command", report::shell_command(study.argv)},
                                  {"page written by", study.version},
                                  {"digest of the study", study.identity.digest()}},
                                 study.identity.inputs) +
         fmt::format("<details><summary>The study, key by key</summary>{}</details>", content.html()) +
         "<p>Every run: study.csv beside this page. Every formula: docs/METRICS.md of the fringetwin source, "
         "“Report of a study”.</p>";
}

std::string inputs_table(const UncertainInputs& inputs) {
  report::Table out;
  out.caption = "What was uncertain.";
  out.columns = {text_column("input"), text_column("distribution"), {"spread"}, text_column("of")};
  for (const UncertainKey& key : inputs.keys) {
    std::string keys;
    for (std::size_t i = 0; i < key.keys.size(); ++i)
      keys += fmt::format("{}{} around {:.8g}", i > 0 ? ", " : "", key.keys[i], key.values[i]);
    const bool normal = key.distribution == Distribution::normal;
    out.add_row({key.name, normal ? "normal" : "uniform",
                 fmt::format("{} {:.4g}", normal ? "sigma" : "±", key.spread), keys});
  }
  for (const UncertainForm& form : inputs.forms)
    out.add_row({form.name, "normal", fmt::format("rms {:.4g} mm", form.spread.rms_mm),
                 fmt::format("spherical harmonics of {}, degrees {} to {}", form.object, form.spread.low,
                             form.spread.high)});
  if (inputs.calibration > 0)
    out.add_row({"calibration", "normal", "its covariance",
                 fmt::format("{} direction{}", inputs.calibration, inputs.calibration == 1 ? "" : "s")});
  if (inputs.noise) out.add_row({"noise", "of the sensors", "", "a seed of its own each"});
  return out.html();
}

report::Page page_of(const StudyRecord& study, const std::string& subtitle) {
  report::Page page;
  page.title = "Study “" + study.head.name + "”";
  page.subtitle = subtitle;
  page.summary_html = head_table(study);
  page.footer_html = footer_html(study);
  return page;
}

std::string with_unit(const std::string& name, const std::string& unit) {
  return unit.empty() || unit_of(name) == unit ? name : name + " [" + unit + "]";
}

std::string shortened(const std::string& name, std::size_t most) {
  std::size_t end = 0, letters = 0;  // whole UTF-8 letters
  while (end < name.size() && letters < most) {
    ++end;
    while (end < name.size() && (static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) ++end;
    ++letters;
  }
  return end < name.size() ? name.substr(0, end) + "…" : name;
}

std::string shown_of(std::size_t shown, std::size_t all) {
  return shown < all ? fmt::format("the first {} of {}", shown, all) : "";
}

bool spans_a_decade(const std::vector<double>& values) {
  double low = HUGE_VAL, high = 0.0;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    if (v <= 0.0) return false;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  return high > 10.0 * low;
}

bool needs_many_digits(const std::vector<double>& values) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const double v : values)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  return high > low && high - low < 1e-3 * std::max(std::abs(low), std::abs(high));
}

}  // namespace fringetwin::study
