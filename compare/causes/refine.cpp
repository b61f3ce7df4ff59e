// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/refine.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "compare/causes/refine_start.hpp"
#include "compare/gray/interior_mask.hpp"
#include "compare/verdict/explained.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kPixels = 40'000;  ///< per camera
constexpr int kMostIterations = 20;
constexpr double kCannotBeTold = 1e-6;  ///< smallest eigenvalue of the correlation matrix
constexpr double kInvolved = 0.15;      ///< share of a parameter in a combination that cannot be told
constexpr double kHighCorrelation = 0.98;

bool is_no_parameter(const std::string& name) {
  return name == "gain" || name == "black" || name == "texture";
}

bool is_asked(const std::vector<std::string>& asked, const char* name) {
  return std::ranges::find(asked, name) != asked.end();
}

bool matches(const Parameter& p, const std::string& asked) {
  return p.group == asked || p.name == asked || p.name.starts_with(asked + ".");
}

/// Returns the parameters asked for, in the order of the groups. Throws for a name that means nothing here.
std::vector<Parameter> chosen_parameters(const Twin& twin, const std::vector<std::string>& asked) {
  std::vector<Parameter> chosen;
  std::vector<bool> met(asked.size(), false);
  for (const ParameterGroup& group : parameter_groups())
    for (Parameter& p : parameters_of(twin, group.name)) {
      bool wanted = false;
      for (std::size_t i = 0; i < asked.size(); ++i)
        if (matches(p, asked[i])) wanted = met[i] = true;
      if (wanted) chosen.push_back(std::move(p));
    }
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (met[i] || is_no_parameter(asked[i])) continue;
    const auto& groups = parameter_groups();
    const bool known = std::ranges::any_of(groups, [&](const auto& g) { return g.name == asked[i]; });
    throw UserError(ExitCode::usage, "--refine " + asked[i],
                    known ? "the twin has no such parameter" : "is not known",
                    "use one or more of " + refine_names() + ", or a parameter's own name (projector.k1)");
  }
  const bool albedo = std::ranges::any_of(chosen, [](const Parameter& p) { return p.group == "albedo"; });
  const bool texture = is_asked(asked, "texture");
  if (albedo && texture)
    throw UserError(ExitCode::usage, "--refine",
                    "texture, a factor per pixel, contains the albedo of the objects", "refine one of them");
  if ((albedo || texture) && is_asked(asked, "gain"))
    throw UserError(
        ExitCode::usage, "--refine",
        fmt::format("gain and {} enter the gray values only as a product", texture ? "texture" : "albedo"),
        "refine one of them; the other stays at the twin's value");
  return chosen;
}

class Refiner {
 public:
  Refiner(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
          const std::vector<std::string>& asked)
      : twin_(twin), real_(real), simulated_(simulated), sensitivity_(*options.renderer, collect(options)) {
    keeps_gain_ = is_asked(asked, "gain");
    keeps_black_ = is_asked(asked, "black");
    report_.asked = asked;
    for (Parameter& p : chosen_parameters(twin, asked)) {
      hold_gain_ = hold_gain_ || p.group == "albedo";
      (p.is_switch ? switches_ : parameters_).push_back(std::move(p));
    }
    if (is_asked(asked, "texture")) {
      textured_ = hold_gain_ = true;
      sensitivity_.free_factors();
    }
    for (std::size_t c = 0; hold_gain_ && c < sensitivity_.samples().size(); ++c) {
      const GridSamples& s = sensitivity_.samples()[c];
      sensitivity_.set_sensor(c, twin.cameras[s.camera].sensor.gain_dn, s.black_level_dn);
    }
  }

