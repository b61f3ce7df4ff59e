// SPDX-License-Identifier: Apache-2.0
#include "study/run/point_runner.hpp"

#include <algorithm>
#include <chrono>
#include <new>

#include "compare/result/result_json.hpp"
#include "compare/verdict/limits.hpp"
#include "measure/measurement.hpp"
#include "render/pattern/form_images.hpp"
#include "render/sensor/all_cameras.hpp"
#include "render/sensor/sensor.hpp"
#include "report/json.hpp"
#include "study/run/image_results.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/moving.hpp"

namespace fringetwin::study {
namespace {

bool sees_an_object(const std::vector<render::RenderedCamera>& cameras) {
  return std::ranges::any_of(cameras, [](const render::RenderedCamera& c) {
    return std::ranges::any_of(c.object.data, [](int k) { return k >= 0; });
  });
}

}  // namespace

PointRunner::PointRunner(PointTask task, render::Renderer& renderer)
    : task_(std::move(task)), renderer_(renderer) {}

PointOutcome PointRunner::run(const PlannedPoint& planned) {
  const auto start = std::chrono::steady_clock::now();
  PointOutcome out{.id = planned.point.id, .traced = false};
  try {
    out.numbers = numbers(planned, out);
    any_measured_ = true;
  } catch (const Cancelled&) {
    throw;
  } catch (const UnknownKey& e) {
    if (!any_measured_) throw;  // most likely misspelt: no other point will have it
    out.failed = true;
    out.reason = e.what();
  } catch (const std::bad_alloc&) {
    out.failed = true;
    out.reason = "not enough memory";
  } catch (const std::exception& e) {
    out.failed = true;
    out.reason = e.what();
  }
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

void PointRunner::load(const StudyPoint& point) {
  if (twin_ && settings_ == point.settings) return;
  if (task_.virtual_rig && !rig_) rig_.emplace(task_.twin, task_.calibration);
  Twin twin = rig_ ? rig_->drawn(point.settings) : compare::load_checked_twin(task_.twin, point.settings);
  measure::check_fringes(twin);
  load_meshes(twin, twin_ ? &*twin_ : nullptr);
  twin_ = std::move(twin);
  settings_ = point.settings;
  theory_.clear();
}

// Where objects move every image has a trace of its own; a point spread over the pixels of a colour sensor
// needs the whole sensor's.
bool PointRunner::forms_images_of_a_trace(const Twin& twin) {
  return !has_motion(twin) && std::ranges::none_of(twin.cameras, &Camera::spreads_over_sensor);
}

void PointRunner::trace(const PlannedPoint& planned) {
  if (!forms_images_of_a_trace(*twin_)) return;
  Twin lit = *twin_;
  planned.demand.apply(&lit);
  const render::Sampling sampling = render::choose_sampling(lit);
  for (std::size_t i = 0; i < lit.cameras.size(); ++i) {
    throw_if_cancelled();
    traces_.push_back(renderer_.trace(lit, i, sampling, planned.point.seed));
  }
}

std::map<std::string, double> PointRunner::numbers(const PlannedPoint& planned, PointOutcome& out) {
  load(planned.point);
  if (!keys_ || keys_->trace != planned.keys.trace || demand_ != planned.demand) {
    keys_.reset();
    traces_.clear();
    rendered_.clear();
    trace(planned);
    demand_ = planned.demand;
    out.traced = true;
  }
  if (!keys_ || keys_->form != planned.keys.form) {
    keys_.reset();
    rendered_.clear();
    if (!forms_images_of_a_trace(*twin_)) {
      traces_.clear();
      rendered_ = render::render_all(renderer_, *twin_, planned.point.seed);
    } else if (traces_.empty()) {  // the point before had none
      trace(planned);
      out.traced = true;
    }
    for (std::size_t i = 0; i < traces_.size(); ++i) {
      if (render::holds_any_steps(*twin_)) render::set_pattern(*twin_, &traces_[i]);
      rendered_.push_back(render::form_camera(*twin_, i, traces_[i]));
    }
    keys_ = planned.keys;
  }
  if (!sees_an_object(rendered_))
    throw UserError(ExitCode::usage, task_.twin.string(), "no camera sees any object");
  const std::vector<CameraImages> images = render::expose_all(rendered_, *twin_, planned.point.seed);
  const Twin& known = rig_ ? rig_->measuring(planned.point.settings) : *twin_;
  measure::Measurement measurement = measure::measure(known, images);
  out.gate_warnings = measurement.gate_warnings;
  if (known.measure.correct_pixel_area && !rig_) {  // a rig of its own has images that the twin does not know
    std::vector<CameraImages> irradiance;
    for (const render::RenderedCamera& camera : rendered_) irradiance.push_back(render::as_radiance(camera));
    measure::state_method_bias(known, irradiance, measurement);
  }
  report::Json result = compare::measurement_tree(known, measurement, {}, {});
  result.update(image_results({*twin_, known, rendered_, images, measurement, theory_}, task_.records));
  return pick_numbers(result, task_.records);
}

}  // namespace fringetwin::study
