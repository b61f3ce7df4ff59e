// SPDX-License-Identifier: Apache-2.0
// Sees to it that simulated images do not get the very noise that "real" ones have which were rendered, too:
// the same seed draws the same noise, and a difference without noise tells nothing of a budget that counts
// it.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "twin/twin.hpp"

namespace fringetwin::cosim {

/// The seed of noise and random samplers where none is asked for.
inline constexpr std::uint64_t kDefaultSeed = 0;

/// How the capture.toml of rendered images begins to say who made them.
inline constexpr const char* kRenderedBy = "fringetwin renderer on ";

/// Returns the seed of the images' noise by the provenance of their capture.toml; none where this program did
/// not render them, or does not say with which seed.
std::optional<std::uint64_t> seed_of_rendered(const std::map<std::string, std::string>& provenance);

/// The seed of a run.
struct ChosenSeed {
  std::uint64_t seed = 0;
  std::string note = {};     ///< that it is another one than the default, and why; empty: it is not
  std::string warning = {};  ///< that both sides have the same noise; empty: they have not
};

/// Returns the seed that was asked for, else the default, 0; else 1 where the real images have the noise of
/// that. Without noise in the twin's sensors it is never replaced.
ChosenSeed choose_seed(const Twin& twin, std::optional<std::uint64_t> asked,
                       std::optional<std::uint64_t> of_real);

/// Returns the warning for two rendered sets of images, their seeds told; empty where their noise differs.
std::string same_noise_warning(const Twin& twin, std::optional<std::uint64_t> of_real,
                               std::optional<std::uint64_t> of_simulated);

}  // namespace fringetwin::cosim