  Refined run() {
    const Twin as_written = twin_;
    const Eigen::VectorXd begin = values_to_begin_at();
    sensitivity_.choose_scale(twin_);
    const std::vector<double> scale = sensitivity_.scale();
    GaussNewton start(sensitivity_, as_written, {}, hold_gain_);
    // fringes of the wrong phase make a line fitted to them flat or falling: the line from the amplitudes
    // stays
    if (!provisional_) start.settle_sensors();
    report_.chi2_before = start.chi2_of(as_written);
    settle_switches(begin);
    GaussNewton fit(sensitivity_, twin_, parameters_, hold_gain_);
    fit.start_at(begin);
    auto outcome = GaussNewton::Outcome::moved;
    for (int i = 0; i < kMostIterations && outcome == GaussNewton::Outcome::moved; ++i) {
      outcome = fit.step();
      if (i == 0) refuse_what_cannot_be_told(fit);
      report_.iterations = i + 1;
      say(fmt::format("refine: step {}, chi2 {:.5g}", report_.iterations, fit.chi2()));
    }
    report_.converged = outcome == GaussNewton::Outcome::settled;
    // covariance, and what only looked as if it could be told apart
    if (fit.step(false, Sensitivity::Derivative::exact) == GaussNewton::Outcome::settled)
      report_.converged = true;
    refuse_what_cannot_be_told(fit);
    fit.settle_sensors();
    Refined out = finish(fit);
    // both with the scale of the start, or the robust sums would not compare
    sensitivity_.set_scale(scale);
    out.report.chi2_after = fit.chi2_of(out.twin);
    keep_the_better(out, as_written);
    return out;
  }

