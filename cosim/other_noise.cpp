// SPDX-License-Identifier: Apache-2.0
#include "cosim/other_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace fringetwin::cosim {
namespace {

bool has_noise(const Twin& twin) {
  return std::ranges::any_of(twin.cameras, [](const Camera& camera) { return camera.sensor.has_noise(); });
}

std::string same_noise(std::uint64_t seed, const std::string& remedy) {
  return fmt::format(
      "the real images were rendered with seed {}, and so were the simulated ones: both have the "
      "same noise, and differ by less than the budget says; {}",
      seed, remedy);
}

}  // namespace

std::optional<std::uint64_t> seed_of_rendered(const std::map<std::string, std::string>& provenance) {
  const auto device = provenance.find("device"), seed = provenance.find("seed");
  if (device == provenance.end() || seed == provenance.end()) return {};
  if (!device->second.starts_with(kRenderedBy)) return {};
  std::uint64_t value = 0;
  const char* end = seed->second.data() + seed->second.size();
  const auto [read_to, error] = std::from_chars(seed->second.data(), end, value);
  if (error != std::errc() || read_to != end) return {};  // someone has written it by hand
  return value;
}

ChosenSeed choose_seed(const Twin& twin, std::optional<std::uint64_t> asked,
                       std::optional<std::uint64_t> of_real) {
  ChosenSeed chosen{.seed = asked.value_or(kDefaultSeed)};
  if (!has_noise(twin) || of_real != chosen.seed) return chosen;
  const std::uint64_t other = chosen.seed + 1;
  if (asked) {
    chosen.warning = same_noise(chosen.seed, fmt::format("--seed {} gives them another", other));
  } else {
    chosen.seed = other;
    chosen.note = fmt::format(
        "The real images were rendered with seed {}: the simulated ones have seed {}, so that "
        "their noise is another.",
        *of_real, other);
  }
  return chosen;
}

std::string same_noise_warning(const Twin& twin, std::optional<std::uint64_t> of_real,
                               std::optional<std::uint64_t> of_simulated) {
  if (!has_noise(twin) || !of_real || of_real != of_simulated) return "";
  return same_noise(*of_real, fmt::format("render one of them with --seed {}", *of_real + 1));
}

}  // namespace fringetwin::cosim
