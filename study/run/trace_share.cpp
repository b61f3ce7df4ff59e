// SPDX-License-Identifier: Apache-2.0
#include "study/run/trace_share.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "render/base/sampling.hpp"
#include "render/pattern/form_images.hpp"
#include "study/uncertain/uncertain_inputs.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::study {
namespace {

bool is_one_of(std::string_view key, std::initializer_list<std::string_view> keys) {
  return std::ranges::find(keys, key) != keys.end();
}

// What follows "camera.NAME." or "camera[0].", else nothing. A name with a point in it gives a remainder that
// is no key of a camera, or one of a table of another camera's: neither is taken for harmless below.
std::string_view key_of_camera(std::string_view path) {
  constexpr std::string_view kCamera = "camera";
  if (!path.starts_with(kCamera)) return {};
  path.remove_prefix(kCamera.size());
  const auto begin = path.find('.', path.starts_with('.') ? 1 : 0);
  return begin == std::string_view::npos ? std::string_view() : path.substr(begin + 1);
}

bool is_after_the_light(std::string_view path) {
  return path == "name" || path.starts_with("measure.") || path.starts_with("limits.") ||
         is_one_of(key_of_camera(path), {"sensor", "sensor.bit_depth", "sensor.exposure_ms", "sensor.gain_dn",
                                         "sensor.black_level_dn", "sensor.electrons_per_dn",
                                         "sensor.read_noise_dn", "sensor.prnu", "sensor.dsnu"});
}

// The key of a list, or of one number in it.
std::string_view without_index(std::string_view key) { return key.substr(0, key.find('[')); }

bool is_after_the_trace(std::string_view path) {
  const std::string_view key = without_index(key_of_camera(path));
  return is_one_of(key,
                   {"psf_px", "vignetting", "vignetting_tilt", "exposure_factors", "texture",
                    "texture_spread_px", "timing", "timing.exposure", "timing.read_out", "timing.late"}) ||
         is_one_of(without_index(path), {"projector.light_factors", "projector.ambient_factors"});
}

bool is_of_the_steps(std::string_view path) {
  return is_one_of(path, {"fringes.steps", "fringes.mean", "fringes.amplitude"});
}

std::string join(const std::string& head, const Settings& settings) {
  std::string text = head;
  for (const auto& [key, value] : settings) text += key + " = " + value + '\n';
  return text;
}

}  // namespace

TraceDemand TraceDemand::of(const Twin& twin) {
  TraceDemand d;
  for (const Camera& camera : twin.cameras)
    d.sensors.push_back({camera.sensor.bit_depth, camera.sensor.gain_dn});
  d.mean = twin.fringes.mean;
  d.amplitude = twin.fringes.amplitude;
  return d;
}

void TraceDemand::join(const TraceDemand& other) {
  FT_CHECK(sensors.size() == other.sensors.size(), "twins that share a trace have the same cameras");
  for (std::size_t c = 0; c < sensors.size(); ++c)
    if (other.sensors[c].irradiance() < sensors[c].irradiance()) sensors[c] = other.sensors[c];
  mean = std::max(mean, other.mean);
  amplitude = std::max(amplitude, other.amplitude);
}

void TraceDemand::apply(Twin* twin) const {
  FT_CHECK(sensors.size() == twin->cameras.size(), "a sensor per camera");
  for (std::size_t c = 0; c < sensors.size(); ++c) {
    twin->cameras[c].sensor.bit_depth = sensors[c].bit_depth;
    twin->cameras[c].sensor.gain_dn = sensors[c].gain_dn;
  }
  twin->fringes.mean = mean;
  twin->fringes.amplitude = amplitude;
}

ShareKeys share_keys(const Twin& twin, const StudyPoint& point) {
  Settings trace, form;
  const bool any_steps = render::holds_any_steps(twin);
  for (const auto& [path, value] : recording_settings(point.settings)) {
    if (is_after_the_light(path)) continue;
    form.emplace(path, value);
    if (is_after_the_trace(path) || (any_steps && is_of_the_steps(path))) continue;
    trace.emplace(path, value);
  }
  // Random samples are the seed's own, so that they average out over the seeds as well.
  const Sampler sampler = render::choose_sampling(twin).sampler;
  const bool random = sampler == Sampler::multi_jittered || sampler == Sampler::sobol;
  std::string head = random || twin.render.bounces > 0 ? "seed " + std::to_string(point.seed) + '\n' : "";
  // A table "sensor" as a whole is passed over above; what it says of the image's pixels is no sensor's
  // matter.
  for (const Camera& camera : twin.cameras)
    if (camera.channel) head += text_of(*camera.channel) + '\n';
  return {join(head, trace), join(head, form)};
}

std::vector<PlannedPoint> plan_traces(const std::filesystem::path& twin_file, const PointSequence& points) {
  std::map<std::string, std::size_t> group_of_key;
  std::vector<TraceDemand> demands;
  std::map<std::string, std::optional<Twin>> twins;  // seeds of one point follow each other: the last is kept
  std::vector<PlannedPoint> plan;
  plan.reserve(points.size());
  for (StudyPoint point : points) {
    throw_if_cancelled();
    const std::string settings = join("", point.settings);
    if (!twins.contains(settings)) {
      twins.clear();
      std::optional<Twin>& twin = twins[settings];
      try {
        twin = load_twin(twin_file, keys_of_twin(point.settings));
        render::choose_sampling(*twin);
      } catch (const UserError&) {
        twin.reset();
      }
    }
    const std::optional<Twin>& twin = twins[settings];
    PlannedPoint planned;
    planned.point = std::move(point);
    if (!twin) {
      planned.group = demands.size();
      demands.emplace_back();
    } else {
      planned.keys = share_keys(*twin, planned.point);
      const auto [at, is_new] = group_of_key.try_emplace(planned.keys.trace, demands.size());
      planned.group = at->second;
      if (is_new)
        demands.push_back(TraceDemand::of(*twin));
      else
        demands[planned.group].join(TraceDemand::of(*twin));
    }
    plan.push_back(std::move(planned));
  }
  for (PlannedPoint& planned : plan) planned.demand = demands[planned.group];
  return plan;
}

std::size_t count_groups(const std::vector<PlannedPoint>& points) {
  std::set<std::size_t> groups;
  for (const PlannedPoint& p : points) groups.insert(p.group);
  return groups.size();
}

}  // namespace fringetwin::study
