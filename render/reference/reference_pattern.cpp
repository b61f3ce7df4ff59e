// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference_pattern.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "render/base/quadrature.hpp"

namespace fringetwin::render {
namespace {

using std::numbers::pi;
constexpr int kDiskNodes = 64, kPanelsWithKinks = 6, kFourierSamples = 4096, kPanelNodes = 16,
              kPartsOfASine = 8;

double normal_cdf(double t) { return 0.5 * std::erfc(-t / std::numbers::sqrt2); }

// Mean of f over the projection of a uniform disk on an axis: offsets r sin(angle), density cos^2.
template <class F>
double over_disk(double radius, F f, int panels = 1) {
  if (radius == 0.0) return f(0.0);
  const GaussRule& rule = gauss_rule(kDiskNodes);
  double sum = 0.0;
  for (int p = 0; p < panels; ++p)
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double angle = 0.5 * pi * ((2.0 * p + 1.0 + rule.nodes[i]) / panels - 1.0);
      sum += rule.weights[i] * std::cos(angle) * std::cos(angle) * f(radius * std::sin(angle));
    }
  return sum / panels;  // (2/pi) (pi/2) sum
}

// Share of a point's blur spot (disk, then Gaussian) that lies left of `distance`.
double spot_cdf(double distance, double radius, double sigma) {
  if (sigma > 0.0) return over_disk(radius, [&](double o) { return normal_cdf((distance - o) / sigma); });
  if (radius == 0.0) return distance >= 0.0 ? 1.0 : 0.0;
  const double t = std::clamp(distance / radius, -1.0, 1.0), angle = std::acos(t);
  return 1.0 - (angle - std::sin(angle) * std::cos(angle)) / pi;  // a disk cut by a chord
}

}  // namespace

Eigen::Vector2d reference_defocus_px(const Projector& projector, double z_mm) {
  if (!projector.optics) return {0.0, 0.0};
  const Optics& o = *projector.optics;
  const double diameter_mm =
      o.focal_length_mm / o.f_number * std::abs(z_mm - o.focus_distance_mm) / o.focus_distance_mm;
  const auto& k = projector.lens.intrinsics();
  return 0.5 * diameter_mm / z_mm * Eigen::Vector2d(k[0], k[1]);
}

double reference_pixel_gaps(const Projector& projector, const Eigen::Vector2d& q_px) {
  if (!projector.pixel_structure || projector.pixel_fill == 1.0) return 1.0;
  const double half = 0.5 * projector.pixel_fill, sigma = projector.blur_px;
  double factor = 1.0;
  for (const double q : {q_px.x(), q_px.y()}) {
    double sum = 0.0;
    const long nearest = std::lround(q), reach = static_cast<long>(std::ceil(9.0 * sigma)) + 1;
    for (long i = nearest - reach; i <= nearest + reach; ++i) {
      const double d = q - static_cast<double>(i);
      sum += sigma > 0.0 ? normal_cdf((d + half) / sigma) - normal_cdf((d - half) / sigma)
                         : (std::abs(d) <= half ? 1.0 : 0.0);
    }
    factor *= sum / projector.pixel_fill;
  }
  return factor;
}

double reference_light_field(const Projector& projector, const Eigen::Vector2d& q_px) {
  const double u = 2.0 * (q_px.x() + 0.5) / projector.lens.width() - 1.0,
               v = 2.0 * (q_px.y() + 0.5) / projector.lens.height() - 1.0;
  double ln = 0.0;
  std::size_t k = 0;
  for (unsigned order = 1; order <= 4; ++order)
    for (unsigned j = 0; j <= order; ++j, ++k)
      if (k < projector.light_field.size())
        ln += projector.light_field[k] * std::legendre(order - j, u) * std::legendre(j, v);
  return std::exp(ln);
}

double reference_shown_level(const Projector& projector, const ImageF& levels, const Eigen::Vector2d& q_px) {
  const double sigma = std::sqrt(projector.blur_variance_px2(q_px));
  const auto shown = [&](double x, double y) {
    double level = image_level(levels, x, y);
    if (projector.quantise_bits) {
      const double most = std::exp2(*projector.quantise_bits) - 1.0;
      level = std::round(level * most) / most;
    }
    return projector.response(level);
  };
  if (sigma == 0.0) return shown(q_px.x(), q_px.y());
  const auto share = [sigma](double from_center) {
    const double scale = 1.0 / (sigma * std::numbers::sqrt2);
    return 0.5 * (std::erf((from_center + 0.5) * scale) - std::erf((from_center - 0.5) * scale));
  };
  const long reach = static_cast<long>(std::ceil(8.5 * sigma)) + 1;
  const long column = std::lround(q_px.x()), row = std::lround(q_px.y());
  double sum = 0.0;
  for (long y = row - reach; y <= row + reach; ++y)
    for (long x = column - reach; x <= column + reach; ++x)
      sum += share(q_px.x() - static_cast<double>(x)) * share(q_px.y() - static_cast<double>(y)) *
             shown(static_cast<double>(x), static_cast<double>(y));
  return sum;
}

