// SPDX-License-Identifier: Apache-2.0
#include "compare/gain/gain_trust.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "compare/gain/gain_checks.hpp"

namespace fringetwin::compare {
namespace {

/// A part disagrees beyond this many standard errors. Of right twins the largest of some 20 parts is below 3.
constexpr double kDisagrees = 4.5;
/// A bias below these, or below 3 standard errors, keeps nobody from using the numbers.
constexpr double kSmallGainBias = 0.0005, kSmallBlackBiasDn = 0.1, kSmallSigmas = 3.0;
constexpr double kLowR2 = 0.9;             ///< below it the line explains too little to be called a gain
constexpr double kManyLeftOut = 0.5;       ///< share of values that the robust rules weigh down or leave out
constexpr double kMeansScatterMore = 3.0;  ///< times the inflation of the modulation: light, not contrast
/// Albedo and shading endanger the line when they make this share of the residual variance and are this large
/// themselves: most of next to nothing is nothing.
constexpr double kLargeAlbedoShare = 0.3, kLargeAlbedoSpread = 0.02;

bool disagrees(const GainCheck& row) {
  return std::abs(row.gain_z) > kDisagrees || std::abs(row.black_level_z) > kDisagrees;
}

/// Returns what a part disagrees by beyond its own standard error; 0 where it does not, or is unknown.
double beyond_sigma(double difference, double sigma) {
  const double square = difference * difference - sigma * sigma;
  return square > 0.0 ? std::sqrt(square) : 0.0;
}

/// Returns the distance of two parts in standard errors; 0 where one of them is missing.
double gain_distance(const GainCheck* a, const GainCheck* b) {
  return a && b ? std::abs(a->gain_dn - b->gain_dn) / std::hypot(a->gain_sigma_dn, b->gain_sigma_dn) : 0.0;
}

class GainTrust {
 public:
  GainTrust(const Comparison& c, GainRow& row) : row_(row) {
    for (const GainCheck& check : c.gain_checks)
      if (check.camera == row.camera) checks_.push_back(&check);
    for (const ExplainedRow& one : c.explained)
      if (one.quantity == "gray" && one.region == row.camera) {
        judged_ = one.state != kNotCompared;
        explained_ = one.explained();
      }
    for (const GrayBudget& one : c.gray_budget)
      if (one.camera == row.camera) budget_ = &one;
  }

  void judge() {
    take_bias();
    const bool small = is_small();
    const std::vector<std::string> doubts = doubts_of_the_fit();
    std::vector<std::string> reasons = doubts;
    const bool allowed = judged_ && explained_;
    if (!allowed)
      reasons.push_back(judged_ ? "the verdict on the gray differences is not \"explained\""
                                : "the gray differences could not be compared");
    if (const std::string cause = disagreement(); !cause.empty())
      reasons.push_back(cause);
    else if (!allowed && small && !checks_.empty())
      reasons.emplace_back("its parts agree");
    row_.why = fmt::format("{}", fmt::join(reasons, "; "));
    row_.state = row_.r2 < 0.0 || checks_.empty() || (!judged_ && small && doubts.empty()) ? "not offered"
                 : allowed && small && doubts.empty()                                      ? "sensor value"
                                                                                           : "biased";
  }

  std::string warning() const {
    if (row_.state == "not offered")
      return fmt::format("{}: the gain is not offered as a sensor value, nor is the black level: {}",
                         row_.camera, row_.why);
    return fmt::format(
        "{}: gain {:.6g} DN is biased by up to {:.2g} DN and black level {:.4g} DN by up to {:.2g} DN; do "
        "not use them as sensor values: {}",
        row_.camera, row_.gain_dn, row_.gain_bias_dn, row_.black_level_dn, row_.black_level_bias_dn,
        row_.why);
  }

 private:
  const GainCheck* part(const std::string& name) const {
    for (const GainCheck* check : checks_)
      if (check->part == name) return check;
    return nullptr;
  }

  /// Takes the largest disagreement with the printed numbers: of all parts where the gray differences are not
  /// explained, as errors that vary slowly widen the standard errors of the parts, too; else of those that
  /// chance does not explain.
  void take_bias() {
    if (checks_.empty()) return;
    row_.gain_bias_dn = row_.black_level_bias_dn = 0.0;
    for (const GainCheck* check : checks_) {
      if (judged_ && explained_ && !disagrees(*check)) continue;
      row_.gain_bias_dn =
          std::max(row_.gain_bias_dn, beyond_sigma(check->gain_dn - row_.gain_dn, check->gain_sigma_dn));
      row_.black_level_bias_dn =
          std::max(row_.black_level_bias_dn,
                   beyond_sigma(check->black_level_dn - row_.black_level_dn, check->black_level_sigma_dn));
    }
    // all parts agree on the mean albedo, which nobody knows better than it scatters
    if (large_albedo())
      row_.gain_bias_dn = std::max(row_.gain_bias_dn, budget_->albedo_sigma * std::abs(row_.gain_dn));
  }

  bool is_small() const {
    return row_.gain_bias_dn <=
               std::max(kSmallGainBias * std::abs(row_.gain_dn), kSmallSigmas * row_.gain_sigma_dn) &&
           row_.black_level_bias_dn <= std::max(kSmallBlackBiasDn, kSmallSigmas * row_.black_level_sigma_dn);
  }

