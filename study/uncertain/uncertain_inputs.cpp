// SPDX-License-Identifier: Apache-2.0
#include "study/uncertain/uncertain_inputs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "compare/verdict/limits.hpp"
#include "twin/base/errors.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::study {
namespace {

constexpr const char* kDeviates = "uncertainty.calibration.deviates";
// The names of settings that no key of a twin has: kForm stands before an object's name, kNominal before a
// key.
constexpr std::string_view kForm = "uncertainty.form.", kNominal = "nominal.";

/// Dimensions of the random numbers. A key more, or a calibration, leaves the other inputs' draws as they
/// are.
constexpr std::uint32_t kNoiseDimension = 0, kFirstKey = 1, kFirstDirection = 1u << 16, kFirstForm = 1u << 17,
                        kFirstRepetition = 1u << 18;

std::uint64_t seed_of_53_bits(std::uint64_t bits) { return bits >> 11; }

/// Returns the numbers of "[0.1, -2]", as point_of writes them.
Eigen::VectorXd read_list(const std::string& text, Eigen::Index n) {
  Eigen::VectorXd out(n);
  const char *at = text.data() + 1, *end = text.data() + text.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto [next, error] = std::from_chars(at, end, out[i]);
    FT_CHECK(error == std::errc{} && next < end && *next == (i + 1 < n ? ',' : ']'),
             "numbers of a draw: " + text);
    at = next + 2;
  }
  return out;
}

Settings nominal_settings(const Settings& settings) {
  Settings out;
  for (const auto& [key, text] : settings)
    if (key.starts_with(kNominal)) out[key.substr(kNominal.size())] = text;
  return out;
}

bool is_of_the_draw(const std::string& key) { return key == kDeviates || key.starts_with(kForm); }

/// Gives the object's sphere a form as point_of writes it: [seed, rms_mm, low, high].
void deform(Twin* twin, const std::string& name, const std::string& text) {
  const auto object = std::ranges::find(twin->objects, name, &Object::name);
  const auto* sphere = object == twin->objects.end() ? nullptr : std::get_if<SphereShape>(&object->shape);
  FT_CHECK(sphere != nullptr, "a form of a sphere");
  const Eigen::VectorXd n = read_list(text, 4);
  const FormSpread spread{n[1], static_cast<int>(n[2]), static_cast<int>(n[3])};
  MeshShape shape{.smooth = true};
  shape.T_world_object.translation_mm = sphere->center_mm;
  shape.mesh =
      form_mesh(sphere->radius_mm, spread, SphereForm::draw(spread, static_cast<std::uint64_t>(n[0])));
  object->shape = std::move(shape);
}

}  // namespace

std::vector<std::string> UncertainInputs::factors() const {
  std::vector<std::string> out;
  for (const UncertainKey& key : keys) out.push_back(key.name);
  for (const UncertainForm& form : forms) out.push_back(form.name);
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
  const auto seed_at = [&](std::uint32_t dimension) {
    return seed_of_53_bits(random_bits(seed, stream, trial, dimension));
  };
  for (std::size_t i = 0; i < inputs.forms.size(); ++i)
    out.forms.push_back(seed_at(kFirstForm + static_cast<std::uint32_t>(i)));
  for (std::size_t i = 0; i < inputs.calibration; ++i)
    out.calibration.push_back(normal_quantile(unit(kFirstDirection + static_cast<std::uint32_t>(i))));
  if (inputs.noise) out.noise_seed = seed_at(kNoiseDimension);
  return out;
}

InputDraw exchanged(const UncertainInputs& inputs, InputDraw a, const InputDraw& b, std::size_t factor) {
  const std::size_t keys = inputs.keys.size(), forms = inputs.forms.size();
  if (factor < keys)
    a.deviates[factor] = b.deviates[factor];
  else if (factor < keys + forms)
    a.forms[factor - keys] = b.forms[factor - keys];
  else if (factor == keys + forms && inputs.calibration > 0)
    a.calibration = b.calibration;
  else
    a.noise_seed = b.noise_seed;
  return a;
}

