// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/rig_budget.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "compare/geometry/fit_rows.hpp"
#include "compare/phase/phase_rows.hpp"
#include "measure/measurement.hpp"
#include "render/sensor/all_cameras.hpp"
#include "render/sensor/sensor.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::compare {
namespace {

using measure::Measurement;

ImageF exact_gray(const GrayImage& irradiance, const Sensor& sensor) {
  ImageF out(irradiance.width, irradiance.height);
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data[i] =
        static_cast<float>(sensor.gain_dn * static_cast<double>(irradiance[i]) + sensor.black_level_dn);
  return out;
}

/// Returns gray values, not irradiance: thresholds and noise weights of the measurement are then those of the
/// run.
CameraImages exact_exposure(const CameraImages& irradiance, const Sensor& sensor) {
  CameraImages out{.camera = irradiance.camera, .bit_depth = sensor.bit_depth};
  for (const GrayImage& image : irradiance.images) out.images.push_back(exact_gray(image, sensor));
  if (irradiance.white) out.white = exact_gray(*irradiance.white, sensor);
  if (irradiance.black) out.black = exact_gray(*irradiance.black, sensor);
  return out;
}

/// Adds up the squared changes of irradiance, phase and fits that changed rigs make.
class BudgetSums {
 public:
  /// `irradiance` of the twin itself, which must outlive this.
  BudgetSums(const Twin& twin, const std::vector<CameraImages>& irradiance, const std::vector<int>& use_steps,
             std::string line)
      : twin_(twin),
        use_steps_(use_steps),
        nominal_irradiance_(irradiance),
        nominal_(measure_exactly(twin, irradiance)) {
    out_.line = std::move(line);
    const std::vector<PatternSpec> patterns = expand_sequence(twin.fringes);
    for (std::size_t k = 0; k < patterns.size(); ++k)
      if (twin.fringes.steps == 0 || (!patterns[k].is_gray() && !patterns[k].is_image()))
        images_.push_back(k);
    for (const Camera& camera : twin.cameras)
      out_.irradiance.emplace_back(camera.lens.width(), camera.lens.height(), 0.0F);
    for (const measure::CameraDecode& decode : nominal_.cameras) {
      out_.phase_rad2.emplace_back();
      for (const measure::DirectionDecode& d : decode.directions)
        out_.phase_rad2.back().emplace_back(d.coordinate_px.width, d.coordinate_px.height, 0.0F);
    }
    for (const measure::ObjectFit& fit : nominal_.fits)
      if (fit.usable) out_.fits[fit.object];
  }

  /// Adds what a changed rig records of the scene.
  void add(const Twin& rig, const std::vector<CameraImages>& irradiance) {
    const Measurement measurement = measure_exactly(rig, irradiance);
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c) {
      add_irradiance(irradiance[c], c);
      add_phase(measurement, c);
    }
    add_fits(measurement);
    ++out_.n_directions;
  }

  RigBudget take() { return std::move(out_); }

 private:
  /// Measures, with the twin, what a rig records without noise and rounding.
  Measurement measure_exactly(const Twin& rig, const std::vector<CameraImages>& irradiance) const {
    std::vector<CameraImages> images;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      images.push_back(exact_exposure(irradiance[c], rig.cameras[c].sensor));
    return measure::measure(twin_, images, use_steps_);
  }

  void add_irradiance(const CameraImages& irradiance, std::size_t c) {
    const auto size = static_cast<std::int64_t>(out_.irradiance[c].size());
#pragma omp parallel for schedule(static)
    for (std::int64_t pixel = 0; pixel < size; ++pixel) {
      double sum = 0.0;
      for (const std::size_t k : images_)
        sum += std::pow(static_cast<double>(irradiance.images[k][pixel]) -
                            static_cast<double>(nominal_irradiance_[c].images[k][pixel]),
                        2);
      out_.irradiance[c].data[pixel] += static_cast<float>(sum / static_cast<double>(images_.size()));
    }
  }

