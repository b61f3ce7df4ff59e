// SPDX-License-Identifier: Apache-2.0
// Fits parameters of a twin to the real gray values until nothing is left to gain, and says how well each is
// known: one fit for the search for causes and for `--refine` (docs/metrics/causes.md, "Fit of a group").
#pragma once
#include <functional>
#include <optional>

#include "compare/causes/sensitivity.hpp"
#include "compare/parameters/parameters.hpp"
#include "compare/result/rows.hpp"

namespace fringetwin::compare {

/// Returns whether a group says where things are and how devices look: pose, size, rig, intrinsics, lens, and
/// shifts of images. What light does must not move them, so every pixel has a factor and an offset of its own
/// beside them.
bool is_geometric(const std::string& group);

/// Returns the standard deviation of what is known of a parameter before any image, in its own steps; 0:
/// none.
double prior_steps(const std::string& group);
/// Returns the standard deviation of a parameter about its start before any image is seen; 0: none.
double prior_of(const Parameter& parameter);

/// How a GroupFit is made.
struct GroupFitOptions {
  bool hold_gain = false;   ///< the gain of each camera stays as it is
  bool keep_scale = false;  ///< Huber's scale of `Sensitivity` stays: chi2 of several fits can be compared
  /// Gain and black level go into the samples before regions are summed, as they go with the values.
  bool settles_sensors = false;
  bool tells = true;    ///< what is known of the parameters; else run() ends with their values
  bool exact = false;   ///< the last columns are central differences (Sensitivity::Derivative)
  int most_steps = 20;  ///< of each block, in each pass
  /// Chi2 per value that a fit must reach to be of use; one that cannot come near it stops early.
  double wanted_chi2 = 0.0;
  /// What every pixel has of its own; without: a factor and an offset beside geometric groups, nothing beside
  /// the others. Both kinds together are fitted in turn, geometry first.
  std::optional<FreePerPixel> free = std::nullopt;
  /// Called at the begin of each step with its number and the chi2 per value so far; may be empty.
  std::function<void(int step, double chi2)> on_step = {};
};

/// Makes Huber's loss least by Levenberg's damped steps; the columns (derivatives) are rendered at the start
/// and again where they no longer lower it. Gain (unless held) and black level of each camera are solved
/// besides, where no pixel has its own; settle_sensors() puts them into the samples.
class GroupFit {
 public:
  /// Holds what is known of one parameter, as it is fitted (a blur as its square).
  struct Known {
    double value = 0.0;
    double sigma = 0.0;        ///< noise times root of chi2, or what blocks of pixels and images scatter by
    double noise_sigma = 0.0;  ///< of noise alone
    /// False: sigma is half of the prior or more, or other parameters do the same; the value stays at the
    /// twin's. Sigma is 0 where the parameter changes nothing at all.
    bool told = true;
  };

  /// `begin`: values to begin at whatever they fit; empty: those of the twin. `base`: what is predicted
  /// there, if it is known.
  GroupFit(Sensitivity& sensitivity, const Twin& twin, std::vector<Parameter> parameters,
           GroupFitOptions options = {}, const Eigen::VectorXd& begin = {}, Sensitivity::Values base = {});

  /// Begins at these values instead, if they fit better; returns whether they do.
  bool start_at(const Eigen::VectorXd& values);
  /// Takes these values, whatever they fit, with the standard errors as they are.
  void move_to(const Eigen::VectorXd& values);
  /// Uses these derivatives, in the order of the parameters, for the first steps instead of rendering them;
  /// `at`: the values that they belong to.
  void use_columns(Sensitivity::Columns columns, const Eigen::VectorXd& at);
  /// Gives away the derivatives that were used last, and the values that they belong to; to be called after
  /// all else. Nothing where there are none.
  std::optional<std::pair<Sensitivity::Columns, Eigen::VectorXd>> give_columns();

  /// Fits until the last step is below 0.05 standard errors or lowers chi2 by less than 0.5. Throws
  /// Cancelled.
  void run();

