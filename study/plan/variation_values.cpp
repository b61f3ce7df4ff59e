// SPDX-License-Identifier: Apache-2.0
#include "study/plan/variation_values.hpp"

#include <algorithm>
#include <cmath>

#include "study/plan/space_filling.hpp"
#include "twin/base/parse_number.hpp"

namespace fringetwin::study {
namespace {

/// Returns the value at the share i / n of the range: both ends exact, whole steps whole.
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

}  // namespace

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

void assign_listed(const Variation& variation, const std::vector<std::string>& values, std::size_t i,
                   Settings* settings) {
  if (variation.rows.empty()) return assign(variation, values[i], settings);
  for (std::size_t k = 0; k < variation.keys.size(); ++k)
    (*settings)[variation.keys[k]] = variation.rows[i][k];
}

void assign_at(const Variation& variation, double u, Settings* settings) {
  if (variation.range)
    assign(variation, value_at(variation, u), settings);
  else
    assign_listed(variation, variation.values, share_of(u, variation.values.size()), settings);
}

}  // namespace fringetwin::study
