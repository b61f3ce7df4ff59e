// SPDX-License-Identifier: Apache-2.0
// Provides the renderer's kernels: their SPIR-V in all build variants, and the type of the constants by which
// they are specialised.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "render/shaders/shared.h"

namespace fringetwin::render {

/// The values of a kernel's specialisation constants, SPEC_... of shared.h.
using SpecConstants = std::array<std::uint32_t, SPEC_COUNT>;

enum class Kernel { trace, probe, closed_form, border, facets, lines, gather, mirror_ways };

/// Returns the SPIR-V of a kernel. `storage`: geometry in storage buffers instead of texel buffers;
/// `precise`: double precision.
std::span<const std::uint32_t> kernel_code(Kernel kernel, bool storage, bool precise);

}  // namespace fringetwin::render
