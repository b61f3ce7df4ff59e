// SPDX-License-Identifier: Apache-2.0
// Decides from fits of causes which of them explain a difference, and says so in sentences
// (docs/metrics/causes.md, "Causes").
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// What a decision asks of one fit of a cause, or of several together.
struct TriedCause {
  double chi2 = 0.0;    ///< of all values, and one for each number that was fitted
  double fitted = 0.0;  ///< numbers that were fitted besides gain and black level
  bool passes = false;  ///< what it leaves is explained
  /// Sum over the values of ln(variance over that of the twin's own weights): more light has more noise.
  double log_variance = 0.0;
  /// Returns -2 ln of the likelihood of normal noise `per_value` times what is stated (variance), times
  /// `per_value`, but for what is the same of all fits: a fit that predicts more noise has less chi2 without
  /// being better, and each number fitted takes as much off chi2 as a value's noise has.
  double deviance(double per_value) const {
    return chi2 + (per_value - 1.0) * fitted + per_value * log_variance;
  }
};

/// Returns by how much more than by its own number of parameters a cause must lower chi2 to be named: nearly
/// as many again, or 5 standard deviations of chi2 where they are many.
double worth_naming(double parameters);

/// Returns the fits that explain the difference and cannot be told apart: of those that pass and have a
/// deviance enough below `before`, the ones that are less above the best than a further cause must lower it,
/// the variance of the noise being `per_value` times what is stated. The fewest parameters come first.
std::vector<std::size_t> explaining_alike(const std::vector<TriedCause>& tried, double before,
                                          double per_value);

/// Returns the groups of an explanation, "pose + response".
std::vector<std::string> groups_in(std::string together);

/// Says in one sentence what was found: the causes named, those that cannot be told apart, or that none of
/// those tested explains the difference, and which is nearest. Empty where nothing was looked for.
std::string sentence(const Causes& causes);

/// Returns whether a group changes the images as the gain does, here more and there less: then how much of it
/// is gain, nobody can tell.
bool scales_the_gain(const std::string& group);

/// Says in one line which gain and black level each camera has with the causes taken, or why none is offered;
/// empty where no cause is named.
std::string gain_sentence(const Causes& causes);

}  // namespace fringetwin::compare
