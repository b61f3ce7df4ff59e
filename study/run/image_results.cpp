// SPDX-License-Identifier: Apache-2.0
#include "study/run/image_results.hpp"

#include <algorithm>
#include <cmath>

#include "compare/geometry/fit_rows.hpp"
#include "compare/verdict/indicators.hpp"
#include "report/json.hpp"
#include "study/noise/noise_theory.hpp"
#include "study/noise/theory_scope.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_number;

/// Returns how many images a camera records: those of the sequence and, where it needs them, white and black.
std::size_t count_images(const CameraImages& images) {
  return images.images.size() + (images.white ? 1 : 0) + (images.black ? 1 : 0);
}

/// Returns number and time of the images: one is recorded after the other, by all cameras at the same time.
Json acquisition(const VirtualMeasurement& run) {
  std::size_t n = 0;
  for (const CameraImages& images : run.images) n = std::max(n, count_images(images));
  double longest_ms = kNaN;
  for (const Camera& camera : run.recording.cameras)
    if (camera.sensor.exposure_ms) longest_ms = std::fmax(longest_ms, *camera.sensor.exposure_ms);
  return {{"images", n}, {"time_s", json_number(1e-3 * static_cast<double>(n) * longest_ms)}};
}

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? kNaN : static_cast<double>(part) / static_cast<double>(whole);
}

/// Returns the share, of the pixels that see an object, that are at full scale in any image.
double saturated(const Image<std::int32_t>& object, const CameraImages& images) {
  const auto limit = static_cast<float>(images.saturation_dn());
  std::vector<unsigned char> full(object.size());
  const auto add = [&](const GrayImage& image) {
    FT_CHECK(image.size() == full.size(), "images of one camera");
    for (std::size_t i = 0; i < full.size(); ++i)
      full[i] |= static_cast<unsigned char>(image[i] >= limit ? 1 : 0);
  };
  for (const GrayImage& image : images.images) add(image);
  if (images.white) add(*images.white);
  std::size_t seen = 0, n = 0;
  for (std::size_t i = 0; i < full.size(); ++i) {
    const bool sees = object.data[i] >= 0;
    seen += sees ? 1 : 0;
    n += sees && full[i] != 0 ? 1 : 0;
  }
  return share(n, seen);
}

/// Returns the share, of the first camera's pixels that see an object, that have a measured point.
double measured(const Image<std::int32_t>& object, const measure::PointCloud& cloud) {
  std::size_t n = 0;
  for (const Eigen::Vector2f& q : cloud.q_cam_px) {
    const int x = static_cast<int>(std::lround(q.x())), y = static_cast<int>(std::lround(q.y()));
    n += x >= 0 && y >= 0 && x < object.width && y < object.height && object(x, y) >= 0 ? 1 : 0;
  }
  const auto seen = std::ranges::count_if(object.data, [](int k) { return k >= 0; });
  return share(n, static_cast<std::size_t>(seen));
}

Json images(const VirtualMeasurement& run) {
  Json out = Json::array();
  for (std::size_t i = 0; i < run.images.size(); ++i) {
    const Image<std::int32_t>& object = run.rendered[i].object;
    out.push_back(
        {{"camera", run.images[i].camera}, {"saturated", json_number(saturated(object, run.images[i]))}});
    if (i == 0) out[0]["measured"] = json_number(measured(object, run.measurement.cloud));
  }
  return out;
}

/// Returns the indicators of each fitted object alone; those of a fit that is not usable are null.
Json indicators(const VirtualMeasurement& run) {
  Json out = Json::array();
  for (const measure::ObjectFit& fit : run.measurement.fits) {
    Json row = {{"object", fit.object}};
    for (const std::string& name : compare::indicator_names(fit.kind)) row[name] = nullptr;
    for (const compare::Indicator& i :
         compare::indicators(run.measuring, {compare::make_fit_row(fit, std::nullopt)}))
      row[i.name] = json_number(i.simulated.mm);
    out.push_back(std::move(row));
  }
  return out;
}

/// Returns what theory expects of an object; nothing but NaN where it does not know the twin.
NoiseTheory theory_of(const Twin& twin, const std::string& object) {
  if (!outside_noise_theory(twin, object).empty()) return {.n = kNaN};
  return noise_theory(twin, object);
}

/// Returns what theory expects of the fitted objects that a record names.
Json theory(const VirtualMeasurement& run, const std::vector<Record>& records) {
  Json out = Json::array();
  for (const measure::ObjectFit& fit : run.measurement.fits) {
    const std::string path = "theory." + fit.object + ".";
    if (std::ranges::none_of(records, [&](const Record& r) { return r.result.starts_with(path); })) continue;
    if (!run.theory.contains(fit.object)) run.theory[fit.object] = theory_of(run.recording, fit.object);
    const NoiseTheory& t = run.theory[fit.object];
    out.push_back({{"object", fit.object},
                   {"n", json_number(t.n)},
                   {"rms_mm", json_number(t.rms_mm)},
                   {"center_sigma_mm", report::json_numbers(t.center_sigma_mm)},
                   {"radius_sigma_mm", json_number(t.radius_sigma_mm)},
                   {"offset_sigma_mm", json_number(t.offset_sigma_mm)}});
  }
  return out;
}

}  // namespace

Json image_results(const VirtualMeasurement& run, const std::vector<Record>& records) {
  const auto asked = [&](const char* part) {
    return std::ranges::any_of(records, [&](const Record& r) { return r.result.starts_with(part); });
  };
  Json out = Json::object();
  if (asked("acquisition")) out["acquisition"] = acquisition(run);
  if (asked("images")) out["images"] = images(run);
  if (asked("indicators")) out["indicators"] = indicators(run);
  if (asked("theory")) out["theory"] = theory(run, records);
  return out;
}

}  // namespace fringetwin::study
