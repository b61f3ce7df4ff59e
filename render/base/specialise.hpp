// SPDX-License-Identifier: Apache-2.0
// Takes out of a SPIR-V module the code that a scene does not need.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace fringetwin::render {

/// Returns the module with its specialisation constants (constant_id 0, 1, ...) fixed at `constants`, and
/// without the code that they switch off. Drivers do that as well, but lavapipe only after all of the code
/// has been through its front end: 2.5 of the 2.8 s CPU that a small scene took. By SPIRV-Tools' optimiser;
/// kept in `folder`. Empty if the optimiser fails: the driver then has to specialise.
std::vector<std::uint32_t> specialised(std::span<const std::uint32_t> spirv,
                                       std::span<const std::uint32_t> constants,
                                       const std::optional<std::filesystem::path>& folder);

}  // namespace fringetwin::render