ReferencePattern::ReferencePattern(const Twin& twin, const PatternSpec& pattern, double shift_px,
                                   Harmonics of_image)
    : projector_(*twin.projector),
      fringes_(twin.fringes),
      spec_(pattern),
      of_image_(std::move(of_image)),
      shift_px_(shift_px) {
  const DirectionFringes& d = fringes_.directions.at(spec_.direction);
  axis_ = d.axis;
  const std::size_t p = spec_.is_gray() ? 0 : static_cast<std::size_t>(spec_.pitch);
  pitch_px_ = d.pitches_px.at(p);
  origin_px_ = d.phase_origin_px.at(p);
  if (!spec_.is_gray() && !d.contrast.empty()) {
    contrast_ = d.contrast.at(p);
    mean_ = mean_over_a_period();
  }
  if (spec_.is_gray() || projector_.pixel_structure || projector_.blur_px == 0.0 ||
      fringes_.waveform.kind != Waveform::Kind::sine)
    return;
  // The discrete cosine sum of one period; what blur leaves of harmonic k falls below 1e-17 soon.
  for (int k = 0; k < kFourierSamples / 4; ++k) {
    const double u = pi * k * projector_.blur_px / pitch_px_;
    if (2.0 * u * u > 40.0) break;
    double sum = 0.0;
    for (int i = 0; i < kFourierSamples; ++i) {
      const double t = 2.0 * pi * i / kFourierSamples;
      sum += response(fringes_.mean + fringes_.amplitude * std::cos(t)) * std::cos(k * t);
    }
    fourier_.push_back((k == 0 ? 1.0 : 2.0) * sum / kFourierSamples * std::exp(-2.0 * u * u));
  }
}

double ReferencePattern::response(double value) const {
  return projector_.response(std::clamp(value, 0.0, 1.0));
}

double ReferencePattern::frame_buffer(long pixel) const {
  double value = pattern_value(fringes_, spec_, static_cast<double>(pixel));
  if (projector_.quantise_bits) {
    const double levels = std::exp2(*projector_.quantise_bits) - 1.0;
    value = std::round(value * levels) / levels;
  }
  return response(value) + (spec_.is_gray()
                                ? 0.0
                                : harmonics(fringes_.directions[spec_.direction].harmonics_of(spec_.pitch),
                                            static_cast<double>(pixel), 0.0, 0.0));
}

// The added harmonics, each a wave of its own with the blur's and the disk's Fourier transforms.
double ReferencePattern::harmonics(const Harmonics& list, double x, double radius, double sigma,
                                   int lowest) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double wave_px = pitch_px_ / (lowest + static_cast<double>(i));  // wavelength
    const double crest_px = origin_px_ - pitch_px_ * spec_.step / fringes_.steps +
                            wave_px * std::atan2(list[i].sine, list[i].cosine) / (2.0 * pi);
    const double u = pi * sigma / wave_px, v = 2.0 * pi * radius / wave_px;
    const double disk = v == 0.0 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, v) / v;
    sum += std::hypot(list[i].cosine, list[i].sine) * std::exp(-2.0 * u * u) * disk *
           std::cos(2.0 * pi * (x - crest_px) / wave_px);
  }
  return sum;
}

// The waves of the raster: of each order the alias of least frequency that a raster of this pitch samples.
double ReferencePattern::raster(double x, double radius, double sigma) const {
  const Raster& r = fringes_.directions[spec_.direction].raster;
  double sum = 0.0;
  for (std::size_t i = 0; i < r.waves.size(); ++i) {
    const auto order = static_cast<double>(r.first_order) + static_cast<double>(i);
    const int middle_px = axis_ == Axis::x ? projector_.lens.width() / 2 : projector_.lens.height() / 2;
    double per_px = order / pitch_px_, turns = 0.0;  // as if it were not sampled
    for (; per_px >= 0.5 / r.pitch_px; per_px -= 1.0 / r.pitch_px) turns += (x - middle_px) / r.pitch_px;
    const double u = pi * sigma * per_px, v = 2.0 * pi * radius * std::abs(per_px);
    const double disk = v == 0.0 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, v) / v;
    const double angle =
        2.0 * pi *
        (order * ((x - origin_px_) / pitch_px_ + spec_.step / static_cast<double>(fringes_.steps)) - turns);
    const double half_px = 0.5 * r.pitch_px, w = 2.0 * pi * per_px;  // the mean of a wave over a pixel
    const double square =
        w == 0.0 ? 1.0 : (std::sin(w * half_px) - std::sin(-w * half_px)) / (w * r.pitch_px);
    sum += std::exp(-2.0 * u * u) * disk * square *
           (r.waves[i].cosine * std::cos(angle) + r.waves[i].sine * std::sin(angle));
  }
  return sum;
}