  bool converged() const { return converged_; }
  int steps() const { return n_steps_; }
  /// Returns the twin with the values that are shown.
  Twin twin() const { return with_values(twin_, parameters_, shown_values()); }
  const std::vector<Parameter>& parameters() const { return parameters_; }
  /// Returns the values as they are fitted: where another fit may begin.
  const Eigen::VectorXd& values() const { return values_; }
  /// Returns them with the gain as it is: other than values() for what grows with it.
  Eigen::VectorXd shown_values() const;
  /// Returns the irradiance predicted by them.
  const Sensitivity::Values& predicted() const { return base_; }
  /// Returns what is known of each parameter after run(), in their order. Sigma grows with the root of what
  /// regions leave beyond their limit: of the shift for geometric groups, of level and contrast for others.
  const std::vector<Known>& known() const { return known_; }
  /// Holds these parameters at the twin's values from now on; run() fits the others anew.
  void hold(const std::vector<std::size_t>& parameters);
  /// Returns what is left of the places of the fringes, in regions, with a factor and an offset per pixel.
  CauseRegion shift_in_regions() const;
  /// The same of level and contrast, with nothing projected out.
  std::vector<CauseRegion> light_in_regions() const;
  /// Returns what the last block leaves in regions after run(); empty where nothing was fitted.
  const std::vector<CauseRegion>& regions() const { return regions_; }
  /// Returns why what is left is not explained, empty where it is: chi2 of the values and of the regions (of
  /// the shift for geometric groups, of level and contrast for others) against their limits.
  const std::string& unexplained() const { return unexplained_; }
  /// Returns the covariance of the parameters by noise alone; 0 between those of different blocks and where a
  /// parameter is not told.
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// Returns chi2 per value of the last block's equations, and how many values they hold (those that a
  /// pixel's own numbers took are not counted).
  double chi2() const { return chi2_; }
  std::uint64_t n() const { return n_; }
  /// Returns chi2 per gray value over all values, with the best gain and black level of each camera: what
  /// fits of different groups are compared by.
  double chi2_of_all() { return chi2_with(FreePerPixel::nothing); }
  /// Returns how many values that is of.
  std::uint64_t n_of_all() const;
  /// Returns the same where every pixel has numbers of its own. Neither renders.
  double chi2_with(FreePerPixel free);
  /// Puts the gain and black level that fit all values best into the samples of the sensitivity.
  void settle_sensors();
  /// Returns the standard errors of gain and black level of a camera, `index`: into samples(); with those of
  /// the parameters where both are fitted together.
  Eigen::Vector2d sensor_sigma(std::size_t index);
  /// Returns what these images cannot tell apart, as a sentence: two groups that change the gray values alike
  /// (a canonical correlation above 0.98), or parameters of light of which others do the same (eigenvalue of
  /// the correlation matrix below 1e-6); empty where there is none.
  std::string cannot_be_told();
  /// Returns whether a parameter changes nothing in these images.
  bool changes_nothing(std::size_t parameter);

 private:
  struct Block {
    FreePerPixel free = FreePerPixel::nothing;
    std::vector<std::size_t> at;  ///< of its parameters
  };
  /// The mean of some parameters, one or more, is that of their starts, to a standard deviation.
  struct Belief {
    std::vector<std::size_t> mean_of;
    double sigma = 0.0;
  };
  /// A damped step of some parameters and the sensors.
  struct Damped {
    std::vector<std::size_t> unknowns;  ///< in the equations
    Eigen::VectorXd change, sigma;
    Eigen::MatrixXd covariance;
    double fall = 0.0;       ///< of chi2, where nothing is damped
    std::vector<bool> null;  ///< of each parameter: whether others do the same, or it does nothing
  };

  /// Where a step leads.
  struct Stride {
    Eigen::VectorXd next;  ///< values of all parameters
    double expected;       ///< fall of chi2
    double sigmas;         ///< the longest step of a parameter, in its standard errors
  };