std::uint64_t repeated_noise(const UncertainInputs& inputs, std::uint64_t seed, std::uint64_t trial,
                             std::uint32_t repetition) {
  const std::uint32_t dimension = repetition == 0 ? kNoiseDimension : kFirstRepetition + repetition;
  return inputs.noise ? seed_of_53_bits(random_bits(seed, DrawStream::trials, trial, dimension)) : 0;
}

UncertainInputs about(UncertainInputs inputs, const std::filesystem::path& twin, const Settings& nominal) {
  if (std::ranges::all_of(inputs.keys, &UncertainKey::stated)) return inputs;
  const TomlTable file = TomlTable::parse_file(twin, ExitCode::usage, nominal);
  for (UncertainKey& key : inputs.keys) {
    if (key.stated) continue;
    for (std::size_t i = 0; i < key.keys.size(); ++i)
      key.values[i] = file.number_at(key.keys[i]).value_or(key.values[i]);
  }
  return inputs;
}

StudyPoint point_of(const UncertainInputs& inputs, std::int64_t id, const InputDraw& draw,
                    const Settings& nominal) {
  StudyPoint out;
  for (const auto& [key, text] : nominal) out.settings[std::string(kNominal) + key] = text;
  out.id = id;
  out.seed = draw.noise_seed;
  for (std::size_t k = 0; k < inputs.keys.size(); ++k) {
    const UncertainKey& key = inputs.keys[k];
    for (std::size_t i = 0; i < key.keys.size(); ++i)
      out.settings[key.keys[i]] = fmt::format("{}", key.values[i] + key.spread * draw.deviates[k]);
  }
  for (std::size_t i = 0; i < inputs.forms.size(); ++i) {
    const FormSpread& spread = inputs.forms[i].spread;
    out.settings[std::string(kForm) + inputs.forms[i].object] =
        fmt::format("[{}, {}, {}, {}]", draw.forms[i], spread.rms_mm, spread.low, spread.high);
  }
  if (!draw.calibration.empty())
    out.settings[kDeviates] = fmt::format("[{}]", fmt::join(draw.calibration, ", "));
  return out;
}

Settings recording_settings(const Settings& settings) {
  Settings out;
  for (const auto& [key, text] : settings)
    if (!key.starts_with(kNominal)) out[key] = text;
  out.merge(nominal_settings(settings));
  return out;
}

Settings keys_of_twin(const Settings& settings) {
  Settings out = recording_settings(settings);
  std::erase_if(out, [](const auto& setting) { return is_of_the_draw(setting.first); });
  return out;
}

bool has_drawn_form(const Settings& settings, const std::string& object) {
  return settings.contains(std::string(kForm) + object);
}

VirtualRig::VirtualRig(const std::filesystem::path& twin_file, bool with_calibration)
    : file_(twin_file), nominal_(load_twin(twin_file)) {
  if (!with_calibration) return;
  if (!nominal_.calibration_uncertainty)
    throw UserError(ExitCode::usage, twin_file.string(), "the twin names no calibration to draw the rig from",
                    "give [uncertainty] calibration = \"calibration.json\"");
  covariance_ = compare::read_calibration_covariance(nominal_);
  changes_ = compare::one_sigma_changes(covariance_->matrix);
}

const Twin& VirtualRig::measuring(const Settings& settings) {
  Settings keys = nominal_settings(settings);
  if (!measuring_ || keys != measuring_settings_) {
    Twin twin = keys.empty() ? nominal_ : load_twin(file_, keys);
    load_meshes(twin, measuring_ ? &*measuring_ : nullptr);
    measuring_ = std::move(twin);
    measuring_settings_ = std::move(keys);
  }
  return *measuring_;
}

Twin VirtualRig::drawn(const Settings& settings) const {
  Twin twin = compare::load_checked_twin(file_, keys_of_twin(settings));
  for (const auto& [key, text] : settings) {
    if (key == kDeviates) {
      FT_CHECK(covariance_, "a rig with a calibration");
      twin = compare::with_rig_change(twin, *covariance_, changes_ * read_list(text, changes_.cols()));
    } else if (key.starts_with(kForm)) {
      deform(&twin, key.substr(kForm.size()), text);
    }
  }
  return twin;
}

}  // namespace fringetwin::study
