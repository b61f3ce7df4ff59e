// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "calib/photometry/photon_transfer.hpp"
#include "measure/decode/stripe_harmonics.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::calib {
namespace {

constexpr int kMaxSteps = 64;
// A gray value nearer to the ends of the range than this may have its noise cut off.
constexpr double kLowMarginDn = 2.0;
// Fringes weaker than this have no harmonics to speak of.
constexpr double kLeastAmplitudeDn = 4.0;
// As rough as the limit is where harmonics leave half a sigma: they are not known well enough.
constexpr double kRemainderRough = 2.0 * measure::kRoughSigmas;
double high_margin(double saturation_dn) { return saturation_dn - std::max(2.0, 0.01 * saturation_dn); }

/// Orthonormal rows that are orthogonal to the columns of `known` (Gram-Schmidt on the unit vectors).
std::vector<std::vector<double>> complement(std::vector<std::vector<double>> known, std::size_t n) {
  std::vector<std::vector<double>> basis, out;
  const auto add = [&](std::vector<double> v) {
    for (int pass = 0; pass < 2; ++pass)
      for (const auto& b : basis) {
        double dot = 0.0;
        for (std::size_t i = 0; i < n; ++i) dot += b[i] * v[i];
        for (std::size_t i = 0; i < n; ++i) v[i] -= dot * b[i];
      }
    double norm = 0.0;
    for (const double x : v) norm += x * x;
    if (norm < 1e-6) return false;
    for (double& x : v) x /= std::sqrt(norm);
    basis.push_back(std::move(v));
    return true;
  };
  for (auto& v : known) FT_CHECK(add(std::move(v)), "independent columns");
  for (std::size_t k = 0; k < n; ++k) {
    std::vector<double> unit(n, 0.0);
    unit[k] = 1.0;
    if (add(std::move(unit))) out.push_back(basis.back());
  }
  return out;
}

struct Line {
  double gain = 1.0, offset = 0.0;
};

/// y = gain * x + offset over the pixels marked.
Line fit_gain(const GrayImage& y, const ImageF& x, const std::vector<std::size_t>& pixels) {
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  const auto n = static_cast<double>(pixels.size());
  for (const std::size_t i : pixels) {
    const auto a = static_cast<double>(x.data[i]), b = static_cast<double>(y[i]);
    sx += a, sy += b, sxx += a * a, sxy += a * b;
  }
  const double spread = sxx - sx * sx / n;
  Line line;
  if (spread > n) line.gain = (sxy - sx * sy / n) / spread;  // a flat image tells an offset only
  line.offset = (sy - line.gain * sx) / n;
  return line;
}

void check_sizes(const std::vector<const GrayImage*>& images) {
  for (const GrayImage* image : images)
    if (!image->same_size(*images.front()))
      throw UserError(
          ExitCode::input, "photon transfer",
          fmt::format("images of {} x {} and {} x {} px are not repeats of each other", images.front()->width,
                      images.front()->height, image->width, image->height));
}

int stride_for(std::size_t available, std::size_t wanted) {
  return std::max(
      1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(available) /
                                              static_cast<double>(std::max<std::size_t>(wanted, 1))))));
}

}  // namespace

std::uint16_t block_of(int x, int y, int width, int height) {
  return static_cast<std::uint16_t>(y * kBlocksPerSide / height * kBlocksPerSide +
                                    x * kBlocksPerSide / width);
}

