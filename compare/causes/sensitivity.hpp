// SPDX-License-Identifier: Apache-2.0
// Computes what a change of a twin does to the gray values, and how much of the difference to the real ones
// that change would take away, by least squares through the renderer.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/gray/gain_fit.hpp"
#include "compare/gray/gray_noise.hpp"
#include "compare/parameters/grid_view.hpp"
#include "compare/parameters/parameter.hpp"
#include "compare/result/own_kinds.hpp"

namespace fringetwin::compare {

/// Samples at most `most` interior pixels of the pair in `images` of the sequence (empty: those that the gain
/// is fitted on); the weights come from `noise` and rendering_dn, the rms rendering error.
GridSamples grid_samples(const GrayPair& pair, std::size_t camera_index, const GainFit& fit,
                         const GrayNoise& noise, const ImageU8& interior, double rendering_dn,
                         std::size_t most, std::vector<int> images = {});

/// Fills GridSamples::at_texture_edge of samples of this pair.
void find_texture_edges(const GrayPair& pair, const UsableRange& usable, const GrayNoise& noise,
                        GridSamples& samples);

/// Normal equations of r = y - (gain E + black) in the parameters, then gain and black level of each camera,
/// then the gains of the images that are lit apart: minimise sum w^2 rho(r - J d). Huber weights at 3 robust
/// scales (at least 3 standard deviations).
struct NormalEquations {
  Eigen::MatrixXd normal;
  Eigen::VectorXd right;
  double chi2 = 0.0;             ///< sum of weighted squares before any step
  std::uint64_t n = 0;           ///< values
  std::size_t n_parameters = 0;  ///< the first ones; then (gain, black) per camera, then those of images
  /// What Huber's loss, which the step makes least, has of values beyond the robust scale besides chi2: there
  /// the square of a value with its robust weight grows half as fast as the loss.
  double beyond = 0.0;
  std::size_t gain_at(std::size_t camera) const { return n_parameters + 2 * camera; }
  std::size_t black_at(std::size_t camera) const { return gain_at(camera) + 1; }
  /// Returns the rows and columns of some unknowns, in their order.
  Eigen::MatrixXd normal_of(const std::vector<std::size_t>& unknowns) const;
};

/// The step of some unknowns, the others held. Directions that the data do not tell (eigenvalue of the scaled
/// normal matrix below 1e-9) are left out.
struct Step {
  Eigen::VectorXd change, sigma;  ///< full length, 0 where held
  double chi2 = 0.0;              ///< that the linear model leaves
  int n_determined = 0;
};
/// Solves the equations for these unknowns.
Step solve_step(const NormalEquations& equations, const std::vector<std::size_t>& unknowns);

/// Renders changed twins on the samples of all cameras and sets up the normal equations of their gray values.
class Sensitivity {
 public:
  /// Per camera, laid out as GridSamples::real_dn.
  using Values = std::vector<std::vector<float>>;
  /// Points per pixel: of residuals, of derivatives, and of what tells that few points suffice.
  static constexpr int kResidualSamples = 9, kDerivativeSamples = 4, kFineSamples = 36;
  static constexpr int kCodeSamples = 25;  ///< of residuals where edges of a code from a table need more
  static constexpr double kHuberSigmas = 3.0;

  Sensitivity(render::Renderer& renderer, std::vector<GridSamples> samples);

  const std::vector<GridSamples>& samples() const { return samples_; }
  /// Sets gain and black level of a camera; `index`: into samples(). Images lit apart keep their factors.
  void set_sensor(std::size_t index, double gain_dn, double black_level_dn);
  /// Takes gain, black level and the light of images lit apart from others, camera by camera.
  void take_sensors(const std::vector<GridSamples>& from);
  /// Moves them by a step in equations without parameters.
  void move_sensors(const Eigen::VectorXd& change);
  /// Returns the places of the gains of images lit apart among the unknowns of equations of so many
  /// parameters: of one camera, in the order of its lit_apart.
  std::vector<std::size_t> lights_at(std::size_t camera, std::size_t n_parameters) const;
  /// Finds the light of images lit apart for a prediction, gain and black level held.
  void settle_lights(const Values& predicted);
  /// Tells the cameras' curves at the gain as it is now (GridSamples::reference_gain_dn).
  void refer_curves_to_gain();

  /// Returns what a mean of n squares over their noise must not exceed, as in the verdict on the gray values,
  /// with the noise of the camera that it is known worst of.
  double chi2_limit(double n) const;
  /// The same of a mean of n squared sums over regions, whose noise is that of the mean level.
  double regional_limit(double n) const;

