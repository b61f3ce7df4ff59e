// SPDX-License-Identifier: Apache-2.0
#include "compare/refine.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "compare/explained.hpp"
#include "compare/interior.hpp"
#include "compare/sensitivity.hpp"
#include "twin/errors.hpp"
#include "twin/progress.hpp"

namespace fringetwin::compare {
namespace {

constexpr std::size_t kPixels = 40'000;  ///< per camera
constexpr int kMostIterations = 20;
constexpr int kMostHalvings = 6;
constexpr double kSettled = 0.05;       ///< standard errors
constexpr double kCannotBeTold = 1e-6;  ///< eigenvalue of the scaled normal matrix: 1 - correlation^2
constexpr double kHighCorrelation = 0.98;

bool is_sensor_name(const std::string& name) { return name == "gain" || name == "black"; }

bool matches(const Parameter& p, const std::string& asked) {
  return p.group == asked || p.name == asked || p.name.starts_with(asked + ".");
}

/// Parameters asked for, in the order of the groups. Throws for a name that means nothing here.
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
    if (met[i] || is_sensor_name(asked[i])) continue;
    const auto& groups = parameter_groups();
    const bool known =
        std::any_of(groups.begin(), groups.end(), [&](const auto& g) { return g.name == asked[i]; });
    throw UserError(ExitCode::usage, "--refine " + asked[i],
                    known ? "the twin has no such parameter" : "is not known",
                    "use one or more of " + refine_names() + ", or a parameter's own name (projector.k1)");
  }
  return chosen;
}

class Refiner {
 public:
  Refiner(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
          const std::vector<std::string>& asked)
      : twin_(twin),
        parameters_(chosen_parameters(twin, asked)),
        keeps_gain_(std::find(asked.begin(), asked.end(), "gain") != asked.end()),
        keeps_black_(std::find(asked.begin(), asked.end(), "black") != asked.end()),
        sensitivity_(*options.renderer, collect(real, simulated, options)) {
    report_.asked = asked;
    for (const Parameter& p : parameters_) fits_albedo_ = fits_albedo_ || p.group == "albedo";
    if (fits_albedo_ && keeps_gain_)
      throw UserError(ExitCode::usage, "--refine", "gain and albedo enter the gray values only as a product",
                      "refine one of them; the other stays at the twin's value");
    for (std::size_t c = 0; fits_albedo_ && c < sensitivity_.samples().size(); ++c) {
      const GridSamples& s = sensitivity_.samples()[c];
      sensitivity_.set_sensor(c, twin.cameras[s.camera].sensor.gain_dn, s.black_level_dn);
    }
  }

