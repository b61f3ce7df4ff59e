// SPDX-License-Identifier: Apache-2.0
// Says what a refinement can take up where no cause that was tested mends the twin: what ripples of the phase
// and pixels one by one show of the images.
#pragma once
#include <string>
#include <vector>

#include "compare/result/rows.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

struct ShownByImages {
  std::vector<std::string> words;   ///< for each of them what it is; empty: the images show nothing
  std::vector<std::string> refine;  ///< all of them as `cosim --refine` takes them, after this run's own
};

/// Returns what the images show: ripples beyond noise (light of single images, waveform), and a brightness or
/// an offset per pixel that takes away most of what is left. None that the twin's parameters cannot hold, or
/// that this run's refinement excludes.
ShownByImages shown_by_images(const Comparison& comparison, const Twin& twin);

}  // namespace fringetwin::compare
