// SPDX-License-Identifier: Apache-2.0
#include "calib/photometry/fringe_harmonics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"
#include "twin/number/sinc.hpp"

namespace fringetwin::calib {
namespace {

using Complex = std::complex<double>;
constexpr int kMaxOrder = 32;
constexpr std::size_t kMaxMedianSamples = 300000;

/// Computes the discrete Fourier transform over the N phase steps of one pixel, orders 0...N/2 (at most
/// kMaxOrder), from twiddle factors made once.
class Spectrum {
 public:
  explicit Spectrum(int n) : n_(n), orders_(std::min(n / 2, kMaxOrder)) {
    for (int h = 0; h <= orders_; ++h)
      for (int k = 0; k < n; ++k)
        twiddle_.push_back(std::polar(2.0 / n, -2.0 * std::numbers::pi * h * k / n));
  }
  int orders() const { return orders_; }
  bool is_nyquist(int h) const { return 2 * h == n_; }
  /// Returns 2/N sum_n I_n exp(-2 pi i h n/N) of the order h of a pixel.
  Complex at(const std::vector<const GrayImage*>& steps, std::size_t pixel, int h) const {
    Complex sum = 0.0;
    for (int k = 0; k < n_; ++k) sum += twiddle_[h * n_ + k] * static_cast<double>((*steps[k])[pixel]);
    return sum;
  }

 private:
  int n_, orders_;
  std::vector<Complex> twiddle_;
};

/// Holds sums over the pixels of one image block, for one pitch and order.
struct HarmonicCell {
  double in_phase = 0.0, quadrature = 0.0, weight = 0.0, camera = 0.0;
};

struct HarmonicSums {
  std::vector<std::array<HarmonicCell, kBlocks>> cells;  // [pitch * orders + h - 1]
  std::array<double, kBlocks> n{};
};

/// Returns whether pixel i is below saturation in all images.
bool unsaturated(const std::vector<std::vector<const GrayImage*>>& steps, std::size_t i,
                 double saturation_dn) {
  for (const auto& pitch : steps)
    for (const GrayImage* image : pitch)
      if (!(static_cast<double>((*image)[i]) < saturation_dn)) return false;
  return true;
}

/// Returns the ratio of a member's sum over all blocks to that of the weights, with its jackknife sigma.
Estimate ratio(const std::array<HarmonicCell, kBlocks>& cells, double HarmonicCell::*above) {
  double sum = 0.0, weight = 0.0;
  for (const HarmonicCell& c : cells) sum += c.*above, weight += c.weight;
  Estimate e;
  if (!(weight > 0.0)) return e;
  e.value = sum / weight;
  double spread = 0.0;
  int groups = 0;
  for (const HarmonicCell& c : cells) {
    if (!(c.weight > 0.0) || !(weight - c.weight > 0.0)) continue;
    spread += std::pow((sum - c.*above) / (weight - c.weight) - e.value, 2);
    ++groups;
  }
  if (groups > 1) e.sigma = std::sqrt(spread * (groups - 1.0) / groups);
  return e;
}

class Analysis {
 public:
  Analysis(const std::vector<std::vector<const GrayImage*>>& steps, const DirectionFringes& fringes,
           const HarmonicsOptions& options)
      : steps_(steps), fringes_(fringes), options_(options), spectrum_(static_cast<int>(steps[0].size())) {
    const auto& p = fringes.pitches_px;
    coarsest_ = static_cast<std::size_t>(std::ranges::max_element(p) - p.begin());
    finest_ = static_cast<std::size_t>(fringes.finest());
    for (std::size_t k = 0; k < p.size(); ++k) coarse_to_fine_.push_back(k);
    std::ranges::sort(coarse_to_fine_, [&](std::size_t a, std::size_t b) { return p[a] > p[b]; });
    first_ = steps[0][0];
    usable_ = ImageU8(first_->width, first_->height);
    fundamental_.assign(p.size(), std::vector<std::complex<float>>(first_->size()));
    find_usable();
  }

