// SPDX-License-Identifier: Apache-2.0
// Searches for what a twin is wrong about: the stages of find_causes() (docs/metrics/causes.md, "Causes").
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/causes/cause_fit.hpp"
#include "compare/causes/causes.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/result/milestones.hpp"

namespace fringetwin::compare {

/// Parameters that are fitted and named together, of those of the search.
struct CauseGroup {
  std::string name;
  std::vector<std::size_t> at;  ///< of its parameters among all
};

/// What every pixel may have of its own, as causes.
struct PixelField {
  FreePerPixel free;
  const char *name, *cause;
};
/// One explanation that was tried: groups, and a field of what every pixel has of its own.
struct TriedExplanation {
  std::vector<std::size_t> groups;
  const PixelField* field = nullptr;
  CauseFit fit;
};

/// The search: from what the twin leaves to the causes that are named.
class CauseSearch {
 public:
  CauseSearch(Sensitivity& sensitivity, const Twin& twin, const std::vector<FitRow>& fits,
              const std::vector<int>& steps);
  Causes run();

 private:
  /// Fits gain and black level alone.
  void judge_twin(Causes& out);
  /// Fits the group whose linear step takes away most, and takes the noise of all values at what it predicts:
  /// at the levels of a twin that is wrong, noise is wrong by a fifth. The same weights for all groups, or
  /// those would be better that predict more noise.
  void weigh_by_the_nearest();
  /// Solves for these groups with gain and black level of every camera, and the light of images lit apart.
  Step solve(const NormalEquations& e, const std::vector<std::size_t>& groups) const;
  /// Returns by how much a linear step in these groups lowers chi2, less what it would lower noise. `every`:
  /// of the equations.
  double removed_by(const NormalEquations& e, const std::vector<std::size_t>& groups,
                    std::size_t every = 1) const;
  bool is_switch(std::size_t g) const;
  /// Returns what the twin predicts with this switch turned. Light from surface to surface does not depend on
  /// the points per pixel (render/indirect), so its column has all that a rendering of its own would have.
  Sensitivity::Values switched(std::size_t g) const;
  /// Returns whether these are the halo and the blur of one point spread, which no linear step tells to be
  /// wrong together: a part without light has no width.
  bool is_one_spread(std::size_t g, std::size_t other) const;
  /// Returns the place of a group among groups_; their number where it has none.
  std::size_t group_at(const char* name) const;
  bool moves_objects(std::size_t g) const;
  /// Returns the share of what fails that is taken away: of the excess of single values, or else of that of
  /// the kinds of regions that fail. NaN where only regions fail and what is left in them is not known.
  double share(double removed, const std::vector<CauseRegion>& after) const;
  /// Returns those that explain the difference and cannot be told apart.
  std::vector<std::size_t> explaining() const;
  /// Returns these without another contrast of all fringes where a known way that light loses contrast (blur,
  /// ...) explains the same.
  std::vector<std::size_t> alike() const;
  /// Fits groups to convergence, in a field or without; `first`: begins where this fit ended.
  CauseFit fit(const std::vector<std::size_t>& groups, const PixelField* field, const CauseFit* first,
               bool only_values = false) const;
  const CauseFit& try_fit(const std::vector<std::size_t>& groups, const PixelField* field = nullptr,
                          const CauseFit* first = nullptr);
  /// Fits the groups to convergence whose linear steps take away most; once one passes, only its rivals.
  void try_alone(std::vector<CauseRow>& rows);
  /// A knee's linear step knows nothing of its place: it may take away as much as smooth curves do. That of
  /// light below surfaces knows the shift of the fringes alone: it may take away as much as a blur does.
  void promise_of_the_curved(std::vector<double>& removed_by_group) const;
  /// `first`: as in try_fit(). Raises `least` where the group passes.
  void fit_alone(std::size_t g, const CauseFit* first, CauseRow& row, double& least);
  /// Returns where the objects' fits put these groups; nothing where they agree as it is, or cannot.
  std::optional<CauseFit> begin_where_fits_are(const std::vector<std::size_t>& groups) const;
  /// Fits the groups to convergence from where the objects' fits put them: too far for a linear step.
  void try_where_fits_are(std::vector<CauseRow>& rows, std::vector<std::size_t>& not_yet, double& least);
  /// Fits place and size together where the objects' fits find both wrong and neither was found to explain
  /// all alone: a group of more numbers that does is their rival.
  void try_place_and_size(const std::vector<CauseRow>& rows);
  /// A pair does not pass unless each of its groups is worth naming beside the other; the one that takes away
  /// more alone comes first.
  void settle_pair(TriedExplanation& pair, const std::vector<CauseRow>& rows) const;
  /// Writes what a fit by itself found into the row.
  void take(const CauseFit& fit, CauseRow& row) const;
  static void take_values(const CauseFit& fit, CauseRow& row);
  /// Fits the groups that take away most together with each that takes most of what they leave; each of the
  /// two must be worth naming besides the other.
  void try_pairs(const std::vector<CauseRow>& rows);
  /// Returns whether nothing is named but what explains all that is common to a pixel's images: light of two
  /// kinds at once, of which a group of few numbers may tell one.
  bool all_is_free(const std::vector<std::size_t>& named) const;
  /// Gives every pixel an offset, a factor or both of its own.
  void try_fields(std::vector<CauseRow>& rows);
  /// The same besides groups that then take away most: a factor with a projector's gamma is like a camera's.
  void try_fields_with_groups();
  static const PixelField* field_of(FreePerPixel free);
  std::string name_of(const TriedExplanation& tried) const;
  /// Returns whether an explanation is another one with a blur, or what else takes contrast, in the place of
  /// another contrast of all fringes.
  bool stands_for_contrast(const TriedExplanation& known, const TriedExplanation& contrast) const;
  /// Says beside what takes contrast that another contrast of all fringes would look the same.
  void say_what_looks_the_same(const std::vector<std::size_t>& named, Causes& out) const;
  /// Puts the named ones first, the first of them with its order, values and sensors.
  void list_named(const std::vector<std::size_t>& named, Causes& out) const;
  /// What scales the light over a single camera's image may as well be on the surfaces.
  void add_texture_beside(Causes& out) const;
  void offer_gain(const TriedExplanation& first, Causes& out) const;
  /// Lists the groups by what linear steps take away one after the other, where nothing is named.
  void list_in_order(Causes& out) const;
  static void sort(Causes& out);
  /// Takes the group that takes away most, then the one that takes most of what is left ...
  std::vector<std::size_t> choose_order() const;
  CauseRow make_row(std::size_t g, const Step& step) const;

  Milestones progress_{"causes", 100};
  Sensitivity& sensitivity_;
  const Twin& twin_;
  const std::vector<FitRow>& fits_;
  std::vector<Parameter> parameters_;
  std::vector<CauseGroup> groups_;
  Eigen::VectorXd start_;
  Sensitivity::Columns columns_;  ///< of all parameters at the twin
  Sensitivity::Values base_;      ///< what the twin predicts
  NormalEquations equations_;     ///< there
  std::vector<CauseRegion> regions_before_;
  std::vector<TriedExplanation> tried_;
  std::optional<std::size_t> nearest_;  ///< group whose linear step takes away most
  std::optional<CauseFit> begin_;       ///< its fit, with the noise of the twin's levels
  std::uint64_t n_ = 0;                 ///< values
  double own_ = 0.0;                    ///< numbers that pixels have of their own in all fits
  double before_ = 0.0, excess_ = 0.0;  ///< chi2 with gain and black level alone, and beyond noise
  bool values_fail_ = false;
};

}  // namespace fringetwin::compare
