// SPDX-License-Identifier: Apache-2.0
#include "cosim/shape/known_light.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <utility>

#include "measure/decode/phase.hpp"
#include "render/pattern/raster_waves.hpp"
#include "render/pattern/waveform.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/number/sinc.hpp"

namespace fringetwin::cosim {
namespace {

using Complex = std::complex<double>;

/// Each is a tenth or so of the one before: what is taken out times its order, which its phase errs by.
constexpr int kPasses = 6;
/// Of a fringe that blur leaves nothing of.
constexpr double kLeastLeft = 1e-6;

/// One image of a pitch.
struct Step {
  GrayImage* image;
  float* values;  ///< of the image
  Complex step;   ///< e^(2 pi i n/N)
  Complex turn;   ///< the same where its fringes lie
  double light = 1.0, exposure = 1.0;
  std::vector<Complex> own = {};     ///< waves of the orders 1, 2 ... that it has besides
  std::vector<Complex> raster = {};  ///< of each wave of the raster: how it is turned in this image
};

/// Geometric means of the factors over all phase steps: what is in proportion stays as it is, so that images
/// of a code keep their place beside them.
struct MeanFactors {
  double light = 1.0, exposure = 1.0;
};
MeanFactors mean_factors(const Twin& twin, const Camera& camera) {
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  double light = 0.0, exposure = 0.0, n = 0.0;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (sequence[k].kind != PatternSpec::Kind::phase_step) continue;
    light += std::log(factor_of(twin.projector->light_factors, k));
    exposure += std::log(factor_of(camera.exposure_factors, k));
    n += 1.0;
  }
  return {std::exp(light / n), std::exp(exposure / n)};
}

/// Lifts clipped values, and where they begin, so far that no value does as they do when its light is taken
/// to the mean. Returns where they begin.
double lift_clipped(CameraImages& images, const Twin& twin, const Camera& camera) {
  constexpr double kMargin = 2.0;  // for what is taken out besides
  const double saturation_dn = images.saturation_dn();
  if (images.radiance) return saturation_dn;
  const MeanFactors means = mean_factors(twin, camera);
  double darkest = 1.0;
  for (std::size_t k = 0; k < images.images.size(); ++k)
    darkest = std::min(darkest, factor_of(camera.exposure_factors, k) / means.exposure *
                                    std::min(1.0, factor_of(twin.projector->light_factors, k) / means.light));
  const auto top = static_cast<float>(camera.sensor.black_level_dn +
                                      kMargin * (saturation_dn - camera.sensor.black_level_dn) / darkest);
  for (GrayImage& image : images.images)
    for (float& v : image.as_floats())
      if (static_cast<double>(v) >= saturation_dn) v = top;
  images.clip = Clip{static_cast<double>(top), images.clip ? images.clip->n : 0};
  return static_cast<double>(top);
}

/// Takes it out of the steps of one pitch.
class KnownPitch {
 public:
  KnownPitch(const Twin& twin, const Camera& camera, std::size_t direction, std::size_t pitch,
             const std::vector<int>& steps)
      : twin_(twin),
        camera_(camera),
        means_(mean_factors(twin, camera)),
        fringes_(twin.fringes.directions[direction]),
        pitch_px_(fringes_.pitches_px[pitch]),
        origin_px_(fringes_.phase_origin_px[pitch]),
        fringe_left_(std::max(left_of(1.0), kLeastLeft)),
        mean_(twin.fringes.mean / twin.fringes.amplitude / fringes_.contrast_of(pitch) / fringe_left_),
        solver_(steps, twin.fringes.steps),
        of_pitch_(waves(fringes_.harmonics_of(pitch), 2)) {
    for (const Harmonics& term : fringes_.harmonics_field) of_term_.push_back(waves(term, 2));
    for (std::size_t i = 0; i < fringes_.raster.waves.size(); ++i) {
      waves_.push_back(render::raster_wave(twin, fringes_, pitch, i));
      const double turns = waves_.back().turns;
      raster_.push_back(fringes_.raster.left_by_pixels(turns / pitch_px_) *
                        wave(fringes_.raster.waves[i], turns));
    }
  }

  /// Adds an image of the sequence.
  void add_image(GrayImage* image, int step, std::size_t at) {
    const double phase_rad = kTwoPi * step / twin_.fringes.steps,
                 moved_turns = twin_.projector->image_shift_px(at) / pitch_px_;
    images_.push_back({.image = image,
                       .values = image->as_floats().data(),
                       .step = std::polar(1.0, phase_rad),
                       .turn = std::polar(1.0, phase_rad - kTwoPi * moved_turns),
                       .light = factor_of(twin_.projector->light_factors, at) / means_.light,
                       .exposure = factor_of(camera_.exposure_factors, at) / means_.exposure,
                       .own = waves(twin_.fringes.harmonics_of_image(at), 1)});
    for (const render::RasterWave& w : waves_)
      images_.back().raster.push_back(std::polar(1.0, w.order * phase_rad - kTwoPi * w.turns * moved_turns));
  }

