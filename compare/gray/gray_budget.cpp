// SPDX-License-Identifier: Apache-2.0
#include "compare/gray/gray_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

using measure::CameraDecode;
using measure::DirectionDecode;

constexpr std::size_t kMaxPixels = 60'000;
constexpr int kOrders = 6;               // harmonics of the common periodic function
constexpr int kBasis = 1 + 2 * kOrders;  // 1, cos, sin of each order
constexpr double kNotable = 0.005;       // residual harmonic, of the gray level, that is worth a look
constexpr double kNamed = 0.02;  // harmonic over the first beyond the twin's: below it gain hardly suffers
constexpr double kLeastContrast = 0.25;  // of the twin's: with less of it the phases do not belong together

using Basis = Eigen::Matrix<double, kBasis, 1>;
using Normal = Eigen::Matrix<double, kBasis, kBasis>;

/// The usable gray values of one pixel.
struct Value {
  double residual;       ///< DN - prediction, after whatever was removed so far
  double predicted;      ///< gain * E, without the black level
  double theta_rad;      ///< phase of the projected fringe, for the harmonics
  double simulated_rad;  ///< the same as the simulated side has it
  double slope;          ///< d prediction / d projector coordinate, up to a factor per pixel
  int direction;
  double noise_dn2;  ///< predicted variance
};
struct Pixel {
  std::size_t place = 0;
  double noise_dn2 = 0.0;  ///< mean predicted variance of its gray values
  double scale = 1.0;      ///< albedo factor
  double level_dn = 0.0;   ///< mean of scale * predicted: local gray above black
  double gray_dn = 0.0;    ///< mean real gray value
  std::vector<Value> values;
};

/// Prefers the real phase for the harmonics (they follow the true projector coordinate) and the
/// simulated one for the slope of the prediction.
struct Phases {
  const CameraDecode *harmonics, *slope;
};

class GrayBudgetFit {
 public:
  GrayBudgetFit(const GrayPair& pair, const GainFit& fit, const Phases& phases, const GrayNoise& noise,
                const ShadingNoise& shading)
      : pair_(pair), fit_(fit), phases_(phases), noise_(noise), shading_(shading) {}

  GrayBudget run() {
    collect();
    if (pixels_.empty()) return budget_;
    for (const Pixel& p : pixels_) budget_.n += p.values.size();
    budget_.n_pixels = pixels_.size();
    const double n = static_cast<double>(budget_.n);
    double noise = 0.0;
    for (const Pixel& p : pixels_) noise += p.noise_dn2 * static_cast<double>(p.values.size());
    budget_.noise_dn2 = noise / n;
    budget_.total_dn2 = sum_of_squares() / n;

    const double after_gain = sum_of_squares(), shaded = predicted_shading();
    const double albedo_freedom = remove_albedo();
    const double after_albedo = sum_of_squares();
    remove_harmonics();
    const double after_harmonics = sum_of_squares();
    const double geometry_freedom = remove_geometry();
    const double left = sum_of_squares();

    budget_.albedo_dn2 = (after_gain - after_albedo - albedo_freedom) / n;
    budget_.shading_dn2 = std::clamp(shaded / n, 0.0, std::max(0.0, budget_.albedo_dn2));
    budget_.harmonics_dn2 = (after_albedo - after_harmonics) / n;
    budget_.higher_orders_dn2 = budget_.harmonics_dn2 - budget_.contrast_dn2;
    budget_.geometry_dn2 = (after_harmonics - left - geometry_freedom) / n;
    budget_.rest_dn2 = (left - (noise - albedo_freedom - geometry_freedom)) / n;
    fit_noise_line();
    return budget_;
  }

