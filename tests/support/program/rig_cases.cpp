// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/rig_cases.hpp"

#include <map>

#include "tests/support/program/cli_runner.hpp"
#include "tests/support/program/independent_rig.hpp"

namespace fringetwin::testing {
namespace {

struct RigCase {
  bool wrong = true;
  CaptureOptions rig = {};
  TwinOptions twin = {};
};

const std::map<std::string, RigCase>& cases() {
  constexpr RigLight bent = RigLight::bent;
  static const std::map<std::string, RigCase> all{
      {"right", {.wrong = false}},
      {"right_bent",
       {.wrong = false, .rig = {.light = bent}, .twin = {.gamma = 1.2, .blur_px = 1.0, .samples = 64}}},
      {"right_bounce", {.wrong = false, .rig = {.second_bounce = true}, .twin = {.bounces = kAllBounces}}},
      {"gain_tilt", {.rig = {.gain_tilt = 0.05}}},
      {"gamma", {.rig = {.light = bent}, .twin = {.blur_px = 1.0}}},
      {"pose", {.twin = {.sphere_shift_mm = {0.03, 0.0, 0.04}}}},
      {"projector_k1", {.twin = {.projector_k1 = false}}},
      {"blur", {.rig = {.light = bent}, .twin = {.gamma = 1.2, .samples = 64}}},
      {"second_bounce", {.rig = {.second_bounce = true}}},
  };
  return all;
}

std::vector<std::string> names(bool wrong) {
  std::vector<std::string> out;
  for (const auto& [name, c] : cases())
    if (c.wrong == wrong) out.push_back(name);
  return out;
}

}  // namespace

const std::vector<std::string>& right_cases() {
  static const auto all = names(false);
  return all;
}

const std::vector<std::string>& wrong_cases() {
  static const auto all = names(true);
  return all;
}

std::filesystem::path write_case(const std::string& name, std::uint64_t seed) {
  const RigCase& c = cases().at(name);
  const std::filesystem::path folder = scratch_folder("rig-" + name);
  CaptureOptions rig = c.rig;
  rig.seed = seed;
  write_captures(folder / "real", rig);
  write_file(folder / "twin.toml", twin_toml("real", c.twin));
  return folder;
}

}  // namespace fringetwin::testing
