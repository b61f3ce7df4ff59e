// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/decode_input.hpp"

#include <algorithm>

#include "fmt/format.h"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {

void check_decode_input(const CameraImages& images, const Fringes& fringes) {
  const std::string where = "camera " + images.camera;
  const std::size_t expected = expand_sequence(fringes).size();
  if (images.images.size() != expected || expected == 0)
    throw UserError(ExitCode::input, where,
                    fmt::format("{} images, the fringe sequence has {}", images.images.size(), expected),
                    "make [fringes] describe what was projected");
  const auto check_size = [&](const GrayImage& image, const std::string& name) {
    if (!image.same_size(images.images.front()) || image.empty())
      throw UserError(ExitCode::input, where,
                      fmt::format("image {} is {} x {} px, image 0 is {} x {}", name, image.width,
                                  image.height, images.images.front().width, images.images.front().height));
  };
  for (std::size_t i = 0; i < images.images.size(); ++i) check_size(images.images[i], std::to_string(i));
  if (images.white) check_size(*images.white, "white");
  if (images.black) check_size(*images.black, "black");
  if (needs_white_black(fringes) && (!images.white || !images.black))
    throw UserError(ExitCode::input, where, "threshold = \"white-black\" needs a white and a black image",
                    "name them in capture.toml");
  if (fringes.steps == 0 && fringes.unwrap != Unwrap::gray)
    throw UserError(ExitCode::usage, "[fringes]", "steps = 0 leaves the Gray code only",
                    "set unwrap = \"gray\", or give at least 3 steps");
  for (const DirectionFringes& d : fringes.directions)
    FT_CHECK(d.phase_origin_px.size() == d.pitches_px.size(), "one phase origin per pitch");
}

DirectionImages collect_direction(const CameraImages& images, const Fringes& fringes, int direction,
                                  const std::vector<int>& used_steps) {
  const DirectionFringes& d = fringes.directions[direction];
  DirectionImages out;
  if (fringes.steps > 0)
    out.steps.assign(d.pitches_px.size(), std::vector<const GrayImage*>(used_steps.size(), nullptr));
  if (d.gray) {
    out.bits.assign(d.gray->bits, nullptr);
    if (d.gray->threshold == GrayCode::Threshold::inverse) out.inverse = out.bits;
  }
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const PatternSpec& s = sequence[i];
    if (s.direction != direction) continue;
    const GrayImage* image = &images.images[i];
    switch (s.kind) {
      case PatternSpec::Kind::phase_step: {
        const auto used = std::ranges::find(used_steps, s.step);
        if (used != used_steps.end()) out.steps[s.pitch][used - used_steps.begin()] = image;
        break;
      }
      case PatternSpec::Kind::gray_bit:
        out.bits[s.bit] = image;
        break;
      case PatternSpec::Kind::gray_bit_inverse:
        out.inverse[s.bit] = image;
        break;
      case PatternSpec::Kind::complementary:
        out.complementary = image;
        break;
      case PatternSpec::Kind::complementary_inverse:
        out.complementary_inverse = image;
        break;
      case PatternSpec::Kind::image:
        break;
    }
  }
  return out;
}

}  // namespace fringetwin::measure
