// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/calibration_budget.hpp"

#include <cmath>

#include "compare/geometry/fit_rows.hpp"
#include "compare/phase/phase_rows.hpp"
#include "measure/measurement.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

using measure::Measurement;

/// What a rig records and what the nominal twin makes of it.
struct Recorded {
  std::vector<std::vector<ImageF>> irradiance;  ///< per camera, sequence order
  Measurement measurement;
};

ImageF exact_gray(const ImageF& irradiance, const Sensor& sensor) {
  ImageF out(irradiance.width, irradiance.height);
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data[i] =
        static_cast<float>(sensor.gain_dn * static_cast<double>(irradiance.data[i]) + sensor.black_level_dn);
  return out;
}

/// Gray values, not irradiance: thresholds and noise weights of the measurement are then those of the run.
CameraImages exact_exposure(const render::RenderedCamera& rendered, const Sensor& sensor) {
  CameraImages out;
  out.camera = rendered.camera;
  out.bit_depth = sensor.bit_depth;
  for (const ImageF& image : rendered.irradiance) out.images.push_back(exact_gray(image, sensor));
  if (rendered.white) out.white = exact_gray(*rendered.white, sensor);
  if (rendered.black) out.black = exact_gray(*rendered.black, sensor);
  return out;
}

class BudgetSums {
 public:
  BudgetSums(const Twin& twin, render::Renderer& renderer, const render::Sampling& sampling,
             std::uint64_t seed, const std::vector<int>& use_steps)
      : twin_(twin), renderer_(renderer), sampling_(sampling), seed_(seed), use_steps_(use_steps) {
    const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
    for (std::size_t k = 0; k < patterns.size(); ++k)
      if (twin.fringes.steps == 0 || (!patterns[k].is_gray() && !patterns[k].is_image()))
        images_.push_back(k);
    nominal_ = record(twin);
    for (const Camera& camera : twin.cameras)
      out_.irradiance.emplace_back(camera.lens.width(), camera.lens.height(), 0.0F);
    for (const measure::CameraDecode& decode : nominal_.measurement.cameras) {
      out_.phase_rad2.emplace_back();
      for (const measure::DirectionDecode& d : decode.directions)
        out_.phase_rad2.back().emplace_back(d.coordinate_px.width, d.coordinate_px.height, 0.0F);
    }
    for (const measure::ObjectFit& fit : nominal_.measurement.fits)
      if (fit.usable) out_.fits[fit.object];
  }

  void add(const Twin& changed) {
    const Recorded recorded = record(changed);
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c) {
      add_irradiance(recorded, c);
      add_phase(recorded, c);
    }
    add_fits(recorded);
    ++out_.n_directions;
  }

  CalibrationBudget take() { return std::move(out_); }

 private:
  Recorded record(const Twin& rig) {
    Recorded out;
    std::vector<CameraImages> images;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      throw_if_cancelled();
      render::RenderedCamera rendered = renderer_.render(rig, c, sampling_, seed_);
      images.push_back(exact_exposure(rendered, rig.cameras[c].sensor));
      out.irradiance.push_back(std::move(rendered.irradiance));
    }
    out.measurement = measure::measure(twin_, images, use_steps_);
    return out;
  }

  void add_irradiance(const Recorded& recorded, std::size_t c) {
    const auto size = static_cast<std::int64_t>(out_.irradiance[c].size());
#pragma omp parallel for schedule(static)
    for (std::int64_t pixel = 0; pixel < size; ++pixel) {
      const auto i = static_cast<std::size_t>(pixel);
      double sum = 0.0;
      for (const std::size_t k : images_)
        sum += std::pow(static_cast<double>(recorded.irradiance[c][k].data[i]) -
                            static_cast<double>(nominal_.irradiance[c][k].data[i]),
                        2);
      out_.irradiance[c].data[i] += static_cast<float>(sum / static_cast<double>(images_.size()));
    }
  }

  void add_phase(const Recorded& recorded, std::size_t c) {
    const measure::CameraDecode &from = nominal_.measurement.cameras[c],
                                &to = recorded.measurement.cameras[c];
    for (std::size_t d = 0; d < from.directions.size(); ++d) {
      if (from.directions[d].coordinate_px.empty() || from.directions[d].pitches_px.empty()) continue;
      const ImageF change = phase_difference(from.directions[d], to.directions[d]);
      ImageF& sum = out_.phase_rad2[c][d];
      for (std::size_t i = 0; i < change.size(); ++i)  // NaN: valid on one side only
        if (!std::isnan(change.data[i])) sum.data[i] += change.data[i] * change.data[i];
    }
  }

  void add_fits(const Recorded& recorded) {
    for (std::size_t f = 0; f < nominal_.measurement.fits.size(); ++f) {
      const std::string& object = nominal_.measurement.fits[f].object;
      const auto at = out_.fits.find(object);
      if (at == out_.fits.end()) continue;
      const measure::ObjectFit& fit = recorded.measurement.fits[f];
      if (!fit.usable) {
        out_.warnings.push_back(
            "the fit of \"" + object +
            "\" fails within the calibration's uncertainty: it is left out of its budget");
        out_.fits.erase(at);
        continue;
      }
      const FitRow row = make_fit_row(nominal_.measurement.fits[f], fit);
      for (const auto& [key, value] : row.difference) at->second.numbers[key] += value * value;
      for (const auto& [key, value] : row.difference_vectors)
        at->second.vectors.try_emplace(key, Eigen::Vector3d::Zero()).first->second += value.cwiseAbs2();
    }
  }

  const Twin& twin_;
  render::Renderer& renderer_;
  const render::Sampling sampling_;
  std::uint64_t seed_;
  const std::vector<int>& use_steps_;
  std::vector<std::size_t> images_;
  Recorded nominal_;
  CalibrationBudget out_;
};

}  // namespace

CalibrationBudget calibration_budget(const Twin& twin, const CalibrationCovariance& covariance,
                                     render::Renderer& renderer, const render::Sampling& sampling,
                                     std::uint64_t seed, const std::vector<int>& use_steps) {
  const Eigen::MatrixXd changes = one_sigma_changes(covariance);
  Progress progress("calibration's uncertainty", static_cast<std::size_t>(changes.cols()) + 1);
  BudgetSums sums(twin, renderer, sampling, seed, use_steps);
  progress.advance();
  for (Eigen::Index i = 0; i < changes.cols(); ++i) {
    sums.add(with_rig_change(twin, covariance, changes.col(i)));
    progress.advance();
  }
  return sums.take();
}

}  // namespace fringetwin::compare
