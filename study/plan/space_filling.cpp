// SPDX-License-Identifier: Apache-2.0
#include "study/plan/space_filling.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "render/base/philox.hpp"
#include "render/base/sobol.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::study {
namespace {

/// What a random number is for; with the seed it makes the key, so that no two uses share numbers.
enum class Use : std::uint32_t { jitter, order, scramble };

render::PhiloxCounter random_words(std::uint64_t seed, Use use, std::uint32_t a, std::uint32_t b,
                                   std::uint32_t c = 0) {
  return render::philox4x32({a, b, c, static_cast<std::uint32_t>(use)},
                            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

/// Returns a number of 53 bits in [0, 1).
double unit(std::uint32_t high, std::uint32_t low) {
  return static_cast<double>(std::uint64_t{high} << 21 | low >> 11) * 0x1p-53;
}

/// Returns the coordinate x after Owen's scrambling: every bit is turned or not as drawn for the bits before
/// it.
double scrambled(std::uint32_t x, std::uint64_t seed, std::uint32_t dimension, std::uint32_t index) {
  std::uint32_t turned = 0;
  for (std::uint32_t bit = 0; bit < 32; ++bit) {
    const std::uint32_t before = bit == 0 ? 0U : x >> (32 - bit);
    turned |= (random_words(seed, Use::scramble, dimension, bit, before)[0] & 1U) << (31 - bit);
  }
  // below the 32 bits of the sequence the place is free
  const std::uint32_t fine = random_words(seed, Use::jitter, index, dimension)[0];
  return unit(x ^ turned, fine);
}

}  // namespace

LatinHypercube::LatinHypercube(int n, int dimensions, std::uint64_t seed)
    : count_(static_cast<std::uint32_t>(n)),
      seed_(seed),
      order_(static_cast<std::size_t>(n) * static_cast<std::size_t>(dimensions)) {
  for (std::uint32_t d = 0; d < static_cast<std::uint32_t>(dimensions); ++d) {
    const std::span order = std::span(order_).subspan(std::size_t{d} * count_, count_);
    std::iota(order.begin(), order.end(), 0U);
    for (std::uint32_t i = count_; i > 1; --i) {  // Fisher and Yates
      const auto words = random_words(seed, Use::order, i, d);
      const auto k = static_cast<std::uint32_t>(unit(words[0], words[1]) * i);
      std::swap(order[i - 1], order[k]);
    }
  }
}

std::vector<double> LatinHypercube::point(std::size_t index) const {
  FT_CHECK(index < count_, "a point of the hypercube");
  std::vector<double> place;
  for (std::size_t at = index; at < order_.size(); at += count_) {
    const auto words = random_words(seed_, Use::jitter, static_cast<std::uint32_t>(index),
                                    static_cast<std::uint32_t>(place.size()));
    const double drawn = (order_[at] + unit(words[0], words[1])) / count_;
    // rounding may lift the last of an interval over its end
    place.push_back(std::min(drawn, std::nextafter((order_[at] + 1.0) / count_, 0.0)));
  }
  return place;
}

UnitPoints scrambled_sobol(int n, int dimensions, std::uint64_t seed) {
  const auto count = static_cast<std::uint32_t>(n);
  UnitPoints points;
  points.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) points.push_back(scrambled_sobol_point(i, dimensions, seed));
  return points;
}

std::vector<double> scrambled_sobol_point(std::size_t index, int dimensions, std::uint64_t seed) {
  const auto i = static_cast<std::uint32_t>(index);
  std::vector<double> place;
  for (std::uint32_t d = 0; d < static_cast<std::uint32_t>(dimensions); ++d)
    place.push_back(
        scrambled(render::sobol_coordinate(render::sobol_directions(static_cast<int>(d)), i), seed, d, i));
  return place;
}

std::size_t share_of(double u, std::size_t n) {
  return std::min(static_cast<std::size_t>(u * static_cast<double>(n)), n - 1);
}

double middle_of_share(std::size_t i, std::size_t n) {
  return (static_cast<double>(i) + 0.5) / static_cast<double>(n);
}

}  // namespace fringetwin::study
