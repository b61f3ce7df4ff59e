// SPDX-License-Identifier: Apache-2.0
// Draws standard normal deviates by counter: pixel, image, camera and seed give the same one in every thread.
// Each is the Box-Muller transform of words of Philox4x32-10, with a radius of 53 bits.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "render/base/philox.hpp"

namespace fringetwin::render {

/// Names the deviates of one image.
struct DeviateSource {
  PhiloxKey key;  ///< of the seed
  std::uint32_t image = 0, camera = 0;
};

inline constexpr std::size_t kMostDeviates = 512;

/// The words of which one deviate is made: Philox's first three of a pixel.
struct DeviateWords {
  std::uint32_t high = 0, low = 0, turn = 0;
};
/// Returns sqrt(-2 ln u) cos(2 pi turn / 2^32) with the library's log and cos; u: 53 bits of high and low, in
/// (0, 1).
double exact_box_muller(const DeviateWords& words);
/// Returns the deviate of one pixel by exact_box_muller().
double exact_deviate(const DeviateSource& source, std::uint64_t pixel);

/// The near deviates lie closer to the exact ones than this: the next terms of their series of the logarithm,
/// 7e-10 (9e-10 of the radius), and of the sine, (pi/2)^15/15! = 6.7e-10, the latter times the largest
/// radius, 8.7.
inline constexpr double kDeviateError = 1e-8;

/// The words of kMostDeviates pixels, each kind apart.
struct DeviateBlock {
  alignas(64) std::array<std::uint32_t, kMostDeviates> high, low, turn;
};
/// Writes the deviates of a block of words, each within kDeviateError of exact_box_muller().
void near_box_muller(const DeviateBlock& words, std::array<double, kMostDeviates>* deviates);
/// Writes the deviates of the pixels `first_pixel` (a multiple of kMostDeviates), first_pixel + 1, ...,
/// several times faster than exact_deviate() one by one.
void near_deviates(const DeviateSource& source, std::uint64_t first_pixel,
                   std::array<double, kMostDeviates>* deviates);

}  // namespace fringetwin::render
