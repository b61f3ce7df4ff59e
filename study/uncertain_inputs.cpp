// SPDX-License-Identifier: Apache-2.0
#include "study/uncertain_inputs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>

#include "twin/errors.hpp"

namespace fringetwin::study {
namespace {

constexpr const char* kDeviates = "uncertainty.calibration.deviates";

/// Dimensions of the random numbers. A key more, or a calibration, leaves the other inputs' draws as they
/// are.
constexpr std::uint32_t kNoiseDimension = 0, kFirstKey = 1, kFirstDirection = 1u << 16;

/// The numbers of "[0.1, -2]", as point_of writes them.
Eigen::VectorXd read_list(const std::string& text, Eigen::Index n) {
  Eigen::VectorXd out(n);
  const char *at = text.data() + 1, *end = text.data() + text.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [next, error] = std::from_chars(at, end, out[i]);
    FT_CHECK(error == std::errc{} && next < end && *next == (i + 1 < n ? ',' : ']'),
             "the calibration's deviates: " + text);
    at = next + 2;
  }
  return out;
}

}  // namespace

std::vector<std::string> UncertainInputs::factors() const {
  std::vector<std::string> out;
  for (const UncertainKey& key : keys) out.push_back(key.name);
  if (calibration > 0) out.emplace_back("calibration");
  if (noise) out.emplace_back("noise");
  return out;
}

InputDraw draw_inputs(const UncertainInputs& inputs, std::uint64_t seed, DrawStream stream,
                      std::uint64_t trial) {
  const auto unit = [&](std::uint32_t dimension) { return unit_draw(seed, stream, trial, dimension); };
  InputDraw out;
  for (std::size_t k = 0; k < inputs.keys.size(); ++k) {
    const double u = unit(kFirstKey + static_cast<std::uint32_t>(k));
    out.deviates.push_back(inputs.keys[k].distribution == Distribution::normal ? normal_quantile(u)
                                                                               : 2.0 * u - 1.0);
  }
  for (std::size_t i = 0; i < inputs.calibration; ++i)
    out.calibration.push_back(normal_quantile(unit(kFirstDirection + static_cast<std::uint32_t>(i))));
  if (inputs.noise) out.noise_seed = random_bits(seed, stream, trial, kNoiseDimension) >> 11;
  return out;
}

InputDraw exchanged(const UncertainInputs& inputs, InputDraw a, const InputDraw& b, std::size_t factor) {
  const std::size_t keys = inputs.keys.size();
  if (factor < keys)
    a.deviates[factor] = b.deviates[factor];
  else if (factor == keys && inputs.calibration > 0)
    a.calibration = b.calibration;
  else
    a.noise_seed = b.noise_seed;
  return a;
}

StudyPoint point_of(const UncertainInputs& inputs, std::int64_t id, const InputDraw& draw) {
  StudyPoint out;
  out.id = id;
  out.seed = draw.noise_seed;
  for (std::size_t k = 0; k < inputs.keys.size(); ++k) {
    const UncertainKey& key = inputs.keys[k];
    for (std::size_t i = 0; i < key.keys.size(); ++i)
      out.settings[key.keys[i]] = fmt::format("{}", key.values[i] + key.spread * draw.deviates[k]);
  }
  if (!draw.calibration.empty())
    out.settings[kDeviates] = fmt::format("[{}]", fmt::join(draw.calibration, ", "));
  return out;
}

Settings keys_of_twin(Settings settings) {
  settings.erase(kDeviates);
  return settings;
}

VirtualRig::VirtualRig(const std::filesystem::path& twin_file, bool with_calibration)
    : file_(twin_file), nominal_(load_twin(twin_file)) {
  if (!with_calibration) return;
  if (!nominal_.calibration_uncertainty)
    throw UserError(ExitCode::usage, twin_file.string(), "the twin names no calibration to draw the rig from",
                    "give [uncertainty] calibration = \"calibration.json\"");
  covariance_ = compare::read_calibration_covariance(nominal_);
  changes_ = compare::one_sigma_changes(*covariance_);
}

Twin VirtualRig::drawn(const Settings& settings) const {
  Settings keys = settings;
  const auto deviates = keys.extract(kDeviates);
  const Twin twin = load_twin(file_, keys);
  if (deviates.empty()) return twin;
  FT_CHECK(covariance_, "a rig with a calibration");
  return compare::with_rig_change(twin, *covariance_,
                                  changes_ * read_list(deviates.mapped(), changes_.cols()));
}

}  // namespace fringetwin::study