 private:
  std::vector<GridSamples> collect(const CompareOptions& options) {
    std::vector<std::string> warnings;
    std::string reasons;
    std::vector<GridSamples> samples;
    const std::vector<GrayPair> pairs = pair_gray(twin_, real_, simulated_, options, warnings);
    for (std::size_t c = 0; c < pairs.size(); ++c) {
      const measure::CameraDecode *real_decode = decode_of(real_, c), *sim_decode = decode_of(simulated_, c);
      const GrayNoise noise(pairs[c], real_decode, options.use_steps);
      const GainFit fit = fit_gain(pairs[c], warnings, &noise);
      if (!fit.has_line() || pairs[c].real->radiance) {
        const std::string why = fit.has_line() ? "the real images are irradiance" : fit.row.why;
        reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : "; ", pairs[c].camera->name, why);
        continue;
      }
      GridSamples grid = grid_samples(
          pairs[c], c, fit, noise, interior_mask(pairs[c].mask, real_decode, sim_decode),
          rendering_error(*pairs[c].camera, options.rendered, fit.row.gain_dn).with_edges_dn, kPixels);
      if (grid.n_pixels() == 0) {
        reasons += fmt::format("{}{}: no pixel lies inside a surface that both sides share",
                               reasons.empty() ? "" : "; ", pairs[c].camera->name);
        continue;
      }
      provisional_ = provisional_ || !fit.row.usable;
      samples.push_back(std::move(grid));
    }
    if (samples.empty())
      throw UserError(
          ExitCode::input, "--refine",
          "no camera has gray values to refine by" + (reasons.empty() ? "" : " (" + reasons + ")"),
          "compare without --refine first and look at the report");
    return samples;
  }

  /// Returns the values of the twin, or of the places that the real points give, and leaves out what is
  /// sampled badly there.
  Eigen::VectorXd values_to_begin_at() {
    sensitivity_.choose_scale(twin_);
    GaussNewton start(sensitivity_, twin_, parameters_, hold_gain_);
    if (real_.measurement) start_at_fitted_places(start, twin_, real_.measurement->cloud);
    if (const std::size_t n = sensitivity_.leave_out_edges(start.twin()))
      report_.notes.push_back(
          fmt::format("{} pixels on edges of facets and shadows, and beside them, are left out", n));
    return start.values();
  }

  /// Tries effects that are on or off both ways, with these values of the other parameters, and keeps what
  /// fits better.
  void settle_switches(const Eigen::VectorXd& values) {
    for (const Parameter& p : switches_) {
      Twin other = twin_;
      p.change(other, p.start > 0.5 ? -1.0 : 1.0);
      const GaussNewton as_is(sensitivity_, with_values(twin_, parameters_, values), {}, hold_gain_);
      RefinedRow row{p.name, p.unit, p.start, p.start, 0.0};
      if (as_is.chi2_of(with_values(other, parameters_, values)) < as_is.chi2()) {
        twin_ = other;
        row.after = 1.0 - p.start;
      }
      report_.rows.push_back(row);
    }
  }

  void refuse_what_cannot_be_told(const GaussNewton& fit) const {
    const NormalEquations& equations = fit.equations();
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (!(equations.normal(k, k) > 0.0))
        throw UserError(ExitCode::usage, "--refine " + parameters_[k].name, "changes nothing in these images",
                        "leave it out");
    const std::vector<std::size_t> all = fit.unknowns();
    const auto m = static_cast<Eigen::Index>(all.size());
    Eigen::MatrixXd scaled = equations.normal_of(all);
    const Eigen::VectorXd scale = scaled.diagonal().cwiseSqrt().cwiseInverse();
    scaled = scale.asDiagonal() * scaled * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    if (eigen.eigenvalues()[0] > kCannotBeTold) return;
    std::string names;
    for (Eigen::Index i = 0; i < m; ++i) {
      bool involved = false;
      for (Eigen::Index k = 0; k < m && eigen.eigenvalues()[k] <= kCannotBeTold; ++k)
        involved = involved || std::abs(eigen.eigenvectors()(i, k)) > kInvolved;
      if (involved) names += (names.empty() ? "" : ", ") + unknown_name(all[i]);
    }
    throw UserError(
        ExitCode::usage, "--refine",
        fmt::format(
            "the images cannot tell these apart: {} (smallest eigenvalue of their correlations {:.1e})",
            names, eigen.eigenvalues()[0]),
        "refine fewer of them at a time");
  }

  std::string unknown_name(std::size_t at) const {
    if (at < parameters_.size()) return parameters_[at].name;
    const std::size_t c = (at - parameters_.size()) / 2;
    const std::string& camera = twin_.cameras[sensitivity_.samples()[c].camera].name;
    return camera + ((at - parameters_.size()) % 2 == 0 ? ".gain_dn" : ".black_level_dn");
  }

  /// Reports standard errors, covariance and what is hardly told apart, from the last equations.
  Refined finish(const GaussNewton& fit) {
    report_.chi2_after = fit.chi2();  // of the converged scale, for the standard errors
    report_.n = fit.equations().n;
    const Step last = solve_step(fit.equations(), fit.unknowns());
    const double inflation = std::sqrt(std::max(1.0, report_.chi2_after));
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      const Parameter& p = parameters_[k];
      report_.rows.push_back({p.name, p.unit, p.shown(p.start), p.shown(fit.values()[k]),
                              p.shown_sigma(fit.values()[k], inflation * last.sigma[k])});
    }
    note_correlations(fit);
    Refined out{fit.twin(), {}};
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c)
      keep_sensor(c, fit.equations(), last, inflation, out.twin);
    if (textured_) note_texture();
    out.report = std::move(report_);
    return out;
  }

  void note_texture() {
    report_.texture.resize(twin_.cameras.size());
    for (const GridSamples& s : sensitivity_.samples())
      report_.texture[s.camera] = Refinement::Line{s.gain_dn, s.black_level_dn};
    report_.notes.push_back(
        "every pixel's brightness is taken from the capture: the gain is held at the twin's, and neither it "
        "nor what is common to all images of a pixel is evidence");
  }

  void note_correlations(const GaussNewton& fit) {
    const std::vector<std::size_t> all = fit.unknowns();
    const auto m = static_cast<Eigen::Index>(all.size());
    const Eigen::MatrixXd normal = fit.equations().normal_of(all);
    const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd covariance = scale.asDiagonal() *
                                       (scale.asDiagonal() * normal * scale.asDiagonal()).inverse() *
                                       scale.asDiagonal();
    const auto n_parameters = static_cast<Eigen::Index>(parameters_.size());
    report_.covariance =
        covariance.topLeftCorner(n_parameters, n_parameters) * std::max(1.0, report_.chi2_after);
    for (Eigen::Index i = 0; i < m; ++i)
      for (Eigen::Index j = 0; j < i; ++j) {
        const double r = covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
        if (std::abs(r) > kHighCorrelation && j < n_parameters)
          report_.notes.push_back(fmt::format("{} and {} are told apart poorly (correlation {:+.3f})",
                                              unknown_name(all[j]), unknown_name(all[i]), r));
      }
  }

  void keep_sensor(std::size_t index, const NormalEquations& equations, const Step& step, double inflation,
                   Twin& twin) {
    const GridSamples& s = sensitivity_.samples()[index];
    Sensor& sensor = twin.cameras[s.camera].sensor;
    const auto sigma = [&](std::size_t at) { return inflation * step.sigma[at]; };
    const std::string& camera = twin.cameras[s.camera].name;
    if (keeps_gain_) {
      report_.rows.push_back(
          {camera + ".gain_dn", "DN", sensor.gain_dn, s.gain_dn, sigma(equations.gain_at(index))});
      sensor.gain_dn = s.gain_dn;
    }
    if (keeps_black_) {
      const double black = std::clamp(s.black_level_dn, 0.0, sensor.max_dn());
      report_.rows.push_back(
          {camera + ".black_level_dn", "DN", sensor.black_level_dn, black, sigma(equations.black_at(index))});
      sensor.black_level_dn = black;
    }
  }

  Twin twin_;
  const Side &real_, &simulated_;
  bool provisional_ = false;  ///< a camera's line comes from its amplitudes; collect() sets it
  Sensitivity sensitivity_;
  std::vector<Parameter> parameters_, switches_;
  bool keeps_gain_ = false, keeps_black_ = false, hold_gain_ = false, textured_ = false;
  Refinement report_;
};

}  // namespace