  void add_phase(const Measurement& measurement, std::size_t c) {
    const measure::CameraDecode &from = nominal_.cameras[c], &to = measurement.cameras[c];
    for (std::size_t d = 0; d < from.directions.size(); ++d) {
      if (from.directions[d].coordinate_px.empty() || from.directions[d].pitches_px.empty()) continue;
      const ImageF change = phase_difference(from.directions[d], to.directions[d]);
      ImageF& sum = out_.phase_rad2[c][d];
      for (std::size_t i = 0; i < change.size(); ++i)  // NaN: valid on one side only
        if (!std::isnan(change.data[i])) sum.data[i] += change.data[i] * change.data[i];
    }
  }

  void add_fits(const Measurement& measurement) {
    for (std::size_t f = 0; f < nominal_.fits.size(); ++f) {
      const std::string& object = nominal_.fits[f].object;
      const auto at = out_.fits.find(object);
      if (at == out_.fits.end()) continue;
      const measure::ObjectFit& fit = measurement.fits[f];
      if (!fit.usable) {
        out_.warnings.push_back("the fit of \"" + object + "\" fails within the rig's uncertainty (" +
                                out_.line + "): it is left out of its budget");
        out_.fits.erase(at);
        continue;
      }
      const FitRow row = make_fit_row(nominal_.fits[f], fit);
      for (const auto& [key, value] : row.difference) at->second.numbers[key] += value * value;
      for (const auto& [key, value] : row.difference_vectors)
        at->second.vectors.try_emplace(key, Eigen::Vector3d::Zero()).first->second += value.cwiseAbs2();
    }
  }

  const Twin& twin_;
  const std::vector<int>& use_steps_;
  const std::vector<CameraImages>& nominal_irradiance_;
  std::vector<std::size_t> images_;
  Measurement nominal_;
  RigBudget out_;
};

/// Renders all cameras of a rig.
std::vector<CameraImages> irradiance_of(const Twin& rig, render::Renderer& renderer,
                                        const render::Sampling& sampling, std::uint64_t seed) {
  std::vector<CameraImages> out;
  for (render::RenderedCamera& rendered : render::render_all(renderer, rig, sampling, seed))
    out.push_back(render::as_radiance(std::move(rendered)));
  return out;
}

}  // namespace

RigBudget rig_budget(const Twin& twin, const std::vector<Twin>& changed, std::string line,
                     const RigBudgetOptions& options) {
  const auto rendered = [&options](const Twin& rig) {
    return irradiance_of(rig, options.renderer, options.sampling, options.seed);
  };
  Progress progress(line, changed.size() + 1);
  const std::vector<CameraImages> own =
      options.nominal.empty() ? rendered(twin) : std::vector<CameraImages>();
  BudgetSums sums(twin, options.nominal.empty() ? own : options.nominal, options.use_steps, std::move(line));
  progress.advance();
  for (const Twin& rig : changed) {
    sums.add(rig, rendered(rig));
    progress.advance();
  }
  return sums.take();
}

RigBudget together(RigBudget calibration, const RigBudget& other) {
  const auto add = [](ImageF& to, const ImageF& from) {
    std::ranges::transform(to.data, from.data, to.data.begin(), std::plus());
  };
  for (std::size_t c = 0; c < calibration.irradiance.size(); ++c) {
    add(calibration.irradiance[c], other.irradiance[c]);
    for (std::size_t d = 0; d < calibration.phase_rad2[c].size(); ++d)
      add(calibration.phase_rad2[c][d], other.phase_rad2[c][d]);
  }
  // a fit that one of them has left out has no budget
  std::erase_if(calibration.fits, [&other](const auto& fit) { return !other.fits.contains(fit.first); });
  for (auto& [object, to] : calibration.fits) {
    const RigBudget::Fit& fit = other.fits.at(object);
    for (const auto& [key, variance] : fit.numbers) to.numbers[key] += variance;
    for (const auto& [key, variance] : fit.vectors)
      to.vectors.try_emplace(key, Eigen::Vector3d::Zero()).first->second += variance;
  }
  calibration.n_directions += other.n_directions;
  std::ranges::copy(other.warnings, std::back_inserter(calibration.warnings));
  return calibration;
}

}  // namespace fringetwin::compare