  void take_base(Sensitivity::Values base);
  void set_values(const Eigen::VectorXd& values);
  /// The same with chi2() of what is predicted there.
  void set_values_and_chi2(const Eigen::VectorXd& values);
  std::optional<std::size_t> grows_with(std::size_t parameter) const;
  double growth_of(std::size_t parameter) const;
  bool refers_curves_to_gain();
  Eigen::MatrixXd shown_by_unknowns(const std::vector<std::size_t>& told,
                                    const std::vector<std::size_t>& unknowns) const;
  FreePerPixel free_of(const Block& block) const;
  std::vector<std::size_t> sensors_of(FreePerPixel free) const;
  std::vector<std::size_t> told_of(const Block& block) const;
  double null_of(const std::vector<std::size_t>& parameters) const;
  std::vector<std::vector<std::size_t>> shares_of_others() const;
  std::vector<Belief> beliefs() const;
  double off_start(const Belief& belief, const Eigen::VectorXd& values) const;
  double prior_chi2(const Eigen::VectorXd& values) const;
  /// Returns what is predicted with these values, whose exposures the equations count with from now on.
  Sensitivity::Values predict(const Eigen::VectorXd& values);
  struct Settled {
    double chi2, loss;  ///< sums; the loss is what a fit makes least
  };
  Settled settled(const Sensitivity::Values& base, FreePerPixel free, bool settle);
  double settled_chi2(const Sensitivity::Values& base, FreePerPixel free, bool settle) {
    return settled(base, free, settle).chi2;
  }
  bool is_left_to_exact(double expected, double chi2) const;
  void render_columns();
  bool is_far_from_columns(double steps) const;
  bool leads_outside(std::size_t parameter, double change) const;
  bool cannot_come_near(double chi2, double expected, std::uint64_t n) const;
  NormalEquations equations_with_prior(FreePerPixel free);
  /// Returns the sums of the images at the values as they are, the last ones where nothing changed since.
  const NormalEquations& sums(FreePerPixel free);
  Damped solve(const NormalEquations& e, std::vector<std::size_t> unknowns, FreePerPixel free,
               double damping) const;
  Stride stride(const NormalEquations& e, std::vector<std::size_t> told, FreePerPixel free, double damping,
                double chi2) const;
  double try_values(const Eigen::VectorXd& next, FreePerPixel free, double loss);
  bool fit(const Block& block);
  void fit_all();
  std::optional<std::size_t> one_of_the_same(const std::vector<std::size_t>& told,
                                             const std::vector<bool>& null, const NormalEquations& e) const;
  bool leave_out_what_is_not_told();
  void tell(const Block& block);
  std::string alike_groups(const NormalEquations& e, FreePerPixel free) const;
  std::string alike_lights(const NormalEquations& e, FreePerPixel free) const;

  Sensitivity& sensitivity_;
  Twin twin_;
  std::vector<Parameter> parameters_;
  GroupFitOptions options_;
  Eigen::VectorXd values_;
  std::vector<Known> known_;
  /// Sums, and all that they were made of: the counts of predictions and derivatives, what is free and how
  /// the sensitivity stood.
  struct Sums {
    std::uint64_t of_base, of_columns;
    FreePerPixel free;
    std::vector<double> standing;
    NormalEquations equations;
  };

  Sensitivity::Values base_;  ///< what the values predict
  std::optional<Sensitivity::Columns> columns_;
  std::uint64_t n_bases_ = 0, n_columns_ = 0;  ///< taken so far
  std::optional<Sums> last_sums_;
  Eigen::VectorXd columns_at_;  ///< the values there
  Sensitivity::Derivative derivative_ = Sensitivity::Derivative::quick;
  std::vector<Block> blocks_;
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd sensor_sigma_;  ///< as the unknowns of the equations; empty: not fitted with the parameters
  std::vector<CauseRegion> regions_;
  std::string unexplained_;
  double chi2_ = 0.0;
  std::uint64_t n_ = 0;
  int n_steps_ = 0;
  bool converged_ = false, given_up_ = false;
};

}  // namespace fringetwin::compare