  void run(const std::vector<Eigen::Vector2f>& places_px, double black_dn, double clipped_dn) const {
    const int width = images_.front().image->width, height = images_.front().image->height;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        run_pixel(seen_at(places_px, x, y, width, height), black_dn, clipped_dn);
  }

 private:
  /// A pixel: the place that lights it, NaN where it is not known, and how it goes on along the fringes' axis
  /// from pixel to pixel.
  struct Seen {
    std::size_t pixel;
    Eigen::Vector2d place_px;
    double along_px, per_column_px, per_row_px;
    bool is_known() const { return std::isfinite(along_px + per_column_px + per_row_px); }
  };

  Seen seen_at(const std::vector<Eigen::Vector2f>& places_px, int x, int y, int width, int height) const {
    const int axis = fringes_.axis == Axis::x ? 0 : 1;
    const auto place = [&](int i, int j) -> const Eigen::Vector2f& {
      return places_px[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(i)];
    };
    const int left = std::max(x - 1, 0), right = std::min(x + 1, width - 1), up = std::max(y - 1, 0),
              down = std::min(y + 1, height - 1);
    const auto per = [&](const Eigen::Vector2f& from, const Eigen::Vector2f& to, int n) {
      return static_cast<double>(to[axis] - from[axis]) / std::max(n, 1);
    };
    const Eigen::Vector2d here = place(x, y).cast<double>();
    return {static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x), here,
            here[axis], per(place(left, y), place(right, y), right - left),
            per(place(x, up), place(x, down), down - up)};
  }

  /// Returns what blur and halo leave of a wave of so many turns per fringe.
  double left_of(double turns) const {
    const Projector& p = *twin_.projector;
    const double per_px = std::abs(turns) / pitch_px_;
    return render::blur_attenuation(1, p.blur_px, 1.0 / per_px) *
           (p.has_halo() ? p.halo_attenuation(per_px) : 1.0);
  }
  /// Returns what the pixel's square and the camera's blur leave of a wave of so many turns per fringe.
  double seen_of(double turns, const Seen& seen) const {
    if (!seen.is_known()) return 1.0;
    const double along = turns / pitch_px_ * seen.per_column_px, down = turns / pitch_px_ * seen.per_row_px,
                 blur = kTwoPi * camera_.psf_px;
    return sinc(0.5 * kTwoPi * along) * sinc(0.5 * kTwoPi * down) *
           std::exp(-0.5 * blur * blur * (along * along + down * down));
  }
  /// Returns a wave a cos t + b sin t, over the amplitude of the fringe, as conj(a + ib) of e^it.
  Complex wave(const Harmonic& h, double turns) const {
    return Complex(h.cosine, -h.sine) / twin_.fringes.amplitude * (left_of(turns) / fringe_left_);
  }
  /// Returns those of harmonics from the lowest order on.
  std::vector<Complex> waves(const Harmonics& list, int lowest) const {
    std::vector<Complex> out;
    for (std::size_t i = 0; i < list.size(); ++i)
      out.push_back(wave(list[i], static_cast<double>(i) + lowest));
    return out;
  }

  /// Returns the waves of the orders 2, 3 ... at a place.
  std::vector<Complex> harmonics_at(const Eigen::Vector2d& place_px) const {
    std::vector<Complex> here = of_pitch_;
    if (of_term_.empty() || !place_px.allFinite()) return here;
    const auto terms = twin_.projector->field_terms(place_px);
    for (std::size_t t = 0; t < of_term_.size(); ++t) {
      if (here.size() < of_term_[t].size()) here.resize(of_term_[t].size());
      for (std::size_t i = 0; i < of_term_[t].size(); ++i) here[i] += terms[t] * of_term_[t][i];
    }
    return here;
  }

  /// Returns the waves of the raster where the fringe has the phase e^it in the first step.
  void raster_at(Complex first, const Seen& seen, double of_fringe, std::vector<Complex>& out) const {
    if (!seen.is_known()) return;
    const double turns = std::arg(first) / kTwoPi, fringe = (seen.along_px - origin_px_) / pitch_px_,
                 fringes = turns + std::round(fringe - turns);  // from the origin to here
    for (std::size_t i = 0; i < waves_.size(); ++i)
      out[i] = raster_[i] * std::polar(seen_of(waves_[i].turns, seen) / of_fringe,
                                       kTwoPi * waves_[i].turns * fringes + waves_[i].ahead_rad);
  }

