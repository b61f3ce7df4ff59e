// SPDX-License-Identifier: Apache-2.0
// What the images of a fit cannot tell apart: groups that change them alike, and lights of which others do
// the same.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "compare/causes/group_fit.hpp"
#include "compare/causes/scaled_eigen.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kAlike = 0.98;  ///< canonical correlation of two groups
/// Of place and size: a ball that is nearer and smaller differs by the curvature of its fringes alone, and
/// still by many standard errors, which are 16 times as large then.
constexpr double kAlikePlaceAndSize = 0.998;
constexpr double kSameLight = 1e-6;  ///< smallest eigenvalue of the correlation matrix

/// Returns what a group is told apart from others as: higher orders and a field are the harmonics' own,
/// further terms of one waveform. The mean of a field over what is seen of the projector's image need not be
/// its first term.
std::string told_as(const std::string& group) {
  return group.starts_with("harmonics_") ? "harmonics" : group;
}

}  // namespace

std::string GroupFit::cannot_be_told() {
  if (parameters_.empty()) return "";
  const FreePerPixel free = free_of(blocks_.back());
  const NormalEquations e = equations_with_prior(free);
  const std::string groups = alike_groups(e, free);
  return groups.empty() ? alike_lights(e, free) : groups;
}

/// Returns the pair of groups with the largest canonical correlation, where it is too large.
std::string GroupFit::alike_groups(const NormalEquations& e, FreePerPixel free) const {
  std::vector<std::size_t> all;
  std::vector<std::string> groups;
  for (std::size_t k = 0; k < parameters_.size(); ++k) {
    // what others do as an expected one does is theirs
    if (!known_[k].told || !(e.normal(k, k) > 0.0) || parameters_[k].expected > 0.0) continue;
    all.push_back(k);
    if (const std::string group = told_as(parameters_[k].group);
        std::ranges::find(groups, group) == groups.end())
      groups.push_back(group);
  }
  const auto m = static_cast<Eigen::Index>(all.size());
  const std::vector<std::size_t> told = all, sensors = sensors_of(free);
  all.insert(all.end(), sensors.begin(), sensors.end());
  const auto s = static_cast<Eigen::Index>(sensors.size());
  const Eigen::MatrixXd normal = e.normal_of(all);
  Eigen::MatrixXd own = normal.topLeftCorner(m, m);
  if (s > 0)  // what gain and black level explain is nobody's
    own -= normal.topRightCorner(m, s) *
           ScaledEigen(normal.bottomRightCorner(s, s)).inverse(ScaledEigen::kNull) *
           normal.bottomLeftCorner(s, m);
  const auto members = [&](const std::string& group) {
    std::vector<Eigen::Index> in;
    for (Eigen::Index i = 0; i < m; ++i)
      if (told_as(parameters_[told[i]].group) == group) in.push_back(i);
    return in;
  };
  std::string sentence;
  double most = 0.0;
  for (std::size_t a = 0; a < groups.size(); ++a)
    for (std::size_t b = a + 1; b < groups.size(); ++b) {
      const std::vector<Eigen::Index> in_a = members(groups[a]), in_b = members(groups[b]);
      const Eigen::MatrixXd white_a = ScaledEigen(own(in_a, in_a)).whitening(ScaledEigen::kNull),
                            white_b = ScaledEigen(own(in_b, in_b)).whitening(ScaledEigen::kNull);
      // canonical correlations and directions: singular values and vectors of `across`
      const Eigen::MatrixXd across = white_a.transpose() * own(in_a, in_b) * white_b;
      const SymmetricEigen squared = symmetric_eigen(across * across.transpose());
      const Eigen::VectorXd correlations = squared.values.cwiseMax(0.0).cwiseSqrt();
      const bool are_place_and_size =
          std::ranges::all_of(std::array{groups[a], groups[b]},
                              [](const std::string& group) { return group == "pose" || group == "size"; });
      const double too_much = are_place_and_size ? kAlikePlaceAndSize : kAlike;
      if (!(correlations.maxCoeff() > std::max(most, too_much))) continue;
      most = correlations.maxCoeff();
      std::vector<std::string> names;
      const auto add_names = [&](const Eigen::MatrixXd& directions, const std::vector<Eigen::Index>& in) {
        for (std::size_t i = 0; i < in.size(); ++i) {
          const double size = std::sqrt(own(in[i], in[i]));  // in units of each parameter's own effect
          for (Eigen::Index k = 0; k < correlations.size(); ++k)
            if (correlations[k] > too_much && size * std::abs(directions(static_cast<Eigen::Index>(i), k)) >
                                                  ScaledEigen::kInNullDirection) {
              names.push_back(parameters_[told[in[i]]].name);
              break;
            }
        }
      };
      add_names(white_a * squared.vectors, in_a);
      add_names(white_b * across.transpose() * squared.vectors *
                    correlations.cwiseMax(kAlike).cwiseInverse().asDiagonal(),
                in_b);
      sentence = fmt::format("{} and {} change the gray values alike, {} (canonical correlation {:.4f})",
                             groups[a], groups[b], fmt::join(names, ", "), most);
    }
  return sentence;
}

/// Returns the parameters without a prior, and the gains and black levels, of which others do the same.
std::string GroupFit::alike_lights(const NormalEquations& e, FreePerPixel free) const {
  std::vector<std::size_t> all;
  for (std::size_t k = 0; k < parameters_.size(); ++k)
    if (known_[k].told && !is_geometric(parameters_[k].group) && parameters_[k].expected == 0.0 &&
        (e.normal(k, k) > 0.0 || !parameters_[k].acts_beside_others))
      all.push_back(k);
  if (all.empty()) return "";
  for (const std::size_t at : sensors_of(free)) all.push_back(at);
  const ScaledEigen scaled(e.normal_of(all));
  if (scaled.smallest() > kSameLight) return "";
  std::vector<std::string> names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!scaled.is_in_null_direction(static_cast<Eigen::Index>(i), kSameLight)) continue;
    const std::size_t sensor = all[i] - parameters_.size();  // wraps for a parameter
    names.push_back(all[i] < parameters_.size() ? parameters_[all[i]].name
                    : sensor >= 2 * sensitivity_.samples().size()
                        ? "the light of an image of a code"
                        : twin_.cameras[sensitivity_.samples()[sensor / 2].camera].name +
                              (sensor % 2 == 0 ? ".gain_dn" : ".black_level_dn"));
  }
  return fmt::format("{} (smallest eigenvalue of their correlations {:.1e})", fmt::join(names, ", "),
                     scaled.smallest());
}

}  // namespace fringetwin::compare
