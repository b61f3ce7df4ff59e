// SPDX-License-Identifier: Apache-2.0
#include "twin/sequence_outline.hpp"

#include <fmt/format.h>

#include <span>

namespace fringetwin {
namespace {

/// Images that sequence_outline() names together: those of one pitch, the Gray code of a direction, pictures.
bool of_one_block(const PatternSpec& a, const PatternSpec& b) {
  return a.direction == b.direction && a.pitch == b.pitch && a.is_gray() == b.is_gray() &&
         a.is_image() == b.is_image();
}

std::string block_text(const Fringes& fringes, std::span<const PatternSpec> block) {
  const PatternSpec& first = block.front();
  if (first.is_image()) return "images";
  const DirectionFringes& direction = fringes.directions.at(first.direction);
  const char* axis = axis_name(direction.axis);
  if (!first.is_gray())
    return fmt::format("{} pitch {} in {} steps", axis, direction.pitches_px.at(first.pitch), fringes.steps);
  const GrayCode& gray = *direction.gray;
  return fmt::format("{} {} gray bits, {}{}{}", axis, gray.bits,
                     gray.lsb_first ? "least significant first" : "most significant first",
                     gray.complementary ? ", and the complementary bit" : "",
                     gray.threshold == GrayCode::Threshold::inverse ? ", each with its inverse" : "");
}

}  // namespace

std::string sequence_outline(const Fringes& fringes) {
  const std::vector<PatternSpec> sequence = expand_sequence(fringes);
  std::string text;
  for (std::size_t begin = 0, end = 0; begin < sequence.size(); begin = end) {
    while (end < sequence.size() && of_one_block(sequence[begin], sequence[end])) ++end;
    text += fmt::format("{}{}: {}", begin == 0 ? "" : "; ",
                        end - begin == 1 ? fmt::format("{}", begin) : fmt::format("{}-{}", begin, end - 1),
                        block_text(fringes, std::span(sequence).subspan(begin, end - begin)));
  }
  return text;
}

}  // namespace fringetwin
