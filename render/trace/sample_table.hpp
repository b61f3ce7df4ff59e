// SPDX-License-Identifier: Apache-2.0
// Makes the sets of sample points over the pixel's square and the lens disk that the shaders read.
#pragma once
#include <cstdint>
#include <vector>

#include "render/shaders/shared.h"

namespace fringetwin::render {

struct DiskPoint {
  double x, y, weight;  ///< unit disk; weights sum to 1
};
/// Returns a quadrature rule over the unit disk: Gauss-Legendre in r^2 (the area element) times equal angles,
/// exact for polynomials of degree min(2 radial - 1, (angles - 1) / 2) in r^2.
std::vector<DiskPoint> disk_rule(int radial, int angles);

/// The largest swing that disk_rule_for_swing() serves.
constexpr double kLargestDiskSwingRad = 29.0;
/// Returns the rule with the points needed on the lens so that a fringe whose phase swings by `swing_rad`
/// from the centre of the lens to its rim is averaged to about 1e-6; beyond kLargestDiskSwingRad as many as
/// there.
std::vector<DiskPoint> disk_rule_for_swing(double swing_rad);

/// Returns the table of an n x n Gauss rule: vec4 (dx, dy, weight, place) per sample in px; with a lens two
/// per sample, the second (x, y, 0, 0) in mm; then n shares: as shared.h has it at BIND_SAMPLES.
std::vector<gpu::vec4> gauss_samples(int samples, double pixel_fill, const std::vector<DiskPoint>& lens,
                                     double lens_radius_mm);

/// Returns the first n points of the 4-dimensional Sobol sequence (Joe and Kuo's direction numbers), 32 bits.
std::vector<gpu::uvec4> sobol_points(std::uint32_t n);

/// A raster of columns x rows.
struct Factors {
  std::uint32_t columns, rows;
};
/// Returns a raster of n cells, as square as possible; one of more than n cells where n has no good factors.
Factors multi_jitter_factors(std::uint32_t n);

}  // namespace fringetwin::render
