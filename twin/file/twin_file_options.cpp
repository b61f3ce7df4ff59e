// SPDX-License-Identifier: Apache-2.0
// [render], [measure], [compare], [real], [uncertainty] and [limits] of twin.toml.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "twin/base/nearest_word.hpp"
#include "twin/base/progress.hpp"
#include "twin/file/plain_keys.hpp"
#include "twin/file/twin_file.hpp"

namespace fringetwin {
namespace {

/// Returns the object a fit names; refuses one that does not exist.
std::string read_object_name(const TomlTable& table, const Twin& twin) {
  const std::string name = table.required_string("object");
  if (twin.find_object(name) != nullptr) return name;
  std::vector<std::string> names;
  for (const Object& object : twin.objects) names.push_back(object.name);
  table.fail("object", fmt::format("= \"{}\": there is no such [[object]]", name), did_you_mean(name, names));
}

/// Keys of a published fit: those of result.json's fits.
const std::vector<std::string> kPublishedNumbers = {"radius_mm", "radius_sigma_mm", "rms_mm", "n"};
const std::vector<std::string> kPublishedVectors = {"center_mm",      "center_sigma_mm", "point_mm",
                                                    "point_sigma_mm", "normal",          "normal_sigma",
                                                    "axis",           "axis_sigma"};

PublishedFit read_published_fit(const TomlTable& table, const Twin& twin) {
  std::vector<std::string> known = {"object"};
  known.insert(known.end(), kPublishedNumbers.begin(), kPublishedNumbers.end());
  known.insert(known.end(), kPublishedVectors.begin(), kPublishedVectors.end());
  table.allow(known);
  PublishedFit fit;
  fit.object = read_object_name(table, twin);
  for (const std::string& key : kPublishedNumbers) {
    const NumberRange range = key == "radius_mm" ? NumberRange::positive() : NumberRange::not_negative();
    if (const auto value = table.number(key, range)) fit.numbers[key] = *value;
  }
  for (const std::string& key : kPublishedVectors)
    if (table.has(key)) fit.vectors[key] = table.required_vector3(key);
  if (fit.numbers.empty() && fit.vectors.empty())
    table.fail("", "has no number", "e.g. radius_mm or center_mm");
  return fit;
}

}  // namespace

RenderOptions read_render(const TomlTable& root) {
  RenderOptions render;
  const auto table = root.table("render");
  if (!table) return render;
  table->allow(names_of_keys<RenderOptions>());
  read_plain_keys(*table, render);
  if (table->is_string("bounces")) {
    table->required_choice("bounces", {"all"});
    render.bounces = kAllBounces;
  } else {
    render.bounces = table->integer("bounces", 0, kMostBounces).value_or(0);
  }
  for (const char* key : {"bounce_samples", "glossy_bounces"})
    if (table->has(key) && !table->has("bounces"))
      table->fail(key, "has no effect without bounces", "add bounces = \"all\"");
  // A study may vary bounces from 0 on, and `--refine bounce` may take them away: no error.
  if (render.bounces == 0 && render.glossy_bounces)
    warn(table->where("glossy_bounces") + ": [render] glossy_bounces has no effect with bounces = 0");
  if (const auto sampler = table->choice("sampler", {"adaptive", "gauss", "multi-jittered", "sobol"}))
    render.sampler = *sampler == "adaptive"         ? Sampler::adaptive
                     : *sampler == "gauss"          ? Sampler::gauss
                     : *sampler == "multi-jittered" ? Sampler::multi_jittered
                                                    : Sampler::sobol;
  if (render.sampler == Sampler::adaptive && render.samples)
    table->fail("samples", "has no meaning with sampler = \"adaptive\"", "leave one of them out");
  return render;
}

/// Returns the least amplitude of a fringe that counts as one: where a sensor states its noise, 6 standard
/// deviations of an amplitude that is measured in N steps, sigma sqrt(2/N), where the fringe is darkest that
/// can have it (its mean is its amplitude above black). 5 DN where that is less or nothing is stated; no more
/// than 2 % of full scale, so that noise which is stated far too large does not hide what would refute it.
double default_min_modulation_dn(const Twin& twin) {
  constexpr double kSigmas = 6.0, kRounding = 1.0 / 12.0, kMostOfFullScale = 0.02;
  constexpr int kFewestSteps = 3;  // Gray code alone has none
  const double of_variance = kSigmas * kSigmas * 2.0 / std::max(twin.fringes.steps, kFewestSteps);
  const double fewest_dn = MeasureOptions{}.min_modulation_dn;
  double asked_dn = 0.0,
         full_scale_dn = std::numeric_limits<double>::infinity();  // one number for all cameras
  for (const Camera& camera : twin.cameras) {
    full_scale_dn = std::min(full_scale_dn, camera.sensor.max_dn());
    if (!camera.sensor.has_noise()) continue;
    const double per_dn = camera.sensor.electrons_per_dn ? 1.0 / *camera.sensor.electrons_per_dn : 0.0;
    // a^2 = of_variance (read^2 + rounding + a per_dn)
    const double constant =
                     of_variance * (std::pow(camera.sensor.read_noise_dn.value_or(0.0), 2) + kRounding),
                 half = 0.5 * of_variance * per_dn;
    asked_dn = std::max(asked_dn, half + std::sqrt(half * half + constant));
  }
  return std::clamp(asked_dn, fewest_dn, std::max(fewest_dn, kMostOfFullScale * full_scale_dn));
}

MeasureOptions read_measure(const TomlTable& root, const Twin& twin) {
  MeasureOptions measure;
  measure.min_modulation_dn = default_min_modulation_dn(twin);
  const auto table = root.table("measure");
  if (!table) return measure;
  table->allow({"triangulate", "min_modulation_dn", "smoothing_px", "light", "correct_pixel_area", "fit"});
  if (const auto name = table->choice("triangulate", {"stereo", "projector"})) {
    measure.triangulate = *name == "stereo" ? Triangulate::stereo : Triangulate::projector;
    if (*name == "stereo" && twin.cameras.size() < 2)
      table->fail("triangulate", "= \"stereo\" needs two cameras, the twin has one", "use \"projector\"");
    if (*name == "projector" && !twin.projector)
      table->fail("triangulate", "= \"projector\" needs a [projector]", "add one or use \"stereo\"");
  }
  measure.min_modulation_dn =
      table->number_or("min_modulation_dn", measure.min_modulation_dn, NumberRange::not_negative());
  measure.smoothing_px =
      table->number_or("smoothing_px", measure.smoothing_px, NumberRange::between(0.0, 50.0));
  measure.correct_light = table->choice("light", {"as_is", "corrected"}) == "corrected";
  measure.correct_pixel_area = table->boolean("correct_pixel_area").value_or(false);
  std::set<std::string> names;
  for (const TomlTable& fit : table->tables("fit")) {
    fit.allow({"object", "gate_mm"});
    FitRequest request{.object = read_object_name(fit, twin)};
    request.gate_mm = fit.number_or("gate_mm", request.gate_mm, NumberRange::positive());
    if (!names.insert(request.object).second)
      fit.fail("object",
               fmt::format("= \"{}\" is fitted by an earlier [[measure.fit]], too", request.object));
    measure.fits.push_back(request);
  }
  return measure;
}

ComparisonOptions read_comparison(const TomlTable& root) {
  ComparisonOptions compare;
  const auto table = root.table("compare");
  if (!table) return compare;
  table->allow({"hold_out", "hold_out_by"});
  compare.hold_out = table->integer("hold_out", 2, 64).value_or(0);
  if (table->choice("hold_out_by", {"steps", "pitches"}) == "pitches")
    compare.hold_out_by = HeldOutBy::pitches;
  return compare;
}

RealSource read_real(const TomlTable& root, const Twin& twin, const TwinFileContext& context) {
  RealSource real;
  const auto table = root.table("real");
  if (!table) return real;
  table->allow({"captures", "results"});
  if (table->has("captures") == table->has("results"))
    table->fail("", "must have either captures or [real.results]");
  if (table->has("captures")) {
    real.captures = context.resolve(*table, "captures");
    return real;
  }
  const TomlTable results = *table->table("results");
  results.allow({"source", "fit"});
  real.results_source = results.string("source").value_or("");
  std::set<std::string> names;
  for (const TomlTable& fit : results.tables("fit")) {
    real.results.push_back(read_published_fit(fit, twin));
    if (!names.insert(real.results.back().object).second)
      fit.fail("object", fmt::format("= \"{}\" has earlier results, too", real.results.back().object));
  }
  if (real.results.empty())
    results.fail("fit", "is missing", "write [[real.results.fit]] with the published numbers");
  return real;
}

std::optional<std::filesystem::path> read_uncertainty(const TomlTable& root, const TwinFileContext& context) {
  const auto table = root.table("uncertainty");
  if (!table) return std::nullopt;
  table->allow({"calibration"});
  std::filesystem::path file = context.resolve(*table, "calibration");
  if (!std::filesystem::is_regular_file(file))
    throw UserError(
        ExitCode::input, table->where("calibration"),
        fmt::format("{} = \"{}\": there is no such file", table->full_key("calibration"), file.string()),
        "give the calibration.json that `fringetwin calibrate` wrote");
  if (context.files) context.files->push_back(file);
  return file;
}

/// Reads limits of any name; load_checked_twin() in compare/verdict/limits.hpp refuses what no comparison
/// has.
std::map<std::string, double> read_limits(const TomlTable& root) {
  std::map<std::string, double> limits;
  const auto table = root.table("limits");
  if (!table) return limits;
  for (const std::string& name : table->keys())
    limits[name] = *table->number(name, NumberRange::not_negative());
  return limits;
}

}  // namespace fringetwin
