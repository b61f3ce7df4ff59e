// SPDX-License-Identifier: Apache-2.0
#include "compare/page/answer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <utility>

#include "compare/causes/cause_decision.hpp"
#include "compare/page/moved_parts.hpp"
#include "compare/page/shown_by_images.hpp"
#include "compare/parameters/parameters.hpp"
#include "report/text.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

constexpr const char* kQuantities[] = {"coverage", "phase", "gray", "code", "geometry"};
constexpr int kFolds = 4;

/// Returns "a", "a and b", "a, b and c".
std::string listed(const std::vector<std::string>& names, const char* last = " and ") {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : last) + names[i];
  return text;
}

/// Returns by how much a row is beyond its limits; of those that state neither chi2 nor counts, 0.
double excess(const Comparison& c, const ExplainedRow& row) {
  if (row.quantity == "coverage") {
    double most = 0.0;
    for (const CoverageRow& counts : c.coverage)
      if (counts.camera == row.region) most = std::max(most, counts.excess());
    return most;
  }
  const double values = row.chi2 / row.chi2_limit, regions = row.regional_chi2 / row.regional_limit;
  return std::fmax(0.0, std::fmax(values, regions));
}

/// Returns the row that speaks for its quantity: of those in the worst state the one furthest off; null
/// without any.
const ExplainedRow* worst_row(const Comparison& c, const std::string& quantity) {
  const ExplainedRow* worst = nullptr;
  for (const ExplainedRow& row : c.explained) {
    if (row.quantity != quantity) continue;
    const bool worse =
                   !worst || (worst->state != row.state && worse_state(worst->state, row.state) == row.state),
               further = worst && worst->state == row.state && excess(c, row) > excess(c, *worst);
    if (worse || further) worst = &row;
  }
  return worst;
}

std::string size_text(const ExplainedRow& row) {
  const double rms = std::sqrt(row.observed);
  return row.unit == "mm" ? report::number(1000.0 * rms, 3) + " µm"
                          : report::number(rms, 3) + (row.unit.empty() ? "" : " " + row.unit);
}

/// Returns the first of the sentences on the row's state; of one on coverage, which goes on to say where the
/// pixels lie, how many they are.
std::string first_reason(const ExplainedRow& row) {
  return row.why.substr(0, row.why.find_first_of(row.quantity == "coverage" ? ",;" : ";"));
}

std::string difference_text(const ExplainedRow& row) {
  if (row.quantity == "geometry" && std::isfinite(row.chi2))
    return fmt::format("{} of {} differs by {}, {} standard errors", row.worst, row.region, size_text(row),
                       report::number(std::sqrt(row.chi2), 2));
  const std::string differs = fmt::format("{} differs", row.quantity);
  // What was fitted to the values leaves less than 1 of noise: the limit is then below 1, too.
  if (row.chi2 > row.chi2_limit) {
    const double times = std::sqrt(row.chi2 / std::min(1.0, row.chi2_limit));
    return fmt::format("{} by {} rms, {} times what noise and budget allow", differs, size_text(row),
                       report::number(times, times < 1.1 ? 3 : 2));
  }
  if (row.regional_chi2 > row.regional_limit)
    return fmt::format("{} by {} rms, no more than noise in single values, but {} times as much in regions",
                       differs, size_text(row), report::number(std::sqrt(row.regional_chi2), 2));
  return row.why.empty() ? row.quantity + " is not explained" : differs + ": " + first_reason(row);
}

std::string fault_text(const ExplainedRow& row) {
  if (row.state == kNotExplained) return difference_text(row);
  if (row.state == kNotCompared) return row.quantity + " could not be compared";
  return std::isfinite(row.too_wide_factor)
             ? fmt::format("the budget of {} is too wide to tell: {} times the noise of the images",
                           row.quantity, report::number(row.too_wide_factor, 2))
             : fmt::format("the budget of {} is too wide to tell", row.quantity);
}

/// Returns the causes that explain the difference, in words; those that cannot be told apart with "or".
std::string causes_text(const Causes& causes) {
  std::vector<std::string> alike;
  for (const std::string& together : causes.together) {
    std::vector<std::string> words;
    for (const std::string& group : groups_in(together)) {
      const auto row = std::ranges::find(causes.rows, group, &CauseRow::group);
      words.push_back(row == causes.rows.end() ? group : row->cause);
    }
    alike.push_back(listed(words));
  }
  return listed(alike, " or ");
}