double add_repeat_noise(const std::vector<const GrayImage*>& repeats, double saturation_dn,
                        std::size_t max_samples, std::vector<NoiseSample>& samples) {
  const std::size_t n = repeats.size();
  FT_CHECK(n >= 2, "two images or more");
  check_sizes(repeats);
  const int w = repeats.front()->width, h = repeats.front()->height;
  ImageF mean(w, h);
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    double sum = 0.0;
    bool inside = true;
    for (const GrayImage* image : repeats) {
      const auto v = static_cast<double>((*image)[i]);
      inside = inside && v > 0.0 && v < saturation_dn;
      sum += v;
    }
    mean.data[i] = static_cast<float>(sum / static_cast<double>(n));
    const auto level = static_cast<double>(mean.data[i]);
    if (inside && level >= kLowMarginDn && level <= high_margin(saturation_dn)) usable.push_back(i);
  }
  if (usable.size() < 2) return 0.0;
  std::vector<Line> lines;
  double flicker = 0.0;
  for (const GrayImage* image : repeats) {
    lines.push_back(fit_gain(*image, mean, usable));
    flicker += std::pow(lines.back().gain - 1.0, 2);
  }
  const auto contrasts = complement({std::vector<double>(n, 1.0)}, n);
  const std::size_t step = std::max<std::size_t>(1, usable.size() * contrasts.size() / max_samples);
  for (std::size_t k = 0; k < usable.size(); k += step) {
    const std::size_t i = usable[k];
    std::vector<double> rest(n);
    for (std::size_t r = 0; r < n; ++r)
      rest[r] = static_cast<double>((*repeats[r])[i]) -
                (lines[r].gain * static_cast<double>(mean.data[i]) + lines[r].offset);
    const int x = static_cast<int>(i % static_cast<std::size_t>(w)),
              y = static_cast<int>(i / static_cast<std::size_t>(w));
    for (const auto& c : contrasts) {
      double e = 0.0;
      for (std::size_t r = 0; r < n; ++r) e += c[r] * rest[r];
      samples.push_back({mean.data[i], static_cast<float>(e), 0.0f, block_of(x, y, w, h),
                         static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
    }
  }
  return std::sqrt(flicker / static_cast<double>(n));
}

namespace {

/// Mean, cosine, sine and residual contrasts of one pixel, all in DN.
struct PixelFit {
  double mean = 0.0, c = 0.0, s = 0.0;
};

class StepNoise {
 public:
  StepNoise(const std::vector<const GrayImage*>& steps, const measure::StepSolver& solver,
            double saturation_dn)
      : steps_(steps), solver_(solver), saturation_dn_(saturation_dn), n_(steps.size()) {
    std::vector<double> ones(n_, 1.0), cosine(n_), sine(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      cosine[i] = solver.basis_cos(static_cast<int>(i));
      sine[i] = solver.basis_sin(static_cast<int>(i));
    }
    contrasts_ = complement({ones, cosine, sine}, n_);
  }
  std::size_t contrasts() const { return contrasts_.size(); }
  Eigen::MatrixXd columns() const {
    Eigen::MatrixXd out(n_, contrasts_.size());
    for (std::size_t j = 0; j < contrasts_.size(); ++j)
      out.col(static_cast<Eigen::Index>(j)) =
          Eigen::Map<const Eigen::VectorXd>(contrasts_[j].data(), static_cast<Eigen::Index>(n_));
    return out;
  }

  PixelFit fit(std::size_t i) const {
    PixelFit f;
    for (std::size_t k = 0; k < n_; ++k) {
      const auto v = static_cast<double>((*steps_[k])[i]);
      f.mean += static_cast<double>(solver_.mean_weights()[k]) * v;
      f.c += static_cast<double>(solver_.cos_weights()[k]) * v;
      f.s += static_cast<double>(solver_.sin_weights()[k]) * v;
    }
    return f;
  }
  /// No step clipped; `far`: pixels beside the triple, whose noise is not the triple's, say that none is
  /// nearly.
  bool usable(std::size_t i) const {
    for (const GrayImage* step : steps_) {
      const auto v = static_cast<double>((*step)[i]);
      if (!(v > 0.0) || !(v < saturation_dn_)) return false;
    }
    return true;
  }
  bool clear(std::size_t far) const {
    for (const GrayImage* step : steps_) {
      const auto v = static_cast<double>((*step)[far]);
      if (v < kLowMarginDn || v > high_margin(saturation_dn_)) return false;
    }
    return true;
  }
  /// A contrast of the second difference, scaled to the noise of one gray value, and the level of which that
  /// is the noise: of the steps themselves, since a projector's gamma makes light that is no sinusoid. The
  /// pixels weigh as in the second difference's variance: at edges, too.
  struct Sample {
    double noise = 0.0, level = 0.0;
  };
  void sample(std::size_t before, std::size_t at, std::size_t after, Sample* out) const {
    std::array<double, kMaxSteps> d{}, mean{};
    for (std::size_t k = 0; k < n_; ++k) {
      const GrayImage& v = *steps_[k];
      const auto a = static_cast<double>(v[before]), b = static_cast<double>(v[at]),
                 c = static_cast<double>(v[after]);
      d[k] = (a - 2.0 * b + c) / std::sqrt(6.0);
      mean[k] = (a + 4.0 * b + c) / 6.0;
    }
    for (std::size_t j = 0; j < contrasts_.size(); ++j) {
      out[j] = {};
      for (std::size_t k = 0; k < n_; ++k) {
        const double share = contrasts_[j][k];
        out[j].noise += share * d[k];
        out[j].level += share * share * mean[k];
      }
    }
  }

 private:
  const std::vector<const GrayImage*>& steps_;
  const measure::StepSolver& solver_;
  double saturation_dn_;
  std::size_t n_;
  std::vector<std::vector<double>> contrasts_;
};

/// What the fringe's harmonics leave in the second differences where the stripes lean.
class LeaningStripes {
 public:
  LeaningStripes(const std::vector<const GrayImage*>& steps, const StepNoise& noise, Axis axis, int stride)
      : amplitude_(steps.front()->width, steps.front()->height, 0.0f),
        phase_(steps.front()->width, steps.front()->height, std::numeric_limits<float>::quiet_NaN()),
        input_{steps, &phase_, &amplitude_} {
#pragma omp parallel for schedule(static)
    for (std::size_t i = 0; i < phase_.size(); ++i) {
      if (!noise.usable(i)) continue;
      const PixelFit f = noise.fit(i);
      amplitude_.data[i] = static_cast<float>(std::hypot(f.c, f.s));
      phase_.data[i] = static_cast<float>(std::atan2(f.s, f.c));
    }
    harmonics_.emplace(input_, noise.columns(), axis, stride, kLeastAmplitudeDn);
    if (!harmonics_->matter()) harmonics_.reset();
    none_ = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(noise.contrasts()));
  }
  LeaningStripes(const LeaningStripes&) = delete;
  LeaningStripes& operator=(const LeaningStripes&) = delete;

  /// Returns that of each contrast.
  Eigen::VectorXd remainder(int x, int y) const {
    const bool is_lit = static_cast<double>(amplitude_(x, y)) >= kLeastAmplitudeDn;
    return is_lit && harmonics_ ? harmonics_->remainder(x, y) : none_;
  }

 private:
  ImageF amplitude_, phase_;
  measure::NoiseInput input_;
  std::optional<measure::StripeHarmonics> harmonics_;  ///< none that matter: none
  Eigen::VectorXd none_;
};

}  // namespace