 private:
  /// Collects the values of a pixel; none when it has fewer than four usable values.
  Pixel collect_pixel(std::size_t i) const {
    Pixel pixel;
    pixel.place = i;
    const UsableRange& u = fit_.usable;
    for (int image : pair_.gain_images) {
      const PatternSpec& pattern = pair_.patterns[image];
      const ImageF *theta = wrapped_phase(*phases_.harmonics, pattern),
                   *slope = wrapped_phase(*phases_.slope, pattern);
      if (!theta || !slope || std::isnan(theta->data[i]) || std::isnan(slope->data[i])) continue;
      const double y = pair_.real_at(image, i), v = pair_.source_at(image, i),
                   e = pair_.irradiance_at(image, i);
      const double clip = u.gain_dn * e + u.black_level_dn;
      if (!is_usable(u, y, v, clip)) continue;
      const DirectionDecode& d = phases_.slope->directions[pattern.direction];
      const double step_rad = kTwoPi * pattern.step / steps_,
                   simulated_rad = static_cast<double>(slope->data[i]) + step_rad;
      const double predicted = fit_.row.gain_dn * e;
      pixel.values.push_back({y - predicted - fit_.row.black_level_dn, predicted,
                              static_cast<double>(theta->data[i]) + step_rad, simulated_rad,
                              std::sin(simulated_rad) / d.pitches_px[pattern.pitch], pattern.direction,
                              noise_.variance(predicted + fit_.row.black_level_dn)});
      pixel.gray_dn += y;
      pixel.noise_dn2 += pixel.values.back().noise_dn2;
    }
    if (pixel.values.size() < 4) pixel.values.clear();
    if (pixel.values.empty()) return pixel;
    pixel.gray_dn /= static_cast<double>(pixel.values.size());
    pixel.noise_dn2 /= static_cast<double>(pixel.values.size());
    return pixel;
  }