  void run_pixel(const Seen& seen, double black_dn, double clipped_dn) const {
    const std::size_t pixel = seen.pixel;
    const std::size_t n = images_.size();
    std::vector<double> value(n), added(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      const auto dn = static_cast<double>(images_[i].values[pixel]);
      if (!(dn < clipped_dn)) return;
      value[i] = (dn - black_dn) / images_[i].exposure;
    }
    const std::vector<Complex> of_all = harmonics_at(seen.place_px);
    std::vector<Complex> raster(waves_.size());
    std::vector<double> left(kHighestHarmonic, 1.0);
    const double of_fringe = std::max(seen_of(1.0, seen), kLeastLeft);
    for (std::size_t k = 1; k < left.size(); ++k)
      left[k] = seen_of(static_cast<double>(k) + 1.0, seen) / of_fringe;
    for (int pass = 0; pass < kPasses; ++pass) {
      const Complex fringe = solver_.fringe([&](std::size_t i) { return value[i] - added[i]; });
      const double amplitude = std::abs(fringe);
      if (!(amplitude > 0.0)) return;
      const Complex first = fringe / amplitude;
      raster_at(first, seen, of_fringe, raster);
      for (std::size_t i = 0; i < n; ++i)
        added[i] = amplitude * more_than_plain(images_[i], first, of_all, left, mean_ / of_fringe, raster);
    }
    for (std::size_t i = 0; i < n; ++i)
      images_[i].values[pixel] = static_cast<float>(black_dn + value[i] - added[i]);
  }

  /// Returns what a step has besides its cosine and the mean, over the amplitude. `left`: seen_of() of
  /// the orders 1, 2 ...
  double more_than_plain(const Step& step, Complex first, const std::vector<Complex>& of_all,
                         const std::vector<double>& left, double mean,
                         const std::vector<Complex>& raster) const {
    const Complex there = first * step.turn;
    double fringe = there.real();
    Complex power = there;
    const std::size_t n = std::max(of_all.size() + 1, step.own.size());
    for (std::size_t k = 0; k < n; ++k, power *= there) {  // of order k + 1
      if (k > 0 && k <= of_all.size()) fringe += left[k] * (of_all[k - 1] * power).real();
      if (k < step.own.size()) fringe += left[k] * (step.own[k] * power).real();
    }
    for (std::size_t i = 0; i < raster.size(); ++i) fringe += (raster[i] * step.raster[i]).real();
    return step.light * fringe - (first * step.step).real() + (step.light - 1.0) * mean;
  }

  const Twin& twin_;
  const Camera& camera_;
  MeanFactors means_;
  const DirectionFringes& fringes_;
  double pitch_px_, origin_px_;
  double fringe_left_;  ///< left_of() the fringe itself
  double mean_;         ///< of the projector's light, over the amplitude
  measure::StepSolver solver_;
  std::vector<Complex> of_pitch_;
  std::vector<std::vector<Complex>> of_term_;
  std::vector<render::RasterWave> waves_;
  std::vector<Complex> raster_;
  std::vector<Step> images_;
};

}  // namespace

bool knows_light(const Twin& twin, const Camera& camera) {
  if (!twin.projector || twin.fringes.steps == 0) return false;
  const Projector& p = *twin.projector;
  const bool is_plain = !p.optics && !p.has_blur_field() && p.ambient_factors.empty() &&
                        !twin.has_subsurface() && !camera.timing && camera.sensor.straight();
  return is_plain && render::is_linear(p.response) && !p.pixel_structure &&
         twin.fringes.waveform.kind == Waveform::Kind::sine &&
         (twin.fringes.has_harmonics() || twin.fringes.has_raster() || p.has_image_shifts() ||
          !p.light_factors.empty() || !camera.exposure_factors.empty());
}

CameraImages without_known_light(CameraImages images, const Twin& twin, const Camera& camera,
                                 const std::vector<Eigen::Vector2f>& places_px, std::vector<int> steps) {
  FT_CHECK(places_px.size() == images.images.at(0).size(), "a place of each pixel");
  const double clipped_dn = lift_clipped(images, twin, camera);
  if (steps.empty()) steps = measure::all_steps(twin.fringes.steps);
  const std::vector<PatternSpec> sequence = expand_sequence(twin.fringes);
  std::map<std::pair<int, int>, KnownPitch> pitches;
  for (const int step : steps)
    for (std::size_t k = 0; k < sequence.size(); ++k) {
      const PatternSpec& spec = sequence[k];
      if (spec.kind != PatternSpec::Kind::phase_step || spec.step != step) continue;
      const auto [at, is_new] = pitches.try_emplace(std::pair{spec.direction, spec.pitch}, twin, camera,
                                                    static_cast<std::size_t>(spec.direction),
                                                    static_cast<std::size_t>(spec.pitch), steps);
      at->second.add_image(&images.images.at(k), step, k);
    }
  for (const auto& [of, pitch] : pitches) pitch.run(places_px, camera.sensor.black_level_dn, clipped_dn);
  return images;
}

}  // namespace fringetwin::cosim
