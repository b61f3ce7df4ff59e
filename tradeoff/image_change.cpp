// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/image_change.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::tradeoff {
namespace {

using std::numbers::pi;

/// Returns amplitude * exp(i phase) from a full set of N phase steps, whose values from `first` on are
/// mean + amplitude cos(phase + 2 pi n/N).
std::complex<double> fringe(const std::vector<double>& values, std::size_t first, int steps) {
  std::complex<double> sum = 0.0;
  for (int n = 0; n < steps; ++n)
    sum += values[first + static_cast<std::size_t>(n)] * std::polar(2.0 / steps, -2.0 * pi * n / steps);
  return sum;
}

}  // namespace

namespace {

template <class AnyImage>
PixelValues taken(const std::vector<AnyImage>& images, const std::vector<SubsetPixel>& pixels, double scale,
                  double offset) {
  PixelValues out(pixels.size(), std::vector<double>(images.size()));
  for (std::size_t p = 0; p < pixels.size(); ++p)
    for (std::size_t i = 0; i < images.size(); ++i)
      out[p][i] = scale * static_cast<double>(images[i](pixels[p].x, pixels[p].y)) + offset;
  return out;
}

}  // namespace

PixelValues take_pixels(const std::vector<ImageF>& images, const std::vector<SubsetPixel>& pixels,
                        double scale, double offset) {
  return taken(images, pixels, scale, offset);
}

PixelValues take_pixels(const std::vector<GrayImage>& images, const std::vector<SubsetPixel>& pixels) {
  return taken(images, pixels, 1.0, 0.0);
}

void ChangeSum::MeanSquare::add(double value, double w) {
  sum += w * value * value;
  weight += w;
  ++n;
}

double ChangeSum::MeanSquare::rms() const { return n == 0 ? kNaN : std::sqrt(sum / weight); }

ChangeSum::ChangeSum(const Fringes& fringes, double min_modulation_dn)
    : min_modulation_dn_(min_modulation_dn) {
  const auto sequence = expand_sequence(fringes);
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const PatternSpec& s = sequence[i];
    if (s.is_gray() || s.step != 0) continue;
    if (s.pitch == fringes.directions[s.direction].finest()) groups_.push_back({i, fringes.steps});
  }
}

void ChangeSum::add(const std::vector<SubsetPixel>& pixels, const PixelValues& a, const PixelValues& b,
                    const std::vector<bool>* interior) {
  FT_CHECK(a.size() == pixels.size() && b.size() == pixels.size(), "both sides have the subset's pixels");
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double w = pixels[p].weight;
    const bool inside = interior ? (*interior)[p] : !pixels[p].edge;
    n_interior_ += inside;
    ++n_gray_;
    for (std::size_t i = 0; i < a[p].size(); ++i) {
      const double d = a[p][i] - b[p][i];
      gray_.add(d, w);
      (inside ? gray_interior_ : gray_edge_).add(d, w);
    }
    bool has_phase = false;
    for (const Group& g : groups_) {
      const auto fa = fringe(a[p], g.first_image, g.steps), fb = fringe(b[p], g.first_image, g.steps);
      if (std::abs(fa) < min_modulation_dn_ || std::abs(fb) < min_modulation_dn_) continue;
      const double d = std::arg(fa * std::conj(fb));
      has_phase = true;
      phase_.add(d, w);
      if (inside) phase_interior_.add(d, w);
    }
    n_phase_ += has_phase;
  }
}

ImageChange ChangeSum::result() const {
  return {phase_.rms(),     phase_interior_.rms(),
          gray_.rms(),      gray_interior_.rms(),
          gray_edge_.rms(), n_phase_,
          n_gray_,          n_interior_};
}

}  // namespace fringetwin::tradeoff
