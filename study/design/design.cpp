// SPDX-License-Identifier: Apache-2.0
#include "study/design/design.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "render/base/philox.hpp"
#include "render/base/sobol.hpp"
#include "twin/base/parse_number.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::study {
namespace {

/// What a random number is for; with the seed it makes the key, so that no two uses share numbers.
enum class Use : std::uint32_t { jitter, order, scramble };

render::PhiloxCounter random_words(std::uint64_t seed, Use use, std::uint32_t a, std::uint32_t b,
                                   std::uint32_t c = 0) {
  return render::philox4x32({a, b, c, static_cast<std::uint32_t>(use)},
                            {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

/// 53 bits, in [0, 1).
double unit(std::uint32_t high, std::uint32_t low) {
  return static_cast<double>(std::uint64_t{high} << 21 | low >> 11) * 0x1p-53;
}

/// Owen's scrambling: every bit is turned or not as drawn for the bits before it.
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

/// At the share i / n of the way: both ends exact, whole steps whole.
double along(const Range& range, double i, double n) {
  if (i == 0.0) return range.first;
  if (i == n) return range.last;
  const double value =
      range.log ? std::pow(10.0, (std::log10(range.first) * (n - i) + std::log10(range.last) * i) / n)
                : range.first + (range.last - range.first) * i / n;
  return std::clamp(value, range.first, range.last);
}

void assign(const Variation& variation, const std::string& value, Settings* settings) {
  for (const std::string& key : variation.keys) (*settings)[key] = value;
}

/// The i-th value, of which `values` has the texts.
void assign_listed(const Variation& variation, const std::vector<std::string>& values, std::size_t i,
                   Settings* settings) {
  if (variation.rows.empty()) return assign(variation, values[i], settings);
  for (std::size_t k = 0; k < variation.keys.size(); ++k)
    (*settings)[variation.keys[k]] = variation.rows[i][k];
}

std::vector<Settings> grid(const StudyFile& study) {
  std::vector<Settings> all = {{}};
  for (const Variation& variation : study.vary) {
    const std::vector<std::string> values = listed_values(variation);
    std::vector<Settings> longer;
    longer.reserve(all.size() * values.size());
    for (const Settings& settings : all)
      for (std::size_t i = 0; i < values.size(); ++i) {
        longer.push_back(settings);
        assign_listed(variation, values, i, &longer.back());
      }
    all = std::move(longer);
  }
  return all;
}

std::vector<Settings> list(const StudyFile& study) {
  std::vector<Settings> all;
  for (const Variation& variation : study.vary) {
    const std::vector<std::string> values = listed_values(variation);
    all.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) assign_listed(variation, values, i, &all[i]);
  }
  return all.empty() ? std::vector<Settings>{{}} : all;
}

std::vector<Settings> sampled(const StudyFile& study) {
  const auto dimensions = static_cast<int>(study.vary.size());
  const UnitPoints points = study.design == Design::sobol
                                ? scrambled_sobol(study.points, dimensions, study.seed)
                                : latin_hypercube(study.points, dimensions, study.seed);
  std::vector<Settings> all(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t d = 0; d < study.vary.size(); ++d) assign_at(study.vary[d], points[i][d], &all[i]);
  return all;
}

}  // namespace

UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed) {
  const auto count = static_cast<std::uint32_t>(n);
  UnitPoints points(count, std::vector<double>(static_cast<std::size_t>(dimensions)));
  std::vector<std::uint32_t> order(count);
  for (std::uint32_t d = 0; d < static_cast<std::uint32_t>(dimensions); ++d) {
    std::iota(order.begin(), order.end(), 0U);
    for (std::uint32_t i = count; i > 1; --i) {  // Fisher and Yates
      const auto words = random_words(seed, Use::order, i, d);
      const auto k = static_cast<std::uint32_t>(unit(words[0], words[1]) * i);
      std::swap(order[i - 1], order[k]);
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto words = random_words(seed, Use::jitter, i, d);
      const double place = (order[i] + unit(words[0], words[1])) / count;
      // rounding may lift the last of an interval over its end
      points[i][d] = std::min(place, std::nextafter((order[i] + 1.0) / count, 0.0));
    }
  }
  return points;
}

UnitPoints scrambled_sobol(int n, int dimensions, std::uint64_t seed) {
  const auto count = static_cast<std::uint32_t>(n);
  UnitPoints points(count, std::vector<double>(static_cast<std::size_t>(dimensions)));
  for (std::uint32_t d = 0; d < static_cast<std::uint32_t>(dimensions); ++d) {
    const auto directions = render::sobol_directions(static_cast<int>(d));
    for (std::uint32_t i = 0; i < count; ++i)
      points[i][d] = scrambled(render::sobol_coordinate(directions, i), seed, d, i);
  }
  return points;
}

std::size_t share_of(double u, std::size_t n) {
  return std::min(static_cast<std::size_t>(u * static_cast<double>(n)), n - 1);
}

double middle_of_share(std::size_t i, std::size_t n) {
  return (static_cast<double>(i) + 0.5) / static_cast<double>(n);
}

std::vector<std::string> listed_values(const Variation& variation) {
  if (!variation.range) return variation.values;
  std::vector<std::string> values;
  const int count = variation.range->count.value_or(0);
  for (int i = 0; i < count; ++i) values.push_back(number_text(along(*variation.range, i, count - 1)));
  return values;
}

std::string value_at(const Variation& variation, double u) {
  if (variation.range) return number_text(along(*variation.range, u, 1.0));
  return variation.values[share_of(u, variation.values.size())];
}

void assign_at(const Variation& variation, double u, Settings* settings) {
  if (variation.range)
    assign(variation, value_at(variation, u), settings);
  else
    assign_listed(variation, variation.values, share_of(u, variation.values.size()), settings);
}

std::vector<StudyPoint> design_points(const StudyFile& study) {
  const std::vector<Settings> all = study.design == Design::grid   ? grid(study)
                                    : study.design == Design::list ? list(study)
                                                                   : sampled(study);
  std::vector<StudyPoint> points;
  points.reserve(all.size() * static_cast<std::size_t>(study.noise_seeds));
  for (const Settings& settings : all)
    for (int k = 0; k < study.noise_seeds; ++k)
      points.push_back({static_cast<std::int64_t>(points.size()), settings,
                        study.first_noise_seed + static_cast<std::uint64_t>(k)});
  return points;
}

}  // namespace fringetwin::study