  /// Takes the noise of every value at what is predicted of it, with the gain and black level as they are.
  void weigh_at(const Values& predicted);
  /// The same with what each pixel has of its own: a dark board has bright marks, the light of a lamp noise.
  void weigh_with_field_at(const Values& predicted, FreePerPixel free);
  /// Takes the scatter of the bounces of a twin into the weights, as its samples have it.
  void add_scatter_of(const Twin& twin);

  /// Leaves out the pixels where the points of a pixel do not tell its mean, because an edge of a facet or a
  /// shadow crosses it, and those beside them: 3 x 3 and 6 x 6 points differ by 0.2 standard deviations.
  /// Sums over them would jump where an edge passes a point. Leaves all where that would be more than half of
  /// a camera's pixels. Returns how many it left out.
  std::size_t leave_out_edges(const Twin& twin);

  /// Leaves out the pixels at_texture_edge, whose images no factor of their own describes; all stay where
  /// that would be more than half of a camera's pixels.
  void leave_out_texture_edges();

  /// Takes the exposures of the images from a twin: what a pixel has of its own in offset they let in, too.
  void take_exposures(const Twin& twin);
  /// Gives every pixel numbers of its own in all equations from now on: a brightness (texture), an offset.
  void free_in_all(FreePerPixel own) { own_ = own; }
  bool has_free_factors() const { return frees_factor(own_); }
  /// Returns what is free in equations that free so much themselves.
  FreePerPixel with_own(FreePerPixel free) const { return together(free, own_); }
  /// Returns the robust scale of each camera; to compare two sums of squares, set the scale of one for the
  /// other.
  const std::vector<double>& scale() const { return threshold_; }
  /// Returns all that equations_at() counts with besides what it is given: where it is the same, they are.
  std::vector<double> standing() const;
  void set_scale(const std::vector<double>& scale) { threshold_ = scale; }
  void choose_scale(const Twin& twin) {
    choose_scale(irradiance(twin, residual_samples()), FreePerPixel::nothing);
  }
  /// Takes more points per pixel for this twin and those like it where the edges of a code, which a projector
  /// with a halo shows from a table, need them: 9 and 25 points differ by more than 0.05 standard deviations
  /// rms, which sums over regions would show.
  void choose_points(const Twin& twin);
  /// Returns the points per pixel of residuals.
  int residual_samples() const { return residual_samples_; }
  /// Returns whether there are images of a code among the samples.
  bool holds_code(const Twin& twin) const;

  /// Returns the irradiance that a twin predicts, from so many points per pixel.
  Values irradiance(const Twin& twin, int samples) const;
  /// Returns the irradiance that a twin with these values predicts, with the effects of those that change no
  /// twin. With `camera` the other cameras' is that of `others`.
  Values predicted(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                   int samples, std::optional<std::size_t> camera = {}, const Values* others = nullptr) const;
  /// The same from as many points as residuals have.
  Values predicted(const Twin& twin, const std::vector<Parameter>& parameters,
                   const Eigen::VectorXd& values) const {
    return predicted(twin, parameters, values, residual_samples_);
  }

  /// How derivatives are taken: quick ones are the difference to one more rendering, with steps that change
  /// the images by about 0.3 % of their size; their errors (curvature, rounding) would make parameters that
  /// cannot be told apart look as if they could. Exact ones are central, with steps of 2 %, or shorter
  /// ones where the images bend over those or a bound is near; one-sided at a bound.
  enum class Derivative { quick, exact };
  /// A step of a quick derivative: as long as changes the images by what is wanted, or shorter where they
  /// bend.
  struct DerivativeStep {
    double length = 0.0, longest = 0.0;  ///< as long as it may grow
    bool is_refused = false;             ///< over a shorter one the images bent no less
    /// The first one: it may grow to a thousand times what suits a rig of usual size.
    static DerivativeStep of(const Parameter& p) { return {p.step, 1e3 * p.step}; }
  };