  FringeHarmonics result() {
    collect();
    FringeHarmonics out{.axis = fringes_.axis,
                        .steps = static_cast<int>(steps_[0].size()),
                        .reference = static_cast<int>(coarsest_)};
    for (const double n : sums_.n) out.n += static_cast<std::size_t>(n);
    if (out.n == 0) return out;
    const std::size_t every = std::max<std::size_t>(1, out.n / kMaxMedianSamples);
    for (std::size_t p = 0; p < steps_.size(); ++p) out.pitches.push_back(pitch(p, every));
    out.fundamental_dn = out.pitches[coarsest_].median_dn[0];
    std::vector<float> mean = values(coarsest_, 0, every);
    out.mean_dn = 0.5 * upper_median(mean);
    return out;
  }

 private:
  void find_usable() {
#pragma omp parallel for schedule(static)
    for (int y = 0; y < first_->height; ++y)
      for (int x = 0; x < first_->width; ++x) {
        const std::size_t i = first_->index(x, y);
        bool ok = unsaturated(steps_, i, options_.saturation_dn);
        for (std::size_t p = 0; ok && p < steps_.size(); ++p) {
          const Complex f = spectrum_.at(steps_[p], i, 1);
          fundamental_[p][i] = std::complex<float>(f);
          ok = std::abs(f) >= options_.min_modulation_dn;
        }
        usable_.data[i] = ok ? 1 : 0;
      }
  }

  /// Returns the phase difference from pixel a to b at the finest pitch, rad. Each pitch tells how many whole
  /// periods the next finer one has between the two (hierarchical unwrapping).
  double phase_step(std::size_t a, std::size_t b) const {
    double step = 0.0, pitch = 0.0;
    for (const std::size_t p : coarse_to_fine_) {
      const double seen = static_cast<double>(std::arg(fundamental_[p][b] * std::conj(fundamental_[p][a])));
      const double expected = pitch > 0.0 ? step * pitch / fringes_.pitches_px[p] : seen;
      step = expected + std::remainder(seen - expected, 2.0 * std::numbers::pi);
      pitch = fringes_.pitches_px[p];
    }
    return step;
  }

  /// Returns the phase gradient along x and y at the finest pitch, rad per camera pixel; 0 at the border of
  /// the usable pixels.
  std::array<double, 2> gradient(int x, int y) const {
    if (x < 1 || y < 1 || x + 1 >= first_->width || y + 1 >= first_->height) return {};
    const std::size_t left = first_->index(x - 1, y), right = first_->index(x + 1, y),
                      up = first_->index(x, y - 1), down = first_->index(x, y + 1), at = first_->index(x, y);
    for (const std::size_t i : {left, right, up, down})
      if (!usable_.data[i]) return {};
    return {0.5 * (phase_step(left, at) + phase_step(at, right)),
            0.5 * (phase_step(up, at) + phase_step(at, down))};
  }

  /// Returns the factor by which the camera's pixel area and lens blur lower order h of pitch p where the
  /// finest pitch has the phase gradient g.
  double camera_factor(const std::array<double, 2>& g, std::size_t p, int h) const {
    const double k = h * fringes_.pitches_px[finest_] / fringes_.pitches_px[p];
    const double half = 0.5 * options_.pixel_fill * k;
    const double psf = options_.psf_px * k;
    const double area = sinc(half * g[0]) * sinc(half * g[1]);
    return psf == 0.0 ? area : area * std::exp(-0.5 * psf * psf * (g[0] * g[0] + g[1] * g[1]));
  }

