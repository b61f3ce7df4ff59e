// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/own_light.hpp"

#include <algorithm>

namespace fringetwin::compare {
namespace {

constexpr double kNoLightSpread = 1e-6;  ///< of a sum of squares: the light is the same in all images

}  // namespace

double OwnLightSums::spread() const {
  const double about_mean = n_ > 1.0 ? xx_ - x_ * x_ / n_ : 0.0;
  return about_mean > kNoLightSpread * xx_ ? about_mean : 0.0;
}

OwnLight OwnLightSums::line(const OwnKinds& kinds, double gain_dn) const {
  OwnLight own;
  if (kinds.factor && !kinds.offset && xx_ > 0.0) own.factor = std::max(0.0, xy_ / (gain_dn * xx_));
  if (kinds.factor && kinds.offset && spread() > 0.0)
    own.factor = std::max(0.0, (xy_ - x_ * y_ / n_) / (gain_dn * spread()));
  if (kinds.offset && n_ > 0.0) own.offset_dn = (y_ - own.factor * gain_dn * x_) / n_;
  return own;
}

double OwnLightSums::variance_at(const OwnKinds& kinds, double light) const {
  if (kinds.factor && !kinds.offset) return xx_ > 0.0 ? light * light * vxx_ / (xx_ * xx_) : 0.0;
  if (!kinds.offset || !(n_ > 0.0)) return 0.0;
  // the line at this light is the sum of weight * value over the values, weight = 1/n + (x - mean) * slope
  const double mean = x_ / n_, slope = kinds.factor && spread() > 0.0 ? (light - mean) / spread() : 0.0;
  const double about_mean = vx_ - mean * v_, about_mean2 = vxx_ - 2.0 * mean * vx_ + mean * mean * v_;
  return v_ / (n_ * n_) + 2.0 * slope * about_mean / n_ + slope * slope * about_mean2;
}

double OwnLightSums::leverage_at(const OwnKinds& kinds, double light) const {
  if (kinds.factor && !kinds.offset) return xx_ > 0.0 ? light * light / xx_ : 0.0;
  if (!kinds.offset || !(n_ > 0.0)) return 0.0;
  const double off = light - x_ / n_;
  return 1.0 / n_ + (kinds.factor && spread() > 0.0 ? off * off / spread() : 0.0);
}

}  // namespace fringetwin::compare
