// SPDX-License-Identifier: Apache-2.0
// Are two fits as far apart as their standard errors, and what is uncertain of the rig, allow?
#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "compare/result/fit_keys.hpp"
#include "compare/verdict/explained.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kMostSigmas = 3.0;
/// Degrees of freedom of a z: each side's standard error is taken as estimated from 20 blocks of the image.
/// Most objects cover more, those of less than 20 squares of 8 px fewer.
constexpr double kFreedom = 2.0 * (20 - 1);

const char* unit_of(const std::string& key) {
  const auto has = [&key](const char* unit) { return key.find(unit) != std::string::npos; };
  return has("_mm") ? "mm" : has("_rad") ? "rad" : "";
}

/// One number of a fit on both sides.
struct Number {
  std::string name;
  double z = 0.0;  ///< of the fits' own errors
  double difference = 0.0, simulated_sigma = 0.0, real_sigma = 0.0, rig_variance = 0.0;
  const char* unit = "";
};

class GeometryExplanation {
 public:
  GeometryExplanation(const FitRow& fit, const RigBudget::Fit* moved, std::string line)
      : fit_(fit), moved_(moved), line_(std::move(line)) {
    row_.quantity = "geometry";
    row_.region = fit.object;
  }

  /// Returns a row that says why it was not compared where the fit has no z.
  ExplainedRow run() {
    if (const std::string missing = why_missing(); !missing.empty()) {
      row_.worsen(kNotCompared, missing);
      return row_;
    }
    add_numbers(fit_.z, fit_.real->numbers, false);
    add_numbers(fit_.z_estimated, fit_.real_sigma_estimated, true);
    add_vectors(fit_.z_vectors, fit_.real->vectors, false);
    add_vectors(fit_.z_estimated_vectors, fit_.real_sigma_estimated_vectors, true);
    if (row_.n == 0) {
      row_.worsen(kNotCompared, "one of the fits states no standard error to hold the difference against");
      return row_;
    }
    row_.chi2_limit = std::pow(most_sigmas_of(row_.n), 2);
    row_.state = kExplained;
    if (!(row_.chi2 <= row_.chi2_limit)) row_.worsen(kNotExplained);
    return row_;
  }

 private:
  std::string why_missing() const {
    for (const auto& [fit, side] : {std::pair{&fit_.simulated, "simulated"}, std::pair{&fit_.real, "real"}}) {
      if (!*fit) return fmt::format("the {} side has no fit", side);
      if (!(*fit)->usable) return fmt::format("{} fit on {} points: {}", side, (*fit)->n, (*fit)->warning);
    }
    return "";
  }

  void add_numbers(const std::map<std::string, double>& z, const std::map<std::string, double>& real,
                   bool estimated) {
    for (const auto& [key, value] : z)
      look_at({key, value, fit_.difference.at(key), value_or(fit_.simulated->numbers, sigma_key(key), 0.0),
               value_or(real, sigma_key(key), 0.0), moved_ ? value_or(moved_->numbers, key, 0.0) : 0.0,
               unit_of(key)},
              estimated);
  }

  void add_vectors(const std::map<std::string, Eigen::Vector3d>& z,
                   const std::map<std::string, Eigen::Vector3d>& real, bool estimated) {
    const Eigen::Vector3d none = Eigen::Vector3d::Zero();
    for (const auto& [key, value] : z) {
      if (key.starts_with("T_object_measured"))
        continue;  // the same six numbers as object_turn, object_shift
      for (int i = 0; i < 3; ++i)
        look_at({fmt::format("{}.{}", key, "xyz"[i]), value[i], fit_.difference_vectors.at(key)[i],
                 value_or(fit_.simulated->vectors, sigma_key(key), none)[i],
                 value_or(real, sigma_key(key), none)[i],
                 moved_ ? value_or(moved_->vectors, key, none)[i] : 0.0, unit_of(key)},
                estimated);
    }
  }

  /// Keeps the number with the largest z, what is uncertain of the rig included.
  void look_at(const Number& number, bool estimated) {
    if (!std::isfinite(number.z)) return;
    // z/difference is one over the fits' errors; a difference of 0 stays 0
    const double per_unit = number.difference == 0.0 ? 0.0 : number.z / number.difference;
    const double z = number.z / std::sqrt(1.0 + number.rig_variance * per_unit * per_unit);
    ++row_.n;
    if (std::isfinite(row_.chi2) && z * z <= row_.chi2) return;
    row_.chi2 = z * z;
    row_.worst = number.name;
    row_.unit = number.unit;
    row_.observed = number.difference * number.difference;
    row_.lines = {
        {"fit of the simulated points", number.simulated_sigma * number.simulated_sigma},
        {estimated ? "fit of the real points, estimated from the published rms" : "fit of the real points",
         number.real_sigma * number.real_sigma}};
    if (moved_) row_.lines.push_back({line_, number.rig_variance});
    add_tilt(number);
  }

  /// Adds the line of what z holds besides: the tilt over the way between the points of planes or axes.
  void add_tilt(const Number& number) {
    if (number.difference == 0.0) return;
    const double all = std::pow(number.difference / number.z, 2);
    const double rest =
        all - number.simulated_sigma * number.simulated_sigma - number.real_sigma * number.real_sigma;
    if (rest > 1e-6 * all) row_.lines.push_back({"tilt of the fits over the way between their points", rest});
  }

  const FitRow& fit_;
  const RigBudget::Fit* moved_;  ///< null: what is uncertain of the rig is in no budget
  std::string line_;
  ExplainedRow row_;
};

}  // namespace

double most_sigmas_of(std::uint64_t n) {
  const double rarity = std::erfc(kMostSigmas / std::numbers::sqrt2),
               of_one_end = 0.5 * rarity / static_cast<double>(std::max<std::uint64_t>(n, 1));
  return boost::math::quantile(complement(boost::math::students_t(kFreedom), of_one_end));
}

std::vector<ExplainedRow> explain_geometry(const std::vector<FitRow>& fits, const RigBudget* rig) {
  std::vector<ExplainedRow> rows;
  for (const FitRow& fit : fits) {
    const RigBudget::Fit* moved = rig ? find_value(rig->fits, fit.object) : nullptr;
    if (fit.real) rows.push_back(GeometryExplanation(fit, moved, rig ? rig->line : "").run());
  }
  return rows;
}

}  // namespace fringetwin::compare