std::string refine_names() {
  std::string names;
  for (const ParameterGroup& group : parameter_groups()) names += group.name + ", ";
  return names + "texture, gain, black";
}

void check_refine(const Twin& twin, const std::vector<std::string>& asked) { chosen_parameters(twin, asked); }

Refined refine(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
               const std::vector<std::string>& asked) {
  FT_CHECK(options.renderer != nullptr, "refinement renders");
  return Refiner(twin, real, simulated, options, asked).run();
}

void keep_the_better(Refined& refined, const Twin& before) {
  constexpr double kSame = 1e-6;  // of chi2: solving again from the minimum moves it by 1e-7
  Refinement& report = refined.report;
  if (report.chi2_after <= report.chi2_before * (1.0 + kSame)) return;
  report.notes.push_back(fmt::format("chi2 would rise from {:.5g} to {:.5g}: the twin stays as it is",
                                     report.chi2_before, report.chi2_after));
  refined.twin = before;
  report.chi2_after = report.chi2_before;
  report.covariance.setConstant(kNaN);
  report.texture.clear();
  for (RefinedRow& row : report.rows) row.after = row.before, row.sigma = kNaN;
}

void apply_texture(const Refinement& refinement, const std::vector<CameraImages>& real,
                   const std::vector<int>& images, std::vector<CameraImages>& irradiance) {
  for (std::size_t c = 0; c < refinement.texture.size(); ++c) {
    if (!refinement.texture[c]) continue;
    const double gain_dn = refinement.texture[c]->gain_dn,
                 black_level_dn = refinement.texture[c]->black_level_dn;
    const double saturation_dn = real[c].saturation_dn();
    std::vector<ImageF>& e = irradiance[c].images;
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < e.front().size(); ++i) {
      double ye = 0.0, ee = 0.0;
      for (const int image : images) {
        const auto k = static_cast<std::size_t>(image);
        const auto y = static_cast<double>(real[c].images[k].data[i]), x = static_cast<double>(e[k].data[i]);
        if (!(y < saturation_dn)) continue;
        ye += (y - black_level_dn) * x;
        ee += x * x;
      }
      const double factor = ee > 0.0 ? std::max(0.0, ye / (gain_dn * ee)) : 1.0;
      for (ImageF& image : e) image.data[i] = static_cast<float>(factor * static_cast<double>(image.data[i]));
    }
  }
}

}  // namespace fringetwin::compare
