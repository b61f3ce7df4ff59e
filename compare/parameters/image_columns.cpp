// SPDX-License-Identifier: Apache-2.0
// Parameters of what the fringes of each image have of their own, where they lie and their waveform, and what
// a change of them does to gray values: as far as it needs no rendering, by the fringe that the pixel's other
// steps tell.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "compare/parameters/closed_columns.hpp"
#include "compare/parameters/harmonic_parts.hpp"
#include "compare/parameters/parameters.hpp"
#include "render/pattern/waveform.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kNoFringe = 1e-9;  ///< of full scale: a waveform without a first harmonic
constexpr double kExpected = 0.02;  ///< of full scale: a 25th of a whole fringe's swing

/// The first harmonic of one image in a pixel, from all steps of its pitch that are there. Its light is of
/// `cosine` R cos theta + `sine` R sin theta.
struct FringeOfImage {
  std::size_t at = 0;                  ///< of the image among the samples
  std::vector<StepImage> steps;        ///< of its pitch
  Eigen::RowVectorXd in_phase, ahead;  ///< weights of the steps: R cos and R sin of the fringe's phase
  double cosine = 0.0, sine = 0.0;     ///< of what is projected, fraction of full scale
};

/// Returns the projector's light in an image of the sequence over that of the twin.
double light_of(const Twin& twin, std::size_t camera, int image) {
  const auto i = static_cast<std::size_t>(image);
  return factor_of(twin.cameras[camera].exposure_factors, i) * factor_of(twin.projector->light_factors, i);
}

/// Returns the first harmonic of the light of an image: (cosine, sine), fraction of full scale. `of_all`:
/// that of the waveform of all images.
Eigen::Vector2d first_harmonic(const render::PhaseSeries& of_all, const Twin& twin, int image) {
  const Harmonics& own = twin.fringes.harmonics_of_image(static_cast<std::size_t>(image));
  const Harmonic first = own.empty() ? Harmonic{} : own.front();
  return {of_all.a[1] + first.cosine, of_all.sine(1) + first.sine};
}

/// Returns it where there are 3 steps or more, and any first harmonic. In an image of a pitch, whose step the
/// twin's own shifts leave at psi, the first harmonic is c R cos theta + s R sin theta, where c and s are
/// projected and R cos theta = A cos psi + B sin psi, R sin theta = A sin psi - B cos psi. E over the images
/// is m + A (c cos psi + s sin psi) + B (c sin psi - s cos psi), fitted: linear in the pixel's values.
std::optional<FringeOfImage> fringe_of(const Twin& twin, const GridSamples& s, int image) {
  const PatternSpec pattern = expand_sequence(twin.fringes)[static_cast<std::size_t>(image)];
  const double pitch_px = twin.fringes.directions[static_cast<std::size_t>(pattern.direction)]
                              .pitches_px[static_cast<std::size_t>(pattern.pitch)];
  FringeOfImage fringe;
  fringe.steps = steps_of_pitches(s, twin.fringes)[{pattern.direction, pattern.pitch}];
  const auto at = std::ranges::find(s.images, image);
  if (fringe.steps.size() < 3 || at == s.images.end()) return std::nullopt;
  fringe.at = static_cast<std::size_t>(at - s.images.begin());
  const auto shown_rad = [&](double step_rad, int of_image) {
    const double shift_px = twin.projector->image_shift_px(static_cast<std::size_t>(of_image));
    return step_rad - 2.0 * std::numbers::pi * shift_px / pitch_px;
  };
  const render::PhaseSeries of_all = render::fringe_series(twin.projector->response, twin.fringes, {}, 1);
  Eigen::MatrixXd design(fringe.steps.size(), 3);
  for (std::size_t q = 0; q < fringe.steps.size(); ++q) {
    const double of_step = shown_rad(fringe.steps[q].step_rad, s.images[fringe.steps[q].at]);
    const Eigen::Vector2d shown = first_harmonic(of_all, twin, s.images[fringe.steps[q].at]),
                          along(std::cos(of_step), std::sin(of_step));
    design.row(static_cast<Eigen::Index>(q)) << 1.0, shown.dot(along),
        shown[0] * along[1] - shown[1] * along[0];
  }
  if (!(design.rightCols(2).norm() > kNoFringe)) return std::nullopt;
  const Eigen::MatrixXd fitted =
      least_squares(design, Eigen::MatrixXd::Identity(design.rows(), design.rows()));
  const double psi = shown_rad(2.0 * std::numbers::pi * pattern.step / twin.fringes.steps, image);
  fringe.in_phase = std::cos(psi) * fitted.row(1) + std::sin(psi) * fitted.row(2);
  fringe.ahead = std::sin(psi) * fitted.row(1) - std::cos(psi) * fitted.row(2);
  const Eigen::Vector2d shown = first_harmonic(of_all, twin, image);
  fringe.cosine = shown[0], fringe.sine = shown[1];
  return fringe;
}