  Refined run() {
    settle_switches();
    values_ = start_values(parameters_);
    start_from_fits();
    for (std::size_t k = 0; k < parameters_.size(); ++k) report_.rows.push_back(make_row(k));
    iterate();
    const Step last = solve_step(equations_, unknowns());
    const double inflation = std::sqrt(std::max(1.0, report_.chi2_after));
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      RefinedRow& row = report_.rows[k];
      row.after = parameters_[k].shown(values_[at]);
      row.sigma = parameters_[k].shown_sigma(values_[at], inflation * last.sigma[at]);
    }
    note_correlations();
    Refined out{with_values(twin_, parameters_, values_), {}};
    for (const GridSamples& s : sensitivity_.samples()) keep_sensor(s, last, inflation, out.twin);
    out.report = std::move(report_);
    return out;
  }

 private:
  std::vector<GridSamples> collect(const Side& real, const Side& simulated, const CompareOptions& options) {
    std::vector<std::string> warnings;
    std::vector<GridSamples> samples;
    const std::vector<GrayPair> pairs = pair_gray(twin_, real, simulated, options, warnings);
    for (std::size_t c = 0; c < pairs.size(); ++c) {
      const GainFit fit = fit_gain(pairs[c], warnings);
      if (!fit.row.usable) continue;
      const measure::CameraDecode* real_decode =
          real.measurement ? &real.measurement->cameras.at(c) : nullptr;
      const measure::CameraDecode* sim_decode =
          simulated.measurement ? &simulated.measurement->cameras.at(c) : nullptr;
      const GrayNoise noise(pairs[c], real_decode, options.use_steps);
      samples.push_back(grid_samples(pairs[c], c, fit, noise,
                                     interior_mask(pairs[c].mask, real_decode, sim_decode),
                                     rendering_error(*pairs[c].camera, options.rendered).gray_dn, kPixels));
    }
    if (samples.empty())
      throw UserError(ExitCode::input, "--refine", "no camera has enough gray values that both sides share",
                      "compare without --refine first and look at the report");
    start_fits_ = {real.measurement ? &real.measurement->fits : nullptr,
                   simulated.measurement ? &simulated.measurement->fits : nullptr};
    return samples;
  }

  /// What is solved for: the parameters, gain (unless held) and black level of each camera.
  std::vector<std::size_t> unknowns() const {
    std::vector<std::size_t> all;
    for (std::size_t k = 0; k < parameters_.size(); ++k) all.push_back(k);
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
      if (!fits_albedo_) all.push_back(equations_.gain_at(c));
      all.push_back(equations_.black_at(c));
    }
    return all;
  }
  std::vector<std::size_t> sensor_unknowns(const NormalEquations& e) const {
    std::vector<std::size_t> all;
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
      if (!fits_albedo_) all.push_back(e.gain_at(c));
      all.push_back(e.black_at(c));
    }
    return all;
  }

  /// Per gray value, with the best gain and black level.
  double chi2_of(const Twin& twin) const {
    const NormalEquations e = sensitivity_.equations_without_parameters(twin);
    return solve_step(e, sensor_unknowns(e)).chi2 / static_cast<double>(e.n);
  }

  /// An effect that is on or off is tried both ways; what fits better stays.
  void settle_switches() {
    for (auto p = parameters_.begin(); p != parameters_.end();) {
      if (!p->is_switch) {
        ++p;
        continue;
      }
      Twin other = twin_;
      p->change(other, p->start > 0.5 ? -1.0 : 1.0);
      const double as_is = chi2_of(twin_), changed = chi2_of(other);
      RefinedRow row{p->name, p->unit, p->start, p->start, 0.0};
      if (changed < as_is) {
        twin_ = other;
        row.after = 1.0 - p->start;
      }
      report_.chi2_before = std::isfinite(report_.chi2_before) ? report_.chi2_before : as_is;
      switches_.push_back(row);
      p = parameters_.erase(p);
    }
  }

  /// Spheres and planes begin where the fits of the two sides say, if that fits better: more than half a
  /// fringe away, gray levels lead astray.
  void start_from_fits() {
    const auto [real, simulated] = start_fits_;
    if (!real || !simulated) return;
    Eigen::VectorXd moved = values_;
    const auto find = [](const std::vector<measure::ObjectFit>& fits, const std::string& object) {
      const auto at =
          std::find_if(fits.begin(), fits.end(), [&](const auto& f) { return f.object == object; });
      return at != fits.end() && at->usable ? &*at : nullptr;
    };
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      const std::string& name = parameters_[k].name;
      const auto dot = name.find(".center_mm.");
      if (dot == std::string::npos) continue;
      const auto *r = find(*real, name.substr(0, dot)), *s = find(*simulated, name.substr(0, dot));
      if (!r || !s || !r->vectors.contains("center_mm") || !s->vectors.contains("center_mm")) continue;
      const int i = name.back() - 'x';
      moved[static_cast<Eigen::Index>(k)] += r->vectors.at("center_mm")[i] - s->vectors.at("center_mm")[i];
    }
    if (moved == values_) return;
    if (chi2_of(with_values(twin_, parameters_, moved)) < chi2_of(twin_)) values_ = moved;
  }

  void iterate() {
    for (report_.iterations = 1; report_.iterations <= kMostIterations; ++report_.iterations) {
      throw_if_cancelled();
      equations_ = sensitivity_.equations(twin_, parameters_, values_);
      if (report_.iterations == 1) refuse_what_cannot_be_told();
      const Step step = solve_step(equations_, unknowns());
      const double now =
          solve_step(equations_, sensor_unknowns(equations_)).chi2 / static_cast<double>(equations_.n);
      if (report_.iterations == 1 && !std::isfinite(report_.chi2_before)) report_.chi2_before = now;
      report_.chi2_after = now;
      report_.n = equations_.n;
      say(fmt::format("refine: step {}, chi2 {:.5g}", report_.iterations, now));
      if (parameters_.empty() || is_settled(step) || !take(step, now)) {
        report_.converged = true;
        break;
      }
      settle_sensors();
    }
    settle_sensors();
  }

  /// Best gain and black level for the values so far.
  void settle_sensors() {
    const NormalEquations e =
        sensitivity_.equations_without_parameters(with_values(twin_, parameters_, values_));
    const Step step = solve_step(e, sensor_unknowns(e));
    for (std::size_t c = 0; c < sensitivity_.samples().size(); ++c) {
      const GridSamples& s = sensitivity_.samples()[c];
      sensitivity_.set_sensor(c, s.gain_dn + step.change[static_cast<Eigen::Index>(e.gain_at(c))],
                              s.black_level_dn + step.change[static_cast<Eigen::Index>(e.black_at(c))]);
    }
  }

  bool is_settled(const Step& step) const {
    const double inflation = std::sqrt(std::max(1.0, report_.chi2_after));
    for (std::size_t k = 0; k < parameters_.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      if (std::abs(step.change[at]) > kSettled * inflation * step.sigma[at]) return false;
    }
    return true;
  }

  /// The step, or a half, a quarter ... of it; false when none lowers chi2 by a tenth of a standard error's
  /// worth.
  bool take(const Step& step, double now) {
    double factor = 1.0;
    for (int halving = 0; halving <= kMostHalvings; ++halving, factor *= 0.5) {
      Eigen::VectorXd next = values_;
      for (std::size_t k = 0; k < parameters_.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        next[at] = std::clamp(values_[at] + factor * step.change[at], parameters_[k].smallest,
                              parameters_[k].largest);
      }
      double chi2 = 0.0;
      try {
        chi2 = chi2_of(with_values(twin_, parameters_, next));
      } catch (const UserError&) {
        continue;  // no such lens
      }
      if (chi2 < now - 0.01 / static_cast<double>(equations_.n)) {
        values_ = next;
        return true;
      }
    }
    return false;
  }

  void refuse_what_cannot_be_told() const {
    for (std::size_t k = 0; k < parameters_.size(); ++k)
      if (const auto at = static_cast<Eigen::Index>(k); !(equations_.normal(at, at) > 0.0))
        throw UserError(ExitCode::usage, "--refine " + parameters_[k].name, "changes nothing in these images",
                        "leave it out");
    const std::vector<std::size_t> all = unknowns();
    const auto m = static_cast<Eigen::Index>(all.size());
    Eigen::MatrixXd scaled(m, m);
    const auto entry = [&](Eigen::Index i, Eigen::Index j) {
      return equations_.normal(static_cast<Eigen::Index>(all[static_cast<std::size_t>(i)]),
                               static_cast<Eigen::Index>(all[static_cast<std::size_t>(j)]));
    };
    for (Eigen::Index i = 0; i < m; ++i)
      for (Eigen::Index j = 0; j < m; ++j) scaled(i, j) = entry(i, j) / std::sqrt(entry(i, i) * entry(j, j));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    if (eigen.eigenvalues()[0] > kCannotBeTold) return;
    std::string names;
    for (Eigen::Index i = 0; i < m; ++i)
      if (std::abs(eigen.eigenvectors()(i, 0)) > 0.15)
        names += (names.empty() ? "" : ", ") + unknown_name(all[static_cast<std::size_t>(i)]);
    throw UserError(ExitCode::usage, "--refine",
                    fmt::format("the images cannot tell these apart: {} (1 - correlation² = {:.1e})", names,
                                eigen.eigenvalues()[0]),
                    "refine fewer of them at a time");
  }

  std::string unknown_name(std::size_t at) const {
    if (at < parameters_.size()) return parameters_[at].name;
    const std::size_t c = (at - parameters_.size()) / 2;
    const std::string& camera = twin_.cameras[sensitivity_.samples()[c].camera].name;
    return camera + ((at - parameters_.size()) % 2 == 0 ? ".gain_dn" : ".black_level_dn");
  }

  void note_correlations() {
    const std::vector<std::size_t> all = unknowns();
    const auto m = static_cast<Eigen::Index>(all.size());
    Eigen::MatrixXd normal(m, m);
    for (Eigen::Index i = 0; i < m; ++i)
      for (Eigen::Index j = 0; j < m; ++j)
        normal(i, j) = equations_.normal(static_cast<Eigen::Index>(all[static_cast<std::size_t>(i)]),
                                         static_cast<Eigen::Index>(all[static_cast<std::size_t>(j)]));
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
                                              unknown_name(all[static_cast<std::size_t>(j)]),
                                              unknown_name(all[static_cast<std::size_t>(i)]), r));
      }
  }

  RefinedRow make_row(std::size_t k) const {
    const double start = parameters_[k].shown(parameters_[k].start);
    return {parameters_[k].name, parameters_[k].unit, start, start, 0.0};
  }

  void keep_sensor(const GridSamples& s, const Step& step, double inflation, Twin& twin) {
    const auto index = static_cast<std::size_t>(&s - sensitivity_.samples().data());
    Sensor& sensor = twin.cameras[s.camera].sensor;
    const auto sigma = [&](std::size_t at) { return inflation * step.sigma[static_cast<Eigen::Index>(at)]; };
    const std::string& camera = twin.cameras[s.camera].name;
    if (keeps_gain_) {
      report_.rows.push_back(
          {camera + ".gain_dn", "DN", sensor.gain_dn, s.gain_dn, sigma(equations_.gain_at(index))});
      sensor.gain_dn = s.gain_dn;
    }
    if (keeps_black_) {
      const double black = std::clamp(s.black_level_dn, 0.0, sensor.max_dn());
      report_.rows.push_back({camera + ".black_level_dn", "DN", sensor.black_level_dn, black,
                              sigma(equations_.black_at(index))});
      sensor.black_level_dn = black;
    }
    if (index == 0) report_.rows.insert(report_.rows.begin(), switches_.begin(), switches_.end());
  }

  Twin twin_;
  std::vector<Parameter> parameters_;
  bool keeps_gain_, keeps_black_, fits_albedo_ = false;
  std::pair<const std::vector<measure::ObjectFit>*, const std::vector<measure::ObjectFit>*> start_fits_{
      nullptr, nullptr};
  Sensitivity sensitivity_;
  Eigen::VectorXd values_;
  NormalEquations equations_;
  std::vector<RefinedRow> switches_;
  Refinement report_;
};

}  // namespace

std::string refine_names() {
  std::string names;
  for (const ParameterGroup& group : parameter_groups()) names += group.name + ", ";
  return names + "gain, black";
}

Refined refine(const Twin& twin, const Side& real, const Side& simulated, const CompareOptions& options,
               const std::vector<std::string>& asked) {
  FT_CHECK(options.renderer != nullptr, "refinement renders");
  return Refiner(twin, real, simulated, options, asked).run();
}

std::string refined_toml(const Refinement& r, const std::string& twin_file) {
  std::string text = fmt::format("# Values refined from {} (--refine", twin_file);
  for (const std::string& name : r.asked) text += " " + name;
  text += fmt::format("): put them into the twin by hand.\n# chi2 per gray value {:.5g} -> {:.5g}\n",
                      r.chi2_before, r.chi2_after);
  for (const RefinedRow& row : r.rows)
    text += fmt::format("\"{}\" = {:.10g}  # {}was {:.10g}, standard error {:.2g}\n", row.name, row.after,
                        row.unit.empty() ? "" : row.unit + ", ", row.before, row.sigma);
  return text;
}

}  // namespace fringetwin::compare
