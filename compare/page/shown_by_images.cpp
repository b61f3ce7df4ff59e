// SPDX-License-Identifier: Apache-2.0
#include "compare/page/shown_by_images.hpp"

#include <algorithm>

#include "compare/refine/asked_parameters.hpp"
#include "twin/base/errors.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::compare {
namespace {

/// Of the excess, that what pixels have of their own must take away.
constexpr double kMost = 0.5;

/// Returns the group that takes away most of the excess by itself; empty where none takes most of it.
std::string nearest_group(const Causes& causes) {
  const CauseRow* nearest = nullptr;
  for (const CauseRow& row : causes.rows)
    if (row.alone >= kMost && (!nearest || row.alone > nearest->alone)) nearest = &row;
  return nearest ? nearest->group : "";
}

/// Adds a name where a refinement takes it beside those it has.
class Names {
 public:
  Names(const Comparison& c, const Twin& twin)
      : twin_(twin), asked_(c.refinement ? c.refinement->asked : std::vector<std::string>{}) {}

  void add(const char* name, const char* words) {
    if (std::ranges::find(asked_, name) != asked_.end()) return;
    std::vector<std::string> more = asked_;
    more.emplace_back(name);
    try {
      check_refine(twin_, more);
    } catch (const UserError&) {
      return;
    }
    asked_ = std::move(more);
    shown_.names.emplace_back(name);
    shown_.words.emplace_back(words);
  }
  ShownByImages take() { return std::move(shown_); }

 private:
  const Twin& twin_;
  std::vector<std::string> asked_;
  ShownByImages shown_;
};

}  // namespace

ShownByImages shown_by_images(const Comparison& c, const Twin& twin) {
  const auto ripples = [&](double ExplainedRow::*chi2) {
    return std::ranges::any_of(c.explained,
                               [=](const ExplainedRow& row) { return row.*chi2 > row.ripple_limit; });
  };
  Names names(c, twin);
  if (ripples(&ExplainedRow::brightness_chi2)) names.add("light", "light that varies from image to image");
  if (ripples(&ExplainedRow::harmonic_chi2)) names.add("harmonics", "fringes of another waveform");
  const std::string nearest = nearest_group(c.causes);
  const bool both = nearest == "texture and offset";
  if (needs_white_black(twin.fringes)) return names.take();  // a pixel's own numbers would need these images
  if (both || nearest == "texture") names.add("texture", "a brightness of each pixel's own");
  if (both || nearest == "offset") names.add("offset", "light beside the projector's in each pixel");
  return names.take();
}

}  // namespace fringetwin::compare