/// Adds `in_phase` times R cos theta and `ahead` times R sin theta to an image, of the projector's light as
/// bright as it is there.
void add_fringe(const std::optional<FringeOfImage>& fringe, double in_phase, double ahead,
                const EffectInput& in, std::vector<float>& irradiance) {
  if (!fringe) return;
  const GridSamples& s = in.samples;
  const std::size_t n = s.images.size();
  Eigen::RowVectorXd weights = in_phase * fringe->in_phase + ahead * fringe->ahead;
  const bool differs =
      !in.twin.projector->light_factors.empty() || !in.twin.cameras[s.camera].exposure_factors.empty();
  for (std::size_t q = 0; differs && q < fringe->steps.size(); ++q)
    weights[static_cast<Eigen::Index>(q)] *= light_of(in.twin, s.camera, s.images[fringe->at]) /
                                             light_of(in.twin, s.camera, s.images[fringe->steps[q].at]);
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < s.n_pixels(); ++p) {
    double change = 0.0;
    for (std::size_t q = 0; q < fringe->steps.size(); ++q) {
      const std::size_t at = fringe->steps[q].at;
      const auto light = static_cast<double>(in.before[p * n + at]);
      change += weights[static_cast<Eigen::Index>(q)] *
                (differs ? light - unprojected_light(in.twin, s, p, s.images[at]) : light);
    }
    float& value = irradiance[p * n + fringe->at];
    value = static_cast<float>(static_cast<double>(value) + change);
  }
}

const DirectionFringes& direction_of(const Twin& twin, const PatternSpec& pattern) {
  return twin.fringes.directions[static_cast<std::size_t>(pattern.direction)];
}

/// Lists the parameters of one group.
class ImageList : private GroupList {
 public:
  ImageList(const Twin& twin, std::string group, const std::vector<int>& compared)
      : GroupList(std::move(group)),
        twin_(twin),
        compared_(compared),
        patterns_(expand_sequence(twin.fringes)) {}

  /// The fringes of one image lie `value` projector pixels further: moved by the phase e, R cos theta becomes
  /// cos e R cos theta + sin e R sin theta.
  std::vector<Parameter> shifts() {
    for (const int image : compared_) {
      const PatternSpec& pattern = patterns_[static_cast<std::size_t>(image)];
      const double pitch_px =
          direction_of(twin_, pattern).pitches_px[static_cast<std::size_t>(pattern.pitch)];
      const double start_px = twin_.projector->image_shift_px(static_cast<std::size_t>(image));
      Parameter& p = add(fmt::format("image_{}.shift_px", image), "px", start_px, 0.03,
                         [image, pitch_px](const EffectInput& in, std::vector<float>& irradiance) {
                           const double moved = 2.0 * std::numbers::pi * (in.to - in.from) / pitch_px;
                           const std::optional<FringeOfImage> fringe = fringe_of(in.twin, in.samples, image);
                           if (!fringe) return;
                           const double c = fringe->cosine, s = fringe->sine, less = std::cos(moved) - 1.0,
                                        ahead = std::sin(moved);
                           add_fringe(fringe, c * less - s * ahead, s * less + c * ahead, in, irradiance);
                         });
      p.effect_of_sinusoids = true;
      if (twin_.projector->pixel_structure) {
        p.instead = "leave it out, or pixel_structure: the raster would stay, and twin.toml takes no shifts";
        continue;
      }
      change_images(p, image, [n = patterns_.size()](Twin& t, std::size_t of_image, double d) {
        t.projector->image_shifts_px.resize(n, 0.0);
        t.projector->image_shifts_px[of_image] += d;
      });
    }
    return std::move(list_);
  }

