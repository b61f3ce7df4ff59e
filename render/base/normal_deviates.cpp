// SPDX-License-Identifier: Apache-2.0
#include "render/base/normal_deviates.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "twin/base/errors.hpp"

// The loops are compiled for several widths of registers, of which the processor takes the widest. Programs
// with a sanitizer cannot choose that early.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__GLIBC__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define FRINGETWIN_WIDEST __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define FRINGETWIN_WIDEST
#endif

namespace fringetwin::render {
namespace {

FRINGETWIN_WIDEST void draw_words(const PhiloxKey& key, const PhiloxCounter& first, DeviateBlock* words) {
  for (std::uint32_t i = 0; i < kMostDeviates; ++i) {
    const PhiloxCounter w = philox4x32({first[0] + i, first[1], first[2], first[3]}, key);
    words->high[i] = w[0];
    words->low[i] = w[1];
    words->turn[i] = w[2];
  }
}

/// Converts exactly, in vector registers of any width.
double as_double(std::uint32_t w) {
  return std::bit_cast<double>(0x4330000000000000u | std::uint64_t{w}) - 0x1p52;
}

/// Approximates the logarithm of a normal positive number. u = m 2^e with m in [sqrt(1/2), sqrt 2); log m = 2
/// artanh((m - 1)/(m + 1)).
double near_log(double u) {
  constexpr std::uint64_t kRootHalf = 0x3FE6A09E667F3BCD, kOne = 0x3FF0000000000000;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(u) + (kOne - kRootHalf);
  const double exponent = std::bit_cast<double>((bits >> 52) | 0x4330000000000000u) - (0x1p52 + 1023.0);
  const double m = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFu) + kRootHalf);
  const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
  const double series = 1.0 + s2 * (1.0 / 3 + s2 * (1.0 / 5 + s2 * (1.0 / 7 + s2 / 9)));
  return exponent * std::numbers::ln2 + 2.0 * s * series;
}

/// Approximates cos(2 pi w / 2^32) = sin(pi/2 - |angle|).
double near_cosine(std::uint32_t w) {
  const double turns = std::abs(static_cast<double>(static_cast<std::int32_t>(w))) * 0x1p-32;
  const double y = (0.25 - turns) * (2.0 * std::numbers::pi), y2 = y * y;
  double series = 1.0 / 6227020800;  // 1/13!
  for (const double factorial : {39916800.0, 362880.0, 5040.0, 120.0, 6.0, 1.0})
    series = 1.0 / factorial - y2 * series;
  return y * series;
}

PhiloxCounter counter(const DeviateSource& source, std::uint64_t pixel) {
  return {static_cast<std::uint32_t>(pixel), static_cast<std::uint32_t>(pixel >> 32), source.image,
          source.camera};
}

}  // namespace

double exact_box_muller(const DeviateWords& words) {
  const std::uint64_t bits = (std::uint64_t{words.high} << 32) | words.low;
  const double u = (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
  const double angle = 2.0 * std::numbers::pi * static_cast<double>(words.turn) * 0x1p-32;
  return std::sqrt(-2.0 * std::log(u)) * std::cos(angle);
}

double exact_deviate(const DeviateSource& source, std::uint64_t pixel) {
  const PhiloxCounter w = philox4x32(counter(source, pixel), source.key);
  return exact_box_muller({w[0], w[1], w[2]});
}

FRINGETWIN_WIDEST void near_box_muller(const DeviateBlock& words,
                                       std::array<double, kMostDeviates>* deviates) {
  for (std::size_t i = 0; i < kMostDeviates; ++i) {
    const double u = (as_double(words.high[i]) * 0x1p21 + (as_double(words.low[i] >> 11) + 0.5)) * 0x1p-53;
    (*deviates)[i] = std::sqrt(-2.0 * near_log(u)) * near_cosine(words.turn[i]);
  }
}

void near_deviates(const DeviateSource& source, std::uint64_t first_pixel,
                   std::array<double, kMostDeviates>* deviates) {
  FT_CHECK(first_pixel % kMostDeviates == 0, "a block of deviates");  // its counters share their upper half
  DeviateBlock words;
  draw_words(source.key, counter(source, first_pixel), &words);
  near_box_muller(words, deviates);
}

}  // namespace fringetwin::render