/// Returns the area that the answer begins with and the next step is about; null without any.
const OtherSurfaceRow* largest_surface(const std::vector<OtherSurfaceRow>& surfaces) {
  const auto largest = std::ranges::max_element(surfaces, {}, &OtherSurfaceRow::n);
  return largest == surfaces.end() ? nullptr : &*largest;
}

/// Returns the largest of the areas in words, to stand before all else; empty without any.
std::string other_surface_text(const std::vector<OtherSurfaceRow>& surfaces) {
  const OtherSurfaceRow* largest = largest_surface(surfaces);
  if (!largest) return "";
  std::string text = largest->why;
  text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  const auto of_camera = std::ranges::count(surfaces, largest->camera, &OtherSurfaceRow::camera);
  return text + " (camera " + largest->camera + ")" +
         (of_camera > 1 ? fmt::format(" (the largest of {} such areas)", of_camera) : "");
}

std::string worst_of_all(const Comparison& c) {
  std::string worst;
  for (const ExplainedRow& row : c.explained) worst = worse_state(worst, row.state);
  return worst;
}

/// Returns the command of a command line: its first word but for the program's own options (`-q`, `--limits
/// 10`).
std::string command_of(const std::vector<std::string>& argv) {
  for (std::size_t i = 1; i < argv.size(); ++i) {
    if (!argv[i].starts_with('-')) return argv[i];
    if (argv[i] == "--limits") ++i;
  }
  return "";
}

/// Returns the command again with an option set to a value, written into FOLDER-`suffix`.
std::vector<std::string> again(const Twin& twin, std::vector<std::string> argv, const std::string& option,
                               const std::string& value, const std::string& suffix) {
  if (command_of(argv) != "cosim") {  // of compare, or from Python
    const auto out = std::ranges::find(argv, "--out");
    const bool named = out != argv.end() && out + 1 != argv.end();
    argv = {"fringetwin", "cosim", twin.file.string(), "--out", named ? *(out + 1) : "out"};
  }
  std::vector<std::string> command;
  for (std::size_t i = 0; i < argv.size(); ++i) {
    const auto is = [&](const std::string& name) {
      return argv[i] == name || argv[i].starts_with(name + "=");
    };
    const bool joined = argv[i].find('=') != std::string::npos;
    if (is(option)) {
      if (!joined) ++i;
    } else if (is("--out")) {
      std::string folder = joined ? argv[i].substr(6) : i + 1 < argv.size() ? argv[++i] : "out";
      while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
      command.insert(command.end(), {"--out", folder + suffix});
    } else
      command.push_back(argv[i]);
  }
  command.insert(command.end(), {option, value});
  return command;
}

/// Returns the command again with these words of `--refine`.
std::vector<std::string> refining(const Twin& twin, const std::vector<std::string>& argv,
                                  const std::vector<std::string>& words) {
  return again(twin, argv, "--refine", fmt::format("{}", fmt::join(words, ",")), "-refined");
}

/// Returns the words of `--refine` that this run had.
std::vector<std::string> refined_before(const Comparison& c) {
  return c.refinement ? c.refinement->asked : std::vector<std::string>{};
}

/// Returns the command without `--into`: a check leaves the twin as it is.
std::vector<std::string> without_into(std::vector<std::string> argv) {
  for (std::size_t i = 0; i < argv.size(); ++i) {
    if (argv[i] != "--into" && !argv[i].starts_with("--into=")) continue;
    const std::ptrdiff_t n = argv[i] == "--into" && i + 1 < argv.size() ? 2 : 1;
    argv.erase(argv.begin() + static_cast<std::ptrdiff_t>(i),
               argv.begin() + static_cast<std::ptrdiff_t>(i) + n);
    break;
  }
  return argv;
}

/// Returns the groups of an explanation as `--refine` takes them, those of this run's first; empty where it
/// does not fit one of them, or has just fitted all. In place of all places of rig and objects, which no
/// image tells from a motion of everything, those that moved.
std::vector<std::string> refine_words(const Comparison& c, const std::string& together) {
  std::vector<std::string> names = refined_before(c);
  const std::size_t before = names.size();
  const std::vector<std::string> groups = groups_in(together);
  const auto has = [](const std::vector<std::string>& all, const std::string& name) {
    return std::ranges::find(all, name) != all.end();
  };
  const bool all_may_move =
      has(groups, "rig") && has(groups, "pose") && !has(names, "rig") && !has(names, "pose");
  const std::vector<std::string> moved = all_may_move ? moved_parts(c.causes) : std::vector<std::string>{};
  std::ranges::copy_if(moved, std::back_inserter(names),
                       [&](const std::string& part) { return !has(names, part); });
  for (const std::string& name : groups) {
    if (!moved.empty() && (name == "rig" || name == "pose")) continue;
    const auto group = std::ranges::find(parameter_groups(), name, &ParameterGroup::name);
    if (group == parameter_groups().end() ? name != "texture" : !group->instead.empty()) return {};
    if (!has(names, name) && !has(c.causes.refined, name)) names.push_back(name);
  }
  return names.size() > before ? names : std::vector<std::string>{};
}

