// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/cell_transfer.hpp"

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr float kNothingLeft = 1e-6F;  // of the largest value: less than single precision tells of a sum
// Surfaces reflect all light at most; a closed cavity that does never comes to rest.
constexpr int kMostTimes = 2000;

float largest(const std::vector<float>& values) {
  float most = 0.0F;
  for (const float v : values) most = std::max(most, std::abs(v));
  return most;
}

}  // namespace

void CellTransfer::add_row(std::vector<Share> shares) {
  std::ranges::sort(shares, {}, &Share::cell);
  const std::size_t begin = shares_.size();
  for (const Share& s : shares) {
    if (shares_.size() > begin && shares_.back().cell == s.cell)
      shares_.back().share += s.share;
    else
      shares_.push_back(s);
  }
  first_.push_back(shares_.size());
}

std::vector<float> CellTransfer::apply(const std::vector<float>& x, std::size_t channels) const {
  std::vector<float> out(x.size(), 0.0F);
#pragma omp parallel for schedule(dynamic, 64)
  for (std::size_t row = 0; row < rows(); ++row) {
    float* to = &out[row * channels];
    for (std::size_t k = first_[row]; k < first_[row + 1]; ++k) {
      const float* from = &x[static_cast<std::size_t>(shares_[k].cell) * channels];
      for (std::size_t c = 0; c < channels; ++c) to[c] += shares_[k].share * from[c];
    }
  }
  return out;
}

std::vector<float> CellTransfer::spread(const std::vector<float>& b, std::size_t channels,
                                        std::optional<int> times) const {
  FT_CHECK(b.size() == rows() * channels, "a value for each cell and channel");
  std::vector<float> sum = b, last = b;
  const int most = times.value_or(kMostTimes);
  for (int k = 0; k < most; ++k) {
    last = apply(last, channels);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += last[i];
    if (!times && largest(last) <= kNothingLeft * largest(sum)) break;
  }
  return sum;
}

}  // namespace fringetwin::render
