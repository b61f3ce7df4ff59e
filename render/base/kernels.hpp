// SPDX-License-Identifier: Apache-2.0
// SPIR-V of the renderer's kernels in their build variants.
#pragma once
#include <cstdint>
#include <span>

namespace fringetwin::render {

enum class Kernel { trace, probe, closed_form, border, facets, lines };

/// `storage`: geometry in storage buffers instead of texel buffers; `precise`: double precision.
std::span<const std::uint32_t> kernel_code(Kernel kernel, bool storage, bool precise);

}  // namespace fringetwin::render