  /// What the fringes of an image have besides those of all: what these have in common is left to the group
  /// harmonics, where that is asked for. Of the first order only the part in phase: the other one is a shift.
  /// With a factor and an offset of each pixel waveforms of all images that together stand still in the image
  /// cannot be told; they are taken for none.
  std::vector<Parameter> harmonics() {
    const int most = std::min(kMostHarmonics, twin_.fringes.steps - 2);
    for (const int image : compared_)
      for (int k = 1; k <= most; ++k) {
        add_part(image, k, &Harmonic::cosine);
        if (k > 1) add_part(image, k, &Harmonic::sine);
      }
    return std::move(list_);
  }

 private:
  /// Lets a parameter that takes the fringes for sinusoids change one image of a twin, and gives it one that
  /// changes all compared images by as much: its rendering tells the derivatives in each.
  template <class ChangesImage>
  void change_images(Parameter& p, int image, const ChangesImage& changes) const {
    p.change = [=](Twin& t, double d) { changes(t, static_cast<std::size_t>(image), d); };
    p.only_image = image;
    if (!p.effect_of_sinusoids) return;
    const std::size_t of_what = p.name.find('.');
    Parameter all{
        .group = group_, .name = "all_images" + p.name.substr(of_what), .unit = p.unit, .step = p.step};
    all.change = [=, images = compared_](Twin& t, double d) {
      for (const int each : images) changes(t, static_cast<std::size_t>(each), d);
    };
    p.does_as = std::make_shared<Parameter>(std::move(all));
  }

  void add_part(int image, int order, double Harmonic::*part) {
    constexpr int kLowest = 1;  // of an image's own
    const auto at = static_cast<std::size_t>(image);
    Parameter& p = add(fmt::format("image_{}.harmonic.{}{}", image, order, name_of_part(part)), "",
                       harmonic_part(twin_.fringes.harmonics_of_image(at), order, part, kLowest), 1e-3,
                       order == 1 ? contrast_effect(image) : nullptr);
    p.effect_of_sinusoids = order == 1;
    change_images(p, image, [=, n = patterns_.size()](Twin& t, std::size_t of_image, double d) {
      t.fringes.image_harmonics.resize(n);
      add_to_part(t.fringes.image_harmonics[of_image], order, part, d, kLowest);
    });
    p.smallest = -1.0, p.largest = 1.0;  // as the file takes them
    p.expected = kExpected;
    if (order > 1) p.does_as = std::make_shared<Parameter>(harmonic_parameter(twin_, order, part));
  }

  /// The first harmonic of the light grows by `value` in one image.
  static std::function<void(const EffectInput&, std::vector<float>&)> contrast_effect(int image) {
    return [image](const EffectInput& in, std::vector<float>& irradiance) {
      add_fringe(fringe_of(in.twin, in.samples, image), in.to - in.from, 0.0, in, irradiance);
    };
  }

  const Twin& twin_;
  const std::vector<int>& compared_;
  std::vector<PatternSpec> patterns_;
};

}  // namespace

bool fringes_have_overtones(const Twin& twin) {
  const Fringes& fringes = twin.fringes;
  if (fringes.waveform.kind != Waveform::Kind::sine || !render::is_linear(twin.projector->response))
    return true;
  return std::ranges::any_of(fringes.directions, [&](const DirectionFringes& d) {
    return d.has_own_harmonics() || d.raster.has_any() ||
           std::ranges::any_of(fringes.more_harmonics(d), [](double size) { return size > 0.0; });
  });
}

std::vector<Parameter> image_shift_parameters(const Twin& twin, const std::vector<int>& compared) {
  if (!twin.projector) return {};
  return ImageList(twin, "image_shift", compared).shifts();
}

std::vector<Parameter> image_harmonics_parameters(const Twin& twin, const std::vector<int>& compared) {
  if (!twin.projector || twin.projector->pixel_structure || twin.fringes.steps < kStepsForHarmonics)
    return {};
  return ImageList(twin, "image_harmonics", compared).harmonics();
}

}  // namespace fringetwin::compare