  /// Derivatives of the irradiance by the parameters, zeros where one changes nothing, and the irradiance
  /// from as many points per pixel, so that what changes the images as the gain does cannot be told from it.
  struct Columns {
    Values rough;
    std::vector<Values> each;
    std::vector<DerivativeStep> steps = {};
    std::vector<bool> exposes =
        {};  ///< of each: all light is in proportion to it, a pixel's own, too; or empty
  };
  /// `steps`: where the search for each step begins; empty: with those of the parameters.
  Columns columns(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                  Derivative derivative = Derivative::quick, std::vector<DerivativeStep> steps = {});
  /// Fills GridSamples::pose_slopes of all samples, which the columns of motion need, with the columns of a
  /// pose; `pose`: their places among the columns.
  void take_pose_slopes(const Columns& columns, const std::vector<std::size_t>& pose);
  /// Returns the columns of the parameters of all groups, those of motion with the slopes of `pose`, the
  /// places of a pose's parameters among them. Calls `after` with how many are done, after each.
  Columns columns_of_all_groups(const Twin& twin, const std::vector<Parameter>& parameters,
                                const Eigen::VectorXd& values, const std::vector<std::size_t>& pose,
                                const std::function<void(std::size_t)>& after);
  /// Returns the equations of these columns where `base` is predicted, with the robust scale as it is; of
  /// every `every`-th pixel only, which counts as often.
  NormalEquations equations_at(const Values& base, const Columns& columns, FreePerPixel free,
                               std::size_t every = 1) const;
  /// Sums of products of the columns times residuals (scores) over blocks of 28 x 28 px of the image and over
  /// images: their scatter tells standard errors where residuals belong together.
  struct Scatter {
    Eigen::MatrixXd blocks, images;
    std::size_t n_blocks = 0, n_images = 0;
  };
  Scatter scatter_at(const Values& base, const Columns& columns, FreePerPixel free) const;
  /// Sets the robust scale to that of the residuals of what is predicted.
  void choose_scale(const Values& base, FreePerPixel free);

  /// Returns the equations at `values`. A parameter that changes nothing has a column of zeros. Sets the
  /// robust scale.
  NormalEquations equations(const Twin& twin, const std::vector<Parameter>& parameters,
                            const Eigen::VectorXd& values, bool keep_scale = false,
                            Derivative derivative = Derivative::quick);
  /// Returns the equations of gain and black level alone, with the robust scale of the last equations(): they
  /// measure a step.
  NormalEquations equations_without_parameters(const Twin& twin) const {
    return equations_without_parameters(twin, {}, {});
  }
  NormalEquations equations_without_parameters(const Twin& twin, const std::vector<Parameter>& parameters,
                                               const Eigen::VectorXd& values) const;

  /// Returns what a predicted irradiance leaves of the i-th gray value, DN.
  static double residual(const GridSamples& s, const std::vector<float>& irradiance, std::size_t i);