// The convolution integral of a table or a sine with the Gaussian, stretch by stretch, panels of a sigma at
// most.
double ReferencePattern::convolve(double x, double sigma) const {
  const double lowest = x - 9.0 * sigma, highest = x + 9.0 * sigma;
  const std::size_t n = fringes_.waveform.values.size();
  const double width = pitch_px_ / static_cast<double>(n > 0 ? n : kPartsOfASine);
  const double start = origin_px_ - pitch_px_ * spec_.step / fringes_.steps;
  const GaussRule& rule = gauss_rule(kPanelNodes);
  double sum = 0.0;
  for (double i = std::floor((lowest - start) / width); start + i * width < highest; i += 1.0) {
    const double a = std::max(lowest, start + i * width), b = std::min(highest, start + (i + 1.0) * width);
    const int panels = std::max(1, static_cast<int>(std::ceil((b - a) / sigma)));
    for (int p = 0; p < panels; ++p)
      for (std::size_t j = 0; j < rule.nodes.size(); ++j) {
        const double half = 0.5 * (b - a) / panels, t = a + half * (2.0 * p + 1.0 + rule.nodes[j]);
        const double u = (x - t) / sigma;
        sum += half * rule.weights[j] * std::exp(-0.5 * u * u) * response(pattern_value(fringes_, spec_, t));
      }
  }
  return sum / (sigma * std::sqrt(2.0 * pi));
}

// Pieces [start + i width, start + (i + 1) width) of constant value; with gaps only the middle of each
// piece (a pixel) gives light, and the mean over what arrives is taken.
double ReferencePattern::sum_pieces(double x, double radius, double width, double start, double sigma) const {
  const double reach = radius + 9.0 * sigma;
  const auto first = static_cast<long>(std::floor((x - reach - start) / width)) - 1;
  const auto last = static_cast<long>(std::floor((x + reach - start) / width)) + 1;
  const bool pixels = projector_.pixel_structure;
  const double lit = pixels && sigma > 0.0 ? projector_.pixel_fill : 1.0;
  double sum = 0.0, weights = 0.0;
  for (long i = first; i <= last; ++i) {
    const double center = start + (static_cast<double>(i) + 0.5) * width, half = 0.5 * width * lit;
    const double weight =
        spot_cdf(x - (center - half), radius, sigma) - spot_cdf(x - (center + half), radius, sigma);
    if (weight == 0.0) continue;
    sum += weight * (pixels ? frame_buffer(std::lround(shown_at(center)))
                            : response(pattern_value(fringes_, spec_, shown_at(center))));
    weights += weight;
  }
  return sum / weights;
}

// Where the projector shows what a code has at x: with a halo the image's first and last pixels go on.
double ReferencePattern::shown_at(double x) const {
  const double size = axis_ == Axis::x ? projector_.lens.width() : projector_.lens.height();
  return spec_.is_gray() && projector_.has_halo() ? std::clamp(x, 0.0, size - 1.0) : x;
}

// The light of a sine after the blur and, where a part of it is spread further, another Gaussian.
double ReferencePattern::smooth(double x, double radius, double further_px) const {
  if (projector_.blur_px == 0.0)
    return over_disk(
        radius, [&](double o) { return response(pattern_value(fringes_, spec_, x - o)); },
        projector_.response.kind == ProjectorResponse::Kind::table ? kPanelsWithKinks : 1);
  const double t =
      2.0 * pi * ((x - origin_px_) / pitch_px_ + static_cast<double>(spec_.step) / fringes_.steps);
  double sum = 0.0;
  for (std::size_t k = 0; k < fourier_.size(); ++k) {
    const double u = 2.0 * pi * static_cast<double>(k) * radius / pitch_px_;
    const double disk = u == 0.0 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, u) / u;
    const double v = pi * static_cast<double>(k) * further_px / pitch_px_;
    sum += fourier_[k] * std::exp(-2.0 * v * v) * disk * std::cos(static_cast<double>(k) * t);
  }
  return sum;
}