void add_step_noise(const std::vector<const GrayImage*>& steps, const measure::StepSolver& solver, Axis axis,
                    double saturation_dn, std::size_t max_samples, std::vector<NoiseSample>& samples) {
  if (steps.size() <= 3 || steps.size() > kMaxSteps) return;
  check_sizes(steps);
  const StepNoise noise(steps, solver, saturation_dn);
  const int w = steps.front()->width, h = steps.front()->height;
  // Column patterns vary along camera x (roughly), so the stripes run along camera y, and vice versa.
  const int dx = axis == Axis::x ? 0 : 1, dy = 1 - dx;
  const int stride = stride_for(steps.front()->size() * noise.contrasts() / 2, max_samples);
  const int rx = 2 * dx, ry = 2 * dy;
  // Neighbouring triples share pixels; every second one is nearly independent.
  const int step_x = stride * (1 + dx), step_y = stride * (1 + dy);
  const double mean_unit = std::sqrt(static_cast<double>(steps.size()) / 6.0),
               wave_unit = std::sqrt(static_cast<double>(steps.size()) / 12.0);
  std::array<StepNoise::Sample, kMaxSteps> sample{};
  const LeaningStripes stripes(steps, noise, axis, 2 * stride);
  for (int y = ry; y < h - ry; y += step_y)
    for (int x = rx; x < w - rx; x += step_x) {
      const std::size_t before = steps.front()->index(x - dx, y - dy), at = steps.front()->index(x, y),
                        after = steps.front()->index(x + dx, y + dy);
      if (!noise.usable(before) || !noise.usable(at) || !noise.usable(after) ||
          !noise.clear(steps.front()->index(x - rx, y - ry)) ||
          !noise.clear(steps.front()->index(x + rx, y + ry)))
        continue;
      const PixelFit a = noise.fit(before), b = noise.fit(at), c = noise.fit(after);
      const double roughness = std::max({mean_unit * std::abs(a.mean - 2.0 * b.mean + c.mean),
                                         wave_unit * std::abs(a.c - 2.0 * b.c + c.c),
                                         wave_unit * std::abs(a.s - 2.0 * b.s + c.s)});
      noise.sample(before, at, after, sample.data());
      const Eigen::VectorXd remainder = stripes.remainder(x, y);
      for (std::size_t j = 0; j < noise.contrasts(); ++j) {
        const double left = remainder[static_cast<Eigen::Index>(j)];
        samples.push_back({static_cast<float>(sample[j].level), static_cast<float>(sample[j].noise - left),
                           static_cast<float>(std::max(roughness, kRemainderRough * std::abs(left))),
                           block_of(x, y, w, h), static_cast<std::uint16_t>(x),
                           static_cast<std::uint16_t>(y)});
      }
    }
}