  /// Adds one pixel's harmonics to the sums. Each is turned back by h times the phase of its pitch's
  /// fundamental, so that the pixels' harmonics add up while their noise averages out.
  void add_pixel(int x, int y, HarmonicSums& sums) const {
    const std::size_t i = first_->index(x, y);
    const auto block = static_cast<std::size_t>(block_of(x, y, first_->width, first_->height));
    const double reference = static_cast<double>(std::abs(fundamental_[coarsest_][i]));
    const std::array<double, 2> g = gradient(x, y);
    sums.n[block] += 1.0;
    const auto orders = static_cast<std::size_t>(spectrum_.orders());
    for (std::size_t p = 0; p < steps_.size(); ++p) {
      const Complex f(fundamental_[p][i]);
      const Complex unit = f / std::abs(f);
      Complex turn = 1.0;
      for (std::size_t k = 0; k < orders; ++k) {
        const int h = static_cast<int>(k) + 1;
        turn *= std::conj(unit);
        const Complex value = h == 1 ? f : spectrum_.at(steps_[p], i, h);
        HarmonicCell& cell = sums.cells[p * orders + k][block];
        // N steps cannot tell the phase of order h = N/2: `value` is real, 2 a cos(h phase) for a harmonic a
        // that is in phase with the fundamental. Weighting by cos(h phase) gives a by least squares.
        const bool nyquist = spectrum_.is_nyquist(h);
        const double weight =
            nyquist ? reference * reference * turn.real() * turn.real() : reference * reference;
        const Complex locked = nyquist ? Complex(0.5 * value.real() * turn.real(), 0.0) : value * turn;
        cell.in_phase += locked.real() * reference;
        cell.quadrature += locked.imag() * reference;
        cell.weight += weight;
        cell.camera += weight * camera_factor(g, p, h);
      }
    }
  }

  /// Adds all usable pixels. Rows of blocks run in parallel: each block belongs to one thread, so the sums do
  /// not depend on their number.
  void collect() {
    sums_.cells.resize(steps_.size() * static_cast<std::size_t>(spectrum_.orders()));
    const int h = first_->height;
#pragma omp parallel for schedule(dynamic)
    for (int band = 0; band < kBlocksPerSide; ++band)
      for (int y = (band * h + kBlocksPerSide - 1) / kBlocksPerSide;
           y < ((band + 1) * h + kBlocksPerSide - 1) / kBlocksPerSide; ++y)
        for (int x = 0; x < first_->width; ++x)
          if (usable_(x, y)) add_pixel(x, y, sums_);
  }

  /// Returns the amount of order h at pitch p, DN, of every n-th usable pixel.
  std::vector<float> values(std::size_t p, int h, std::size_t every) const {
    std::vector<float> v;
    std::size_t count = 0;
    for (std::size_t i = 0; i < usable_.size(); ++i)
      if (usable_.data[i] && count++ % every == 0)
        v.push_back(static_cast<float>(std::abs(spectrum_.at(steps_[p], i, h))));
    return v;
  }

  /// Returns the harmonics at pitch p from the sums.
  PitchHarmonics pitch(std::size_t p, std::size_t every) const {
    PitchHarmonics out;
    out.pitch_px = fringes_.pitches_px[p];
    const auto orders = static_cast<std::size_t>(spectrum_.orders());
    for (std::size_t k = 0; k < orders; ++k) {
      std::vector<float> v = values(p, static_cast<int>(k) + 1, every);
      out.median_dn.push_back(upper_median(v));
      const auto& cells = sums_.cells[p * orders + k];
      out.amplitude.push_back(ratio(cells, &HarmonicCell::in_phase));
      out.quadrature.push_back(ratio(cells, &HarmonicCell::quadrature));
      out.camera_factor.push_back(ratio(cells, &HarmonicCell::camera).value);
    }
    return out;
  }

  const std::vector<std::vector<const GrayImage*>>& steps_;
  const DirectionFringes& fringes_;
  HarmonicsOptions options_;
  Spectrum spectrum_;
  std::size_t coarsest_ = 0, finest_ = 0;
  std::vector<std::size_t> coarse_to_fine_;
  const GrayImage* first_ = nullptr;
  ImageU8 usable_;
  std::vector<std::vector<std::complex<float>>> fundamental_;
  HarmonicSums sums_;
};

}  // namespace

FringeHarmonics fringe_harmonics(const std::vector<std::vector<const GrayImage*>>& steps,
                                 const DirectionFringes& fringes, const HarmonicsOptions& options) {
  FT_CHECK(!steps.empty() && steps.size() == fringes.pitches_px.size(), "one set of steps per pitch");
  for (const auto& pitch : steps) FT_CHECK(pitch.size() >= 3, "three steps or more");
  return Analysis(steps, fringes, options).result();
}

}  // namespace fringetwin::calib
