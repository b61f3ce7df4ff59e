// SPDX-License-Identifier: Apache-2.0
// Holds the switches by which tests and benchmarks force the renderer onto ways that it takes by itself only
// on certain drivers or scenes. The images stay the same within the accuracy that was asked for.
#pragma once
#include <cstdint>

namespace fringetwin::render {

/// The way to the phase steps behind a response that is not linear: as harmonics that one trace carries, each
/// step evaluated directly in the trace, or whichever is cheaper.
enum class PatternMethod { automatic, direct, harmonics };

struct RendererTuning {
  /// The most samples per pixel in one dispatch; 0 leaves the choice to the renderer. lavapipe 22.3 cuts the
  /// loops of an invocation at 65,535 iterations; the renderer notices and repeats with fewer samples.
  std::uint32_t samples_per_dispatch = 0;
  /// The way in which phase steps behind a response that is not linear are made.
  PatternMethod pattern_method = PatternMethod::automatic;
  /// True: every ray finds its triangle through the BVH and every shadow ray is traced; no shortcut between
  /// neighbouring triangles is taken.
  bool search_always = false;
  /// The number of invocations that share a scan line from the start, as they do where the driver cuts loops
  /// short.
  std::uint32_t line_stretches = 1;
};

}  // namespace fringetwin::render
