// SPDX-License-Identifier: Apache-2.0
#include "compare/page/shown_by_images.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "compare/refine/asked_parameters.hpp"
#include "twin/base/errors.hpp"
#include "twin/fringes.hpp"

namespace fringetwin::compare {
namespace {

/// Of the excess, that what pixels have of their own must take away.
constexpr double kMost = 0.5;
constexpr std::string_view kBoth = "texture and offset";

/// Returns what was fitted and takes away most of the excess by itself; empty where nothing takes most of it.
/// A factor or an offset alone stands for both where it takes nearly as much.
std::string nearest_group(const Causes& causes) {
  constexpr double kAlike = 0.02;  // as the search for causes has it
  const CauseRow* nearest = nullptr;
  for (const CauseRow& row : causes.rows) {
    if (std::isnan(row.chi2_after) || !(row.alone >= kMost)) continue;
    const double more = nearest && nearest->group == kBoth ? -kAlike : row.group == kBoth ? kAlike : 0.0;
    if (!nearest || row.alone > nearest->alone + more) nearest = &row;
  }
  return nearest ? nearest->group : "";
}

/// Adds a name where a refinement takes it beside those it has.
class Names {
 public:
  Names(const Comparison& c, const Twin& twin)
      : twin_(twin), asked_(c.refinement ? c.refinement->asked : std::vector<std::string>{}) {}

  bool has(const char* name) const { return is_asked(asked_, name); }
  void add(const char* name, const char* words) {
    if (has(name)) return;
    std::vector<std::string> more = asked_;
    more.emplace_back(name);
    if (!fits_more(more, name)) return;
    asked_ = std::move(more);
    words_.emplace_back(words);
  }
  ShownByImages take() { return {std::move(words_), std::move(asked_)}; }

 private:
  /// Returns whether these words are no refused ones, and the last of them adds numbers to the others.
  bool fits_more(const std::vector<std::string>& asked, std::string_view last) const {
    try {
      const std::size_t n = chosen_parameters(twin_, asked).size();
      return last == "texture" || last == "offset" || n > chosen_parameters(twin_, asked_).size();
    } catch (const UserError&) {
      return false;
    }
  }

  const Twin& twin_;
  std::vector<std::string> asked_, words_;
};

}  // namespace

ShownByImages shown_by_images(const Comparison& c, const Twin& twin) {
  const auto ripples = [&](double ExplainedRow::*chi2) {
    return std::ranges::any_of(c.explained,
                               [=](const ExplainedRow& row) { return row.*chi2 > row.ripple_limit; });
  };
  Names names(c, twin);
  // an exposure of each image is the same, and nothing tells the light of images that are held out
  const bool holds_out_pitches = twin.compare.hold_out > 0 && twin.compare.hold_out_by == HeldOutBy::pitches;
  if (ripples(&ExplainedRow::brightness_chi2) && !names.has("exposure") && !holds_out_pitches)
    names.add("light", "light that varies from image to image");
  if (ripples(&ExplainedRow::harmonic_chi2)) names.add("harmonics", "fringes of another waveform");
  const std::string nearest = nearest_group(c.causes);
  const bool both = nearest == kBoth;
  if (needs_white_black(twin.fringes)) return names.take();  // a pixel's own numbers would need these images
  if (both || nearest == "texture") names.add("texture", "a brightness of each pixel's own");
  if (both || nearest == "offset") names.add("offset", "light beside the projector's in each pixel");
  return names.take();
}

}  // namespace fringetwin::compare
