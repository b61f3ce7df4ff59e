// SPDX-License-Identifier: Apache-2.0
// Measures how many iterations of a loop a driver really executes: lavapipe 22.3 cuts the loops of an
// invocation at 65,535 iterations without a word. Includes volk.
#pragma once
#include <cstdint>

#include "render/vulkan/vulkan_device.hpp"

namespace fringetwin::testing {

/// Returns how many iterations of a loop of `requested` iterations one shader invocation executes.
std::uint32_t count_loop_iterations(render::VulkanDevice& device, std::uint32_t requested);

}  // namespace fringetwin::testing