  void collect() {
    for (const PatternSpec& p : pair_.patterns) steps_ = std::max(steps_, p.step + 1);
    const std::vector<std::size_t> chosen = set_pixels(pair_.mask, kMaxPixels);
    std::vector<Pixel> found(chosen.size());
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < found.size(); ++k) found[k] = collect_pixel(chosen[k]);
    for (Pixel& pixel : found)
      if (!pixel.values.empty()) pixels_.push_back(std::move(pixel));
  }

  double sum_of_squares() const {
    double sum = 0.0;
    for (const Pixel& pixel : pixels_)
      for (const Value& v : pixel.values) sum += v.residual * v.residual;
    return sum;
  }

  /// Returns the sum of squares that a factor of gain E per pixel is to remove of what the noise of a
  /// measured shape's normals makes: of the projector's light alone, s gain (E - ambient).
  double predicted_shading() const {
    if (!shading_.at) return 0.0;
    const double room_dn = fit_.row.gain_dn * shading_.ambient;
    double sum = 0.0;
    for (const Pixel& pixel : pixels_) {
      double op = 0.0, pp = 0.0;
      for (const Value& v : pixel.values) {
        op += (v.predicted - room_dn) * v.predicted;
        pp += v.predicted * v.predicted;
      }
      if (pp > 0.0) sum += std::pow(shading_.at(pixel.place) * op, 2) / pp;
    }
    return sum;
  }

  /// Removes the least-squares factor of gain E per pixel. Returns the noise sum that this freedom removed.
  double remove_albedo() {
    double freedom = 0.0;
    std::vector<double> scales;
    for (Pixel& pixel : pixels_) {
      double rp = 0.0, pp = 0.0, p = 0.0, noise = 0.0;
      for (const Value& v : pixel.values) {
        rp += v.residual * v.predicted;
        pp += v.predicted * v.predicted;
        p += v.predicted;
        noise += v.predicted * v.predicted * v.noise_dn2;
      }
      if (!(pp > 0.0)) continue;
      const double extra = rp / pp;
      for (Value& v : pixel.values) v.residual -= extra * v.predicted;
      pixel.scale = 1.0 + extra;
      pixel.level_dn = pixel.scale * p / static_cast<double>(pixel.values.size());
      freedom += noise / pp;
      scales.push_back(pixel.scale);
    }
    budget_.albedo_sigma = robust_spread(std::move(scales));
    return freedom;
  }

  static double robust_spread(std::vector<double> v) {
    if (v.empty()) return kNaN;
    const double center = upper_median(v);
    for (double& x : v) x -= center;
    return mad_sigma(v);
  }

  static Basis basis(double theta_rad) {
    Basis f;
    f[0] = 1.0;
    const double c = std::cos(theta_rad), s = std::sin(theta_rad);
    double ck = 1.0, sk = 0.0;
    for (int k = 1; k <= kOrders; ++k) {
      const double next = ck * c - sk * s;
      sk = sk * c + ck * s;
      ck = next;
      f[2 * k - 1] = ck;
      f[2 * k] = sk;
    }
    return f;
  }

  /// Normal equations of value = level * h(theta), h of orders 0...kOrders.
  struct Periodic {
    Normal normal = Normal::Zero();
    Basis right = Basis::Zero();

    /// Returns h of orders 0...`orders`, the higher ones zero.
    Basis solve(int orders) const {
      const int used = 1 + 2 * orders;
      Eigen::MatrixXd m = normal.topLeftCorner(used, used);
      // a trace of damping: few steps with a constant phase leave orders that cannot be told apart
      m.diagonal().array() += 1e-9 * m.trace() / used;
      Basis h = Basis::Zero();
      h.head(used) = solve_symmetric(m, right.head(used));
      return h;
    }
    /// Returns by how much h lowers the sum of squares.
    double reduction(const Basis& h) const { return 2.0 * h.dot(right) - h.dot(normal * h); }
  };

  struct PeriodicValue {
    double level, theta_rad, value;
  };
  /// Sums what `take` makes of a pixel and its value, over fixed chunks of pixels, added up in order: the
  /// same for any number of threads.
  template <class Take>
  Periodic periodic_sums(Take take) const {
    constexpr std::size_t kChunks = 64;
    std::vector<Periodic> chunks(kChunks);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t c = 0; c < kChunks; ++c)
      for (std::size_t i = c * pixels_.size() / kChunks; i < (c + 1) * pixels_.size() / kChunks; ++i)
        for (const Value& v : pixels_[i].values) {
          const PeriodicValue taken = take(pixels_[i], v);
          const Basis f = taken.level * basis(taken.theta_rad);
          chunks[c].normal.selfadjointView<Eigen::Lower>().rankUpdate(f);
          chunks[c].right += taken.value * f;
        }
    Periodic sums;
    for (const Periodic& chunk : chunks) {
      sums.normal += chunk.normal;
      sums.right += chunk.right;
    }
    sums.normal = Normal(sums.normal.selfadjointView<Eigen::Lower>());
    return sums;
  }

  /// Names the largest harmonic that the real fringes have beyond the twin's, both along the simulated phase:
  /// N steps alias harmonics into the phase of the images themselves, and images out of order bend it.
  void name_harmonic() {
    const auto along = [this](auto value) {
      return periodic_sums([value](const Pixel& p, const Value& v) {
        return PeriodicValue{p.scale > 0.0 ? p.level_dn / p.scale : 0.0, v.simulated_rad, value(p, v)};
      });
    };
    const auto all_light = [](const Pixel& p, const Value& v) { return v.residual + p.scale * v.predicted; };
    const auto twins_light = [](const Pixel& /*p*/, const Value& v) { return v.predicted; };
    const Periodic real_sums = along(all_light);
    const Basis real = real_sums.solve(kOrders), twin = along(twins_light).solve(kOrders);
    const auto size = [](const Basis& h, int k) { return std::hypot(h[2 * k - 1], h[2 * k]); };
    const double first = size(real, 1), twins_first = size(twin, 1),
                 scatter_dn = std::sqrt(sum_of_squares() / static_cast<double>(budget_.n));
    if (!(first > kLeastContrast * twins_first)) return;
    double most = kNamed;
    for (int k = 2; k <= kOrders; ++k) {
      const double seen = size(real, k) / first, predicted = size(twin, k) / twins_first,
                   sigma = scatter_dn / std::sqrt(real_sums.normal(2 * k, 2 * k)) / first;
      if (!(seen - predicted - 3.0 * sigma > most)) continue;
      most = seen - predicted - 3.0 * sigma;
      static constexpr std::array kNames{"second", "third", "fourth", "fifth", "sixth"};
      static_assert(kNames.size() == kOrders - 1);
      budget_.waveform = fmt::format(
          "the fringes are no sinusoids: {} harmonic {:.2g} % of the first, {:.2g} % in the twin; run "
          "`fringetwin photometry`, its response fits",
          kNames[k - 2], 100.0 * seen, 100.0 * predicted);
    }
  }

  void remove_harmonics() {
    const Periodic sums = periodic_sums([](const Pixel& p, const Value& v) {
      return PeriodicValue{p.level_dn, v.theta_rad, v.residual};
    });
    const double n = static_cast<double>(budget_.n);
    const Basis h = sums.solve(kOrders);
    if (h.tail(kBasis - 3).cwiseAbs().maxCoeff() > kNotable) name_harmonic();
    budget_.contrast_dn2 = sums.reduction(sums.solve(1)) / n;
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < pixels_.size(); ++i)
      for (Value& v : pixels_[i].values) v.residual -= pixels_[i].level_dn * h.dot(basis(v.theta_rad));
    budget_.harmonic_amplitude.assign(1, std::abs(h[0]));
    for (int k = 1; k <= kOrders; ++k)
      budget_.harmonic_amplitude.push_back(std::hypot(h[2 * k - 1], h[2 * k]));
  }

  /// Removes one shift of the projector coordinate per pixel and direction. Returns the noise sum it removed.
  double remove_geometry() {
    double freedom = 0.0;
    for (Pixel& pixel : pixels_)
      for (int direction = 0; direction < 2; ++direction) {
        double rs = 0.0, ss = 0.0, noise = 0.0;
        for (const Value& v : pixel.values)
          if (v.direction == direction) {
            rs += v.residual * v.slope, ss += v.slope * v.slope;
            noise += v.slope * v.slope * v.noise_dn2;
          }
        if (!(ss > 0.0)) continue;
        for (Value& v : pixel.values)
          if (v.direction == direction) v.residual -= rs / ss * v.slope;
        freedom += noise / ss;
      }
    return freedom;
  }

  /// Fits the predicted noise on the gray level: offset and slope of photon transfer.
  void fit_noise_line() {
    double n = 0, x = 0, xx = 0, y = 0, xy = 0;
    for (const Pixel& p : pixels_) {
      const double v = noise_.variance(p.gray_dn);
      n += 1, x += p.gray_dn, xx += p.gray_dn * p.gray_dn, y += v, xy += p.gray_dn * v;
    }
    const double det = n * xx - x * x;
    budget_.noise_per_dn = det > 1e-9 * n * xx ? (n * xy - x * y) / det : 0.0;
    budget_.noise_offset_dn2 = (y - budget_.noise_per_dn * x) / n;
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  Phases phases_;
  const GrayNoise& noise_;
  const ShadingNoise& shading_;
  int steps_ = 1;
  std::vector<Pixel> pixels_;
  GrayBudget budget_;
};

}  // namespace

std::optional<GrayBudget> gray_budget(const GrayPair& pair, const GainFit& fit, const CameraDecode* real,
                                      const CameraDecode* simulated, const GrayNoise& noise,
                                      const ShadingNoise& shading) {
  const bool has_steps =
      std::ranges::any_of(pair.gain_images, [&](int i) { return !pair.patterns[i].is_gray(); });
  if (!has_steps || (!real && !simulated)) return std::nullopt;
  GrayBudget budget =
      GrayBudgetFit(pair, fit, {real ? real : simulated, simulated ? simulated : real}, noise, shading).run();
  if (budget.n == 0) return std::nullopt;
  budget.camera = pair.camera->name;
  budget.noise_source = noise.source();
  return budget;
}

}  // namespace fringetwin::compare