namespace {

/// Returns what scales a second difference of a weighted sum of steps to the noise of one gray value.
double unit_of(const std::vector<float>& weights) {
  double square = 0.0;
  for (const float w : weights) square += static_cast<double>(w) * static_cast<double>(w);
  return 1.0 / std::sqrt(6.0 * square);
}

double second_difference(double before, double at, double after) { return before - 2.0 * at + after; }

/// The same pixels of all pitches.
class MeanNoise {
 public:
  MeanNoise(const std::vector<std::vector<const GrayImage*>>& pitches, const measure::StepSolver& solver,
            double saturation_dn)
      : mean_unit_(unit_of(solver.mean_weights())),
        cos_unit_(unit_of(solver.cos_weights())),
        sin_unit_(unit_of(solver.sin_weights())) {
    for (const auto& steps : pitches) pitches_.emplace_back(steps, solver, saturation_dn);
    const std::size_t n = pitches.size();
    contrasts_ =
        n == 1 ? std::vector<std::vector<double>>{{1.0}} : complement({std::vector<double>(n, 1.0)}, n);
    second_.resize(n);
  }
  const std::vector<std::vector<double>>& contrasts() const { return contrasts_; }

  bool usable(std::size_t i) const {
    return std::ranges::all_of(pitches_, [i](const StepNoise& p) { return p.usable(i); });
  }
  bool clear(std::size_t i) const {
    return std::ranges::all_of(pitches_, [i](const StepNoise& p) { return p.clear(i); });
  }
  /// Looks at one triple of pixels: sets the level, the roughness and the second differences of the means.
  void look(std::size_t before, std::size_t at, std::size_t after) {
    level_ = roughness_ = 0.0;
    const auto n = static_cast<double>(pitches_.size());
    double together = 0.0;
    for (std::size_t p = 0; p < pitches_.size(); ++p) {
      const PixelFit a = pitches_[p].fit(before), b = pitches_[p].fit(at), c = pitches_[p].fit(after);
      second_[p] = second_difference(a.mean, b.mean, c.mean);
      together += second_[p];
      level_ += (a.mean + 4.0 * b.mean + c.mean) / (6.0 * n);
      roughness_ = std::max({roughness_, cos_unit_ * std::abs(second_difference(a.c, b.c, c.c)),
                             sin_unit_ * std::abs(second_difference(a.s, b.s, c.s))});
    }
    // of one pitch that is the noise itself
    if (pitches_.size() > 1)
      roughness_ = std::max(roughness_, mean_unit_ * std::abs(together) / std::sqrt(n));
  }
  double level() const { return level_; }
  double roughness() const { return roughness_; }
  double noise(const std::vector<double>& contrast) const {
    double e = 0.0;
    for (std::size_t p = 0; p < second_.size(); ++p) e += contrast[p] * second_[p];
    return mean_unit_ * e;
  }

