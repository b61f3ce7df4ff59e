// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gain_sums.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "twin/image/rows_of_images.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kBlock = 32;  // side of a block of the sandwich, px

/// Plain sums of one block. Doubles, so that compilers keep them in registers.
struct BlockSums {
  double n = 0, n_beyond = 0;
  double s0 = 0, s1 = 0;             // psi x
  double i00 = 0, i01 = 0, i11 = 0;  // psi' x x^T
  double q00 = 0, q01 = 0, q11 = 0;  // psi^2 x x^T
  double g01 = 0, g11 = 0;           // x x^T
  double y = 0, y2 = 0, r2 = 0, before2 = 0;
};

struct RowSpan {
  const float* real;
  const float* source;     // irradiance or simulated DN
  const float* simulated;  // DN as rendered; null: what the twin's own sensor would give, unrounded
  const unsigned char* mask;
  int n;
};

/// Values of one row of one block, in doubles; what must not be used has weight 0 and value 0 (no NaN
/// inside).
struct Lane {
  double w[kBlock], y[kBlock], x[kBlock], before[kBlock];
};

/// Returns false when no value of the row is used.
bool fill_lane(const RowSpan& row, const GrayPair& pair, const UsableRange& u, double e_center, Lane& lane) {
  if (std::none_of(row.mask, row.mask + row.n, [](unsigned char m) { return m != 0; })) return false;
  const Sensor& sensor = pair.camera->sensor;
  const double gain = sensor.gain_dn, black = sensor.black_level_dn, max = sensor.max_dn();
  double used = 0.0;
  for (int i = 0; i < row.n; ++i) {
    const double y = static_cast<double>(row.real[i]), v = static_cast<double>(row.source[i]);
    const double e = pair.e_scale * v + pair.e_offset;
    const double predicted = u.gain_dn * e + u.black_level_dn;
    // comparisons with NaN are false
    const bool use = (row.mask[i] != 0) & (y < u.saturation_dn) & (v > u.sim_low) & (v < u.sim_high) &
                     (predicted >= u.low_dn) & (predicted <= u.high_dn);
    const double simulated = row.simulated ? static_cast<double>(row.simulated[i])
                                           : std::min(std::max(gain * e + black, 0.0), max);
    lane.w[i] = use ? 1.0 : 0.0;
    lane.y[i] = use ? y : 0.0;
    lane.x[i] = use ? e - e_center : 0.0;
    lane.before[i] = use ? simulated - y : 0.0;
    used += lane.w[i];
  }
  return used > 0.0;
}

/// Selects instead of branches, so that the sums vectorise; their order is fixed at compile time.
void add_lane(const Lane& lane, int count, const GainModel& m, BlockSums& out) {
  double n = 0, n_beyond = 0, s0 = 0, s1 = 0, i00 = 0, i01 = 0, i11 = 0, q00 = 0, q01 = 0, q11 = 0, g01 = 0,
         g11 = 0, sy = 0, sy2 = 0, r2 = 0, before2 = 0;
#pragma omp simd reduction(+ : n, n_beyond, s0, s1, i00, i01, i11, q00, q01, q11, g01, g11, sy, sy2, r2, before2)
  for (int i = 0; i < count; ++i) {
    const double w = lane.w[i], y = lane.y[i], x = lane.x[i], b = lane.before[i];
    const double r = y - w * (m.a + m.b * x);
    const double inside = std::abs(r) < m.threshold_dn ? w : 0.0;
    const double psi = std::min(std::max(r, -m.threshold_dn), m.threshold_dn);
    n += w;
    n_beyond += w - inside;
    s0 += psi;
    s1 += psi * x;
    i00 += inside;
    i01 += inside * x;
    i11 += inside * x * x;
    q00 += psi * psi;
    q01 += psi * psi * x;
    q11 += psi * psi * x * x;
    g01 += x;
    g11 += x * x;
    sy += y;
    sy2 += y * y;
    r2 += r * r;
    before2 += b * b;
  }
  out.n += n, out.n_beyond += n_beyond, out.s0 += s0, out.s1 += s1;
  out.i00 += i00, out.i01 += i01, out.i11 += i11;
  out.q00 += q00, out.q01 += q01, out.q11 += q11;
  out.g01 += g01, out.g11 += g11;
  out.y += sy, out.y2 += sy2, out.r2 += r2, out.before2 += before2;
}

Eigen::Matrix2d symmetric(double a, double b, double c) {
  Eigen::Matrix2d m;
  m << a, b, b, c;
  return m;
}

GainSums reduce(const std::vector<BlockSums>& blocks) {
  GainSums total;
  double n = 0, n_beyond = 0;
  for (const BlockSums& b : blocks) {
    if (b.n == 0) continue;
    n += b.n;
    n_beyond += b.n_beyond;
    const Eigen::Vector2d score(b.s0, b.s1);
    total.score += score;
    total.information += symmetric(b.i00, b.i01, b.i11);
    total.score_independent += symmetric(b.q00, b.q01, b.q11);
    total.score_blocks += score * score.transpose();
    total.gram += symmetric(b.n, b.g01, b.g11);
    ++total.n_blocks;
    total.sum_y += b.y;
    total.sum_y2 += b.y2;
    total.sum_r2 += b.r2;
    total.sum_before2 += b.before2;
  }
  total.n = static_cast<std::uint64_t>(n);
  total.n_beyond = static_cast<std::uint64_t>(n_beyond);
  return total;
}

}  // namespace

GainSums sum_gain(const GrayPair& pair, const UsableRange& usable, const GainModel& model) {
  const int width = pair.width(), height = pair.height();
  const int across = (width + kBlock - 1) / kBlock, down = (height + kBlock - 1) / kBlock;
  std::vector<BlockSums> blocks(static_cast<std::size_t>(across) * static_cast<std::size_t>(down));
  // simulated images that are irradiance themselves say nothing about DN
  const bool has_dn = pair.simulated && !pair.simulated->radiance;
#pragma omp parallel for schedule(dynamic)
  for (int band = 0; band < down; ++band)
    for (const int image : pair.gain_images) {
      Lane lane;
      RowsOfImages rows;
      for (int y = band * kBlock; y < std::min((band + 1) * kBlock, height); ++y)
        for (int block = 0; block < across; ++block) {
          const int x = block * kBlock;
          const std::size_t at = pair.mask.index(x, y);
          const int n = std::min(kBlock, width - x);
          rows.start();
          const auto from = [&](const CameraImages& images) {
            return rows.next(images.images[image], at, static_cast<std::size_t>(n));
          };
          const RowSpan row{from(*pair.real), from(*pair.irradiance),
                            has_dn ? from(*pair.simulated) : nullptr, &pair.mask.data[at], n};
          if (fill_lane(row, pair, usable, model.e_center, lane))
            add_lane(lane, row.n, model, blocks[band * across + block]);
        }
    }
  return reduce(blocks);
}

}  // namespace fringetwin::compare