/// Returns what to do about an area that shows another surface than the twin.
std::string surface_step(const OtherSurfaceRow& row) {
  const std::string table = " (table \"Other surfaces\")";
  if (row.place_mm.empty())  // no point tells whose surface it is
    return "see which of rig and twin has something there that the other lacks" + table;
  if (row.seen.empty())
    return "put what stands there into the twin as an [[object]], or take it out of the rig's view" + table;
  if (row.seen == row.object)
    return fmt::format("check the pose of \"{}\" in the twin, or fit it with --refine pose", row.object) +
           table;
  return fmt::format(
             "the twin has \"{}\" there and the rig does not show it: take it out of the twin, or check its "
             "pose",
             row.object) +
         table;
}

double twins_gain_dn(const Twin& twin, const std::string& camera) {
  const auto found = std::ranges::find(twin.cameras, camera, &Camera::name);
  return found == twin.cameras.end() ? kNaN : found->sensor.gain_dn;
}

/// Returns whether of a row of coverage most pixels that the brighter side alone measures have fringes on the
/// other side, too weak ones or such that tell no order.
bool has_weak_fringes_on_one_side(const Comparison& c, const std::string& camera, bool real_is_brighter) {
  return std::ranges::any_of(c.coverage, [&](const CoverageRow& row) {
    const OneSided &brighter = real_is_brighter ? row.real_only : row.simulated_only,
                   &other = real_is_brighter ? row.simulated_only : row.real_only;
    return row.camera == camera && !row.explained && brighter.n > other.n &&
           2 * (brighter.lost_low_modulation + brighter.lost_order) > brighter.n;
  });
}

/// Returns the gain of a camera whose real images are brighter or darker than the twin's, where nothing but
/// coverage is wrong: of the weak fringes at outlines the bright side alone passes the threshold. Null where
/// that is not so.
const GainRow* brighter_side(const Comparison& c, const Twin& twin) {
  constexpr double kOther = 0.02, kSigmas = 5.0;
  for (const ExplainedRow& row : c.explained)
    if (row.quantity != "coverage" && !row.explained()) return nullptr;
  if (c.refinement)  // these and a gain are one number
    for (const char* name : {"gain", "albedo", "texture"})
      if (std::ranges::find(c.refinement->asked, name) != c.refinement->asked.end()) return nullptr;
  for (const GainRow& row : c.gain) {
    const double own_dn = twins_gain_dn(twin, row.camera), off_dn = std::abs(row.gain_dn - own_dn);
    if (row.usable && off_dn > kOther * own_dn && off_dn > kSigmas * row.gain_sigma_dn &&
        has_weak_fringes_on_one_side(c, row.camera, row.gain_dn > own_dn))
      return &row;
  }
  return nullptr;
}

NextStep brightness_step(const GainRow& row, const Comparison& c, const Twin& twin,
                         const std::vector<std::string>& argv) {
  std::vector<std::string> names = refined_before(c);
  names.emplace_back("gain");
  return {
      fmt::format(
          "the images of camera {} are {:.3g} times as bright as the twin's, and fringes that are weak count "
          "on the brighter side only: give the twin their gain (gain_dn = {:.5g}; projector, surface and "
          "sensor show only as their product) and compare again",
          row.camera, row.gain_dn / twins_gain_dn(twin, row.camera), row.gain_dn),
      refining(twin, argv, names)};
}

/// Returns whether a refinement would fit what a warning says: other fringes than described, a brightness
/// that is not the rig's; or whether this run's refinement has failed, and more of it would, too.
bool warnings_come_first(const Comparison& c, const Twin& twin) {
  constexpr double kFarApart = 2.0;  // as cosim/brightness.cpp warns of
  if (c.refinement && (!c.refinement->converged || c.refinement->taken_back)) return true;
  return c.shows_other_fringes || std::ranges::any_of(c.gain, [&](const GainRow& row) {
           const double ratio = row.gain_dn / twins_gain_dn(twin, row.camera);
           return !(ratio < kFarApart && ratio > 1.0 / kFarApart);
         });
}