  bool large_albedo() const {
    return budget_ && budget_->albedo_dn2 > kLargeAlbedoShare * budget_->total_dn2 &&
           budget_->albedo_sigma > kLargeAlbedoSpread;
  }

  /// Returns what speaks against the line itself, whatever its parts say.
  std::vector<std::string> doubts_of_the_fit() const {
    std::vector<std::string> out;
    if (row_.r2 < kLowR2)
      out.push_back(fmt::format("R2 is {:.3f}{}", row_.r2,
                                row_.r2 < 0.0 ? ", the mean gray value says more than the line" : ""));
    if (row_.outlier_fraction > kManyLeftOut)
      out.push_back(
          fmt::format("{:.0f} % of the gray values lie so far off the line that the fit weighs them down",
                      100.0 * row_.outlier_fraction));
    if (row_.dropped_fraction > kManyLeftOut)
      out.push_back(
          fmt::format("{:.0f} % of the sound gray values are left out because the residuals are so large",
                      100.0 * row_.dropped_fraction));
    if (large_albedo())
      out.push_back(
          fmt::format("albedo or shading scatters by {:.1f} % from pixel to pixel and makes {:.0f} % of the "
                      "residual variance",
                      100.0 * budget_->albedo_sigma, 100.0 * budget_->albedo_dn2 / budget_->total_dn2));
    return out;
  }

  /// Returns which parts disagree, and what that speaks for; empty where none does.
  std::string disagreement() const {
    const GainCheck *within = part(kWithinPixels), *between = part(kBetweenPixels);
    if (gain_distance(within, between) > kDisagrees) {
      const bool light =
          between->sigma_inflation > kMeansScatterMore * std::max(within->sigma_inflation, 1.0);
      return fmt::format("the modulation of the pixels says {:.6g} DN, their means {:.6g} DN: {}",
                         within->gain_dn, between->gain_dn,
                         light ? "light that the twin lacks (room light, albedo, shading), and where the "
                                 "fringes' contrast is the twin's the modulation's gain is the better one"
                               : "contrast, phase or form of the fringes differs, and where that is blur or "
                                 "a shift the means' gain is the better one");
    }
    const GainCheck* worst = worst_image();
    if (worst)
      return fmt::format("{} alone says {:.6g} DN: the brightness varies from image to image", worst->part,
                         worst->gain_dn);
    for (const auto& [dark_name, bright_name] :
         {std::pair{kLowValues, kHighValues}, std::pair{"dark half", "bright half"}}) {
      const GainCheck *dark = part(dark_name), *bright = part(bright_name);
      if (gain_distance(dark, bright) > kDisagrees)
        return fmt::format(
            "the part \"{}\" says {:.6g} DN and \"{}\" {:.6g} DN: a response of the camera that is not "
            "straight, or light that the twin lacks",
            dark->part, dark->gain_dn, bright->part, bright->gain_dn);
    }
    for (const GainCheck* check : checks_)
      if (disagrees(*check))
        return fmt::format(
            "the part \"{}\" says {:.6g} DN and a black level of {:.4g} DN: light or albedo that the twin "
            "lacks",
            check->part, check->gain_dn, check->black_level_dn);
    return "";
  }

  /// Returns the step or pitch that disagrees most; null where none does.
  const GainCheck* worst_image() const {
    const GainCheck* worst = nullptr;
    for (const GainCheck* check : checks_) {
      const bool of_images =
          check->part.starts_with("step ") || check->part.find(" pitch ") != std::string::npos;
      if (of_images && disagrees(*check) && (!worst || std::abs(check->gain_z) > std::abs(worst->gain_z)))
        worst = check;
    }
    return worst;
  }

  GainRow& row_;
  std::vector<const GainCheck*> checks_;
  const GrayBudget* budget_ = nullptr;
  bool judged_ = false, explained_ = false;
};

/// Returns why a line is no finding where the pixels have such numbers of their own.
std::string why_held(const OwnKinds& own) {
  const char* numbers = own.factor && own.offset ? "a factor and an offset"
                        : own.factor             ? "a factor"
                                                 : "an offset";
  const char* held = own.factor && own.offset ? "gain and black level"
                     : own.factor             ? "the gain"
                                              : "the black level";
  return fmt::format("every pixel has {} of its own, for which {} of the twin {} held", numbers, held,
                     own.factor && own.offset ? "were" : "was");
}

}  // namespace

void trust_gains(Comparison& comparison, const std::vector<OwnKinds>& own) {
  for (std::size_t c = 0; c < comparison.gain.size(); ++c) {
    GainRow& row = comparison.gain[c];
    if (!row.usable || row.state != "not fitted") continue;
    if (c < own.size() && own[c].any()) {
      row.state = "not offered";
      row.why = why_held(own[c]);
      comparison.warnings.push_back(
          fmt::format("{}: gain and black level are not offered as sensor values: {}", row.camera, row.why));
      continue;
    }
    GainTrust trust(comparison, row);
    trust.judge();
    if (row.state != "sensor value") comparison.warnings.push_back(trust.warning());
  }
}

}  // namespace fringetwin::compare