// Levels are pieces of constant light; a table is integrated numerically.
double ReferencePattern::waveform(double x, double radius, double sigma) const {
  if (fringes_.waveform.kind == Waveform::Kind::levels)
    return sum_pieces(x, radius, pitch_px_ / static_cast<double>(fringes_.waveform.values.size()),
                      origin_px_ - pitch_px_ * spec_.step / fringes_.steps, sigma);
  if (sigma > 0.0) return over_disk(radius, [&](double o) { return convolve(x - o, sigma); });
  return over_disk(
      radius, [&](double o) { return response(pattern_value(fringes_, spec_, x - o)); }, kPanelsWithKinks);
}

// The plain mean of the light before blur, at the middles of parts of a period.
double ReferencePattern::mean_over_a_period() const {
  constexpr int kParts = 1 << 16;
  double sum = 0.0;
  for (int i = 0; i < kParts; ++i)
    sum += response(pattern_value(fringes_, spec_, origin_px_ + pitch_px_ * (i + 0.5) / kParts));
  return sum / kParts;
}

double ReferencePattern::operator()(const Eigen::Vector2d& q_px, const Eigen::Vector2d& defocus_px) const {
  const double light = full_contrast(q_px, defocus_px);
  return contrast_ == 1.0 ? light : contrast_ * light + (1.0 - contrast_) * mean_;
}

// The harmonics where the light lands at this place of the projector's image.
Harmonics ReferencePattern::harmonics_at(const Eigen::Vector2d& q_px) const {
  const DirectionFringes& d = fringes_.directions[spec_.direction];
  Harmonics list = d.harmonics_of(spec_.pitch);
  const double u = 2.0 * (q_px.x() + 0.5) / projector_.lens.width() - 1.0,
               v = 2.0 * (q_px.y() + 0.5) / projector_.lens.height() - 1.0;
  std::size_t term = 0;
  for (unsigned order = 1; order <= 2; ++order)
    for (unsigned j = 0; j <= order; ++j, ++term) {
      if (term >= d.harmonics_field.size()) return list;
      const double size = std::legendre(order - j, u) * std::legendre(j, v);
      for (std::size_t i = 0; i < d.harmonics_field[term].size(); ++i) {
        if (i >= list.size()) list.emplace_back();
        list[i].cosine += size * d.harmonics_field[term][i].cosine;
        list[i].sine += size * d.harmonics_field[term][i].sine;
      }
    }
  return list;
}

// The light of a fringe that has all its contrast: that of each part of the point spread.
double ReferencePattern::full_contrast(const Eigen::Vector2d& q_px, const Eigen::Vector2d& defocus_px) const {
  const double x = (axis_ == Axis::x ? q_px.x() : q_px.y()) - shift_px_;
  const double radius = axis_ == Axis::x ? defocus_px.x() : defocus_px.y();
  const double sigma =
      projector_.has_blur_field() ? std::sqrt(projector_.blur_variance_px2(q_px)) : projector_.blur_px;
  static const Harmonics none;
  const DirectionFringes& d = fringes_.directions[spec_.direction];
  const bool varies = !spec_.is_gray() && !d.harmonics_field.empty();
  const Harmonics here = varies ? harmonics_at(q_px) : none;
  const Harmonics& list = spec_.is_gray() ? none : varies ? here : d.harmonics_of(spec_.pitch);
  double light = 0.0, rest = 1.0;
  for (const Halo& part : projector_.halo) {
    light += part.share * spread_light(list, x, radius, std::hypot(sigma, part.sigma_px), part.sigma_px);
    rest -= part.share;
  }
  return light + rest * spread_light(list, x, radius, sigma, 0.0);
}

// The light where a Gaussian of this sigma, which is wider than the blur by another of `further_px`, and a
// disk spread it.
double ReferencePattern::spread_light(const Harmonics& list, double x, double radius, double sigma,
                                      double further_px) const {
  if (projector_.pixel_structure) return sum_pieces(x, radius, 1.0, -0.5, sigma);
  if (!spec_.is_gray()) {
    const bool sine = fringes_.waveform.kind == Waveform::Kind::sine;
    return (!sine                         ? waveform(x, radius, sigma)
            : projector_.has_blur_field() ? convolve(x, sigma)
                                          : smooth(x, radius, further_px)) +
           harmonics(list, x, radius, sigma) + harmonics(of_image_, x, radius, sigma, 1) +
           raster(x, radius, sigma);
  }
  const DirectionFringes& d = fringes_.directions[spec_.direction];
  return sum_pieces(x, radius, 0.5 * pitch_px_,
                    origin_px_ + (d.gray ? d.gray->offset_periods : 0.0) * pitch_px_, sigma);
}

}  // namespace fringetwin::render