NextStep shown_step(const ShownByImages& shown, const Comparison& c, const Twin& twin,
                    const std::vector<std::string>& argv) {
  return {fmt::format("{}the images show {}: fit {} and see what is left",
                      c.causes.rows.empty() ? "" : "no cause that was tested explains all; ",
                      listed(shown.words), shown.words.size() == 1 ? "it" : "these together"),
          refining(twin, argv, shown.refine)};
}

NextStep after_difference(const Comparison& c, const Twin& twin, const std::vector<std::string>& argv) {
  for (const std::string& together : c.causes.together) {
    if (const std::vector<std::string> words = refine_words(c, together); !words.empty())
      return {"fit the likely cause to the real images and compare again", refining(twin, argv, words)};
    for (const std::string& name : groups_in(together)) {
      const auto group = std::ranges::find(parameter_groups(), name, &ParameterGroup::name);
      if (group != parameter_groups().end() && !group->instead.empty()) return {group->instead, {}};
    }
  }
  if (const OtherSurfaceRow* largest = largest_surface(c.other_surfaces)) return {surface_step(*largest), {}};
  if (c.smooths_a_form_away)
    return {
        "measure the shape with smaller windows (smoothing_px and most_smoothing_px of its [[object]]) and "
        "compare again",
        {}};
  if (const GainRow* brighter = brighter_side(c, twin)) return brightness_step(*brighter, c, twin, argv);
  if (const ShownByImages shown = shown_by_images(c, twin);
      !shown.words.empty() && !warnings_come_first(c, twin))
    return shown_step(shown, c, twin, argv);
  if (!c.warnings.empty()) return {"read the warnings: " + c.warnings.front(), {}};
  if (!c.causes.rows.empty())
    return {
        "no single cause that was tested explains it: see which is nearest, and where on the images the "
        "difference is largest",
        {}};
  return {"see in the uncertainty budget where the difference is beyond it", {}};
}

}  // namespace

std::string answer_sentence(const Comparison& c) {
  std::vector<std::string> agree, faults;
  for (const char* quantity : kQuantities) {
    const ExplainedRow* row = worst_row(c, quantity);
    if (!row) continue;
    if (row->explained())
      agree.emplace_back(quantity);
    else
      faults.push_back(fault_text(*row));
  }
  if (agree.empty() && faults.empty()) return "";
  const std::string other = other_surface_text(c.other_surfaces);
  std::string text = agree.empty() ? other : "Twin and rig agree in " + listed(agree);
  if (faults.empty()) return text + ", within what noise and budget allow";
  if (!other.empty() && !agree.empty()) text = other + "; what both show agrees in " + listed(agree);
  std::string against;
  for (const std::string& fault : faults) against += (against.empty() ? "" : "; ") + fault;
  const std::string causes = causes_text(c.causes);
  if (!causes.empty()) against += "; most likely cause: " + causes;
  return (text.empty() ? "Twin and rig agree in nothing that was compared: " : text + "; ") + against;
}

NextStep next_step(const Comparison& c, const Twin& twin, const std::vector<std::string>& argv) {
  const std::string worst = worst_of_all(c);
  if (worst == kNotExplained) return after_difference(c, twin, argv);
  if (worst == kNotCompared) {
    const auto row = std::ranges::find(c.explained, worst, &ExplainedRow::state);
    return {fmt::format("mend what kept {} of {} from being compared{}", row->quantity, row->region,
                        row->why.empty() ? "" : ": " + row->why),
            {}};
  }
  if (worst == kTooWide) {
    NextStep step{"measure the sensor's noise, and state what the images have", {}};
    if (twin.real.captures)
      step.argv = {
          "fringetwin", "photometry",    twin.file.string(), "--captures", twin.real.captures->string(),
          "--out",      "out/photometry"};
    return step;
  }
  const bool can_hold_out = worst == kExplained && c.held_out.empty() && twin.fringes.steps >= kFolds &&
                            twin.real.captures.has_value();
  if (!can_hold_out) return {};
  return {"see how well the twin predicts images that took no part in any fit",
          again(twin, without_into(argv), "--hold-out", std::to_string(kFolds), "-held-out")};
}

}  // namespace fringetwin::compare
