// SPDX-License-Identifier: Apache-2.0
#include "twin/camera_response.hpp"

#include <algorithm>
#include <cstddef>

namespace fringetwin {
namespace {

/// A straight piece of the curve, through a point of it.
struct Piece {
  double in_dn = 0.0, out_dn = 0.0, slope = 1.0;
};

/// Returns the piece behind so many corners.
Piece piece_after(const CameraResponse& f, std::size_t n) {
  if (n == 0) return {};
  const CameraResponse::Corner& from = f.corners[n - 1];
  if (n == f.corners.size()) return {from.in_dn, from.out_dn, f.last_slope};
  const CameraResponse::Corner& to = f.corners[n];
  return {from.in_dn, from.out_dn, (to.out_dn - from.out_dn) / (to.in_dn - from.in_dn)};
}

/// Returns the piece that holds a value of this coordinate.
Piece piece_at(const CameraResponse& f, double CameraResponse::Corner::*coordinate, double value) {
  const auto behind = std::ranges::upper_bound(f.corners, value, {}, coordinate);
  return piece_after(f, static_cast<std::size_t>(behind - f.corners.begin()));
}

}  // namespace

double CameraResponse::operator()(double in_dn) const {
  const Piece p = piece_at(*this, &Corner::in_dn, in_dn);
  return p.out_dn + p.slope * (in_dn - p.in_dn);
}

double CameraResponse::inverse(double out_dn) const {
  const Piece p = piece_at(*this, &Corner::out_dn, out_dn);
  return p.in_dn + (out_dn - p.out_dn) / p.slope;
}

double CameraResponse::slope(double in_dn) const { return piece_at(*this, &Corner::in_dn, in_dn).slope; }

double CameraResponse::steepest() const {
  double most = 1.0;
  for (std::size_t n = 1; n <= corners.size(); ++n) most = std::max(most, piece_after(*this, n).slope);
  return most;
}

CameraResponse CameraResponse::scaled(double scale) const {
  CameraResponse out = *this;
  for (Corner& corner : out.corners) corner.in_dn *= scale, corner.out_dn *= scale;
  return out;
}

}  // namespace fringetwin