 private:
  /// Returns the first pixel of one of the parts that sums over a camera's pixels are made of.
  std::size_t begin_of(std::size_t chunk, std::size_t camera) const;
  /// `step`: where the search begins, and where it ended.
  Values column(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                std::size_t at, const Values& base, Derivative derivative, DerivativeStep& step) const;
  /// Returns the points per pixel of derivatives: as many as of residuals where the edges of a code or high
  /// harmonics lie within pixels. With fewer the gradient of a fit that leaves something is not that of what
  /// it leaves.
  int derivative_samples(const Twin& twin, const std::vector<Parameter>& parameters) const;
  /// The column of a parameter with an effect of its own: nothing is rendered. What light does is done to
  /// the light before the cameras' fitted curves, and seen through them at levels as the pixels' own numbers
  /// make them.
  Values closed_column(const Twin& twin, const std::vector<Parameter>& parameters,
                       const Eigen::VectorXd& values, std::size_t at, const Values& base) const;
  /// Returns whether the places in the projector's image that light the samples are known.
  bool knows_places() const;
  /// Fills what the effects of these parameters need of their samples (find_waves(), find_harmonics()).
  void find_unit_sums(const Twin& fitted, const std::vector<Parameter>& parameters);
  /// Returns whether effects of sinusoids are none, and one rendering of all images tells what they stand
  /// for.
  bool renders_images_together(const Twin& fitted, const std::vector<Parameter>& parameters) const;
  /// Returns the column of a parameter that stands beside these, at its start; `known`: those that were asked
  /// for, by name.
  const Values& column_beside(const Parameter& other, const Twin& twin,
                              const std::vector<Parameter>& parameters, const Eigen::VectorXd& values,
                              const Values& base, Derivative derivative,
                              std::map<std::string, Values>& known) const;
  /// Returns whether the parameter's effect tells its derivative.
  bool tells_derivative(const Parameter& parameter) const;
  /// Returns the column of a parameter that does as another one whose column is `other` (Parameter::times).
  Values scaled_column(const Values& other, const Parameter& parameter) const;
  std::vector<float> irradiance_of(const Twin& twin, const GridSamples& samples, int points) const;
  /// Returns the change of the images of one camera, or of all, as part of their size.
  double relative_change(const Values& from, const Values& to, std::optional<std::size_t> camera) const;
  /// Returns the second difference of the images of one camera, or of all, as part of the first one.
  double curvature(const Values& less, const Values& base, const Values& more,
                   std::optional<std::size_t> camera) const;
  /// Images that differ by a step of a parameter; `from` is empty where they are those at the value itself.
  struct Difference {
    Values from = {}, to = {};
    double step = 0.0;
  };
  /// Returns the images beside the value; nothing where they do not change.
  std::optional<Difference> one_sided(const std::function<Values(double)>& images_at,
                                      const Parameter& parameter, double value, const Values& base,
                                      bool is_exact, DerivativeStep& found) const;
  /// Returns the images on both sides of the value from those on one side, nearer ones where they bend too
  /// much over the step.
  Difference central_difference(const std::function<Values(double)>& images_at, double value,
                                std::optional<std::size_t> camera, const Values& base, Difference found,
                                DerivativeStep& step) const;
  /// The unknowns that change the images of one camera: its gain and black level, where pixels have none of
  /// their own, behind the parameters whose columns are not zero there.
  struct Unknowns {
    std::vector<const float*> parameters = {};  ///< their columns, laid out as GridSamples::real_dn
    std::vector<bool> exposes = {};             ///< of these
    const float* of_gain = nullptr;             ///< the irradiance; null: the gain is none of them
    bool has_black = false;
    const float* of_lights = nullptr;   ///< the irradiance; null: those of images lit apart are no unknowns
    std::vector<Eigen::Index> at = {};  ///< place of each in the equations
    /// Which of them change the values of each image of the samples.
    std::vector<std::vector<Eigen::Index>> of_images = {};
  };
  Unknowns unknowns_of(std::size_t camera, const Columns& columns, FreePerPixel free,
                       const NormalEquations& layout) const;
  struct PixelScratch {
    Eigen::VectorXd weight, weighted_e, value, weighted_offset;
    Eigen::MatrixXd own;  ///< an orthonormal basis of what the pixel has of its own
    double beyond = 0.0;  ///< NormalEquations::beyond of the pixel
  };
  /// Writes the weighted derivatives of one pixel's values, a row per image and a column per unknown, and the
  /// residuals without what it has of its own. Returns how many numbers are left in them; where that is 0
  /// nothing is written.
  std::uint64_t pixel_rows(std::size_t camera, std::size_t pixel, const Values& base,
                           const Unknowns& unknowns, FreePerPixel free, PixelScratch& scratch,
                           Eigen::Ref<Eigen::MatrixXd> rows, Eigen::Ref<Eigen::VectorXd> residuals) const;
  /// Writes the derivatives of a pixel's values, the first of which is the `first` of the camera's. `e`: what
  /// is predicted of them; `own_offset`: what the pixel's own offset adds to the weighted values.
  static void fill_rows(const GridSamples& s, const Unknowns& unknowns, std::size_t first, double slope,
                        const float* e, const Eigen::VectorXd& own_offset, const Eigen::VectorXd& weight,
                        Eigen::Ref<Eigen::MatrixXd> rows);
  double exposure_of(std::size_t camera, std::size_t k) const {
    return exposures_.empty() ? 1.0 : exposures_[camera][k];
  }
  std::vector<double> exposures_of(std::size_t camera) const {
    return exposures_.empty() ? std::vector<double>{} : exposures_[camera];
  }
  /// Returns the real light that what pixels have of their own is told by; nothing where they have nothing.
  std::vector<float> light_for_own(const GridSamples& s) const;
  NormalEquations empty_equations(std::size_t n_parameters) const;
  void add_prior_of_lights(NormalEquations& equations) const;

  render::Renderer& renderer_;
  std::vector<GridSamples> samples_;
  FreePerPixel own_ = FreePerPixel::nothing;
  std::vector<std::vector<double>> exposures_;  ///< per camera and image of its samples; empty: 1
  std::vector<double> threshold_;               ///< of Huber's weights, standard deviations, per camera
  int residual_samples_ = kResidualSamples;
  std::uint64_t weighings_ = 0;  ///< how often the weights of values were changed
};

}  // namespace fringetwin::compare