 private:
  std::vector<StepNoise> pitches_;
  std::vector<std::vector<double>> contrasts_;
  std::vector<double> second_;
  double mean_unit_, cos_unit_, sin_unit_;
  double level_ = 0.0, roughness_ = 0.0;
};

}  // namespace

void add_mean_noise(const std::vector<std::vector<const GrayImage*>>& pitches,
                    const measure::StepSolver& solver, Axis axis, double saturation_dn,
                    std::size_t max_samples, std::vector<NoiseSample>& samples, const ImageU8* among) {
  if (pitches.empty() || pitches.front().empty()) return;
  for (const auto& steps : pitches) check_sizes(steps);
  MeanNoise noise(pitches, solver, saturation_dn);
  const GrayImage& size = *pitches.front().front();
  // as in add_step_noise(): along the stripes, every second triple
  const int dx = axis == Axis::x ? 0 : 1, dy = 1 - dx, rx = 2 * dx, ry = 2 * dy;
  const auto left_out = among ? std::ranges::count(among->data, 0) : 0;
  const int stride = stride_for(
      (size.size() - static_cast<std::size_t>(left_out)) * noise.contrasts().size() / 2, max_samples);
  for (int y = ry; y < size.height - ry; y += stride * (1 + dy))
    for (int x = rx; x < size.width - rx; x += stride * (1 + dx)) {
      const std::size_t before = size.index(x - dx, y - dy), at = size.index(x, y),
                        after = size.index(x + dx, y + dy);
      if (among && among->data[at] == 0) continue;
      if (!noise.usable(before) || !noise.usable(at) || !noise.usable(after) ||
          !noise.clear(size.index(x - rx, y - ry)) || !noise.clear(size.index(x + rx, y + ry)))
        continue;
      noise.look(before, at, after);
      for (const std::vector<double>& contrast : noise.contrasts())
        samples.push_back({static_cast<float>(noise.level()), static_cast<float>(noise.noise(contrast)),
                           static_cast<float>(noise.roughness()), block_of(x, y, size.width, size.height),
                           static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
    }
}

Saturation find_saturation(const std::vector<const GrayImage*>& images, int bit_depth) {
  std::vector<std::size_t> counts(std::size_t{1} << bit_depth, 0);
  std::size_t n = 0;
  for (const GrayImage* image : images)
    image->for_each([&](float v) {
      if (v >= 0.0f && static_cast<std::size_t>(v) < counts.size()) {
        ++counts[static_cast<std::size_t>(v)];
        ++n;
      }
    });
  std::size_t top = counts.size() - 1;
  while (top > 0 && counts[top] == 0) --top;
  std::size_t below = 0;
  const std::size_t levels = std::min<std::size_t>(8, top);
  for (std::size_t k = 1; k <= levels; ++k) below += counts[top - k];
  Saturation s{.reached = levels > 0 && counts[top] >= 20 && counts[top] * levels > 5 * below};
  s.level_dn = static_cast<double>(s.reached ? top : counts.size() - 1);
  s.fraction = s.reached ? static_cast<double>(counts[top]) / static_cast<double>(n) : 0.0;
  return s;
}

}  // namespace fringetwin::calib
