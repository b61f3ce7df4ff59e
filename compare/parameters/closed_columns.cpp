// SPDX-License-Identifier: Apache-2.0
#include "compare/parameters/closed_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>

#include "compare/parameters/camera_curves.hpp"
#include "compare/parameters/parameters_geometry.hpp"
#include "render/pattern/camera_effects.hpp"
#include "render/pattern/projector_places.hpp"
#include "twin/lens/linear.hpp"

namespace fringetwin::compare {
namespace {

using Eigen::Vector2d;
using Effect = std::function<void(const EffectInput&, std::vector<float>&)>;

constexpr double kMostBlurPx = 10.0;  ///< its sums take 100 sigma^2 of the pixels around each
constexpr double kMostField = 1.0;    ///< that a term of the light field moves by: e times the light
constexpr int kRoomPoints = 9;        ///< per pixel, as residuals have

/// Calls f(pixel, its values in the order of the samples' images) for all pixels.
template <class Function>
void for_pixels(const GridSamples& s, std::vector<float>& irradiance, const Function& f) {
  const std::size_t n = s.images.size();
#pragma omp parallel for schedule(static)
  for (std::size_t p = 0; p < s.n_pixels(); ++p) f(p, std::span(irradiance).subspan(p * n, n));
}

void scale(float& value, double factor) { value = static_cast<float>(factor * static_cast<double>(value)); }
void shift(float& value, double by) { value = static_cast<float>(static_cast<double>(value) + by); }

/// Returns the pixel of the camera that a sample stands for.
Vector2d place_px(const GridSamples& s, std::size_t pixel) {
  const auto width = static_cast<std::size_t>(s.grid.width);
  return Vector2d(s.grid.first_x, s.grid.first_y) +
         s.grid.stride *
             Vector2d(static_cast<double>(s.cell[pixel] % width), static_cast<double>(s.cell[pixel] / width));
}

/// Scales what a value has over a constant.
void scale_over(float& value, double factor, double constant) {
  if (constant == 0.0)
    scale(value, factor);
  else
    shift(value, (factor - 1.0) * (static_cast<double>(value) - constant));
}

/// Returns where a pixel's texture stands in its camera's.
std::size_t texture_pixel(const Camera& camera, const GridSamples& s, std::size_t pixel) {
  const Eigen::Vector2i at = place_px(s, pixel).cast<int>();
  return static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(camera.lens.width()) +
         static_cast<std::size_t>(at.x());
}

/// Returns what the offset of the pixel's texture is in an image of the sequence; 0 without.
double texture_offset(const Twin& twin, const GridSamples& s, std::size_t pixel, int image) {
  const Camera& camera = twin.cameras[s.camera];
  if (!camera.texture) return 0.0;
  return factor_of(camera.exposure_factors, static_cast<std::size_t>(image)) *
         camera.texture->offset_at(texture_pixel(camera, s, pixel));
}

/// The projector's light is brighter in one image, and as much darker in the first one of all: the values are
/// ln of brightness over the geometric mean, so that those of several images add up. Ambient light stays.
Effect light_effect(int image, int first) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const std::vector<int>& images = in.samples.images;
    for_pixels(in.samples, irradiance, [&](std::size_t pixel, std::span<float> values) {
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (images[k] != image && images[k] != first) continue;
        const double factor = std::exp(images[k] == image ? in.to - in.from : in.from - in.to),
                     constant = unprojected_light(in.twin, in.samples, pixel, images[k]);
        scale_over(values[k], factor, constant);
      }
    });
  };
}

/// The same of all light of a camera: its exposure is longer in one image, and as much shorter in the first.
Effect exposure_effect(int image, int first) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const std::vector<int>& images = in.samples.images;
    const double longer = std::exp(in.to - in.from);
    for_pixels(in.samples, irradiance, [&](std::size_t, std::span<float> values) {
      for (std::size_t k = 0; k < values.size(); ++k)
        if (images[k] == image || images[k] == first)
          scale(values[k], images[k] == image ? longer : 1.0 / longer);
    });
  };
}

/// Does the same to the factors of a sequence of so many images.
void change_factors(std::vector<double>& factors, int image, int first, std::size_t n_images, double by) {
  if (factors.empty()) factors.assign(n_images, 1.0);
  factors.at(static_cast<std::size_t>(image)) *= std::exp(by);
  factors.at(static_cast<std::size_t>(first)) *= std::exp(-by);
}

/// Gray values grow by a polynomial's term over the image: x from -1 to 1 across it, y in the same unit.
Effect room_light_effect(int power_x, int power_y, Vector2d size_px) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    for_pixels(in.samples, irradiance, [&](std::size_t pixel, std::span<float> values) {
      const Vector2d at = (2.0 * place_px(in.samples, pixel) - size_px) / size_px.x();
      const double dn = (in.to - in.from) * std::pow(at.x(), power_x) * std::pow(at.y(), power_y);
      for (float& value : values) shift(value, dn / in.samples.gain_dn);
    });
  };
}

/// The projector's light is multiplied by exp(value P_i(a) P_j(b)), Legendre's polynomials of its
/// coordinates, -1 to 1 from border to border.
Effect field_effect(LegendreOrders order, Vector2d size_px) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    if (in.samples.projector_px.empty()) return;
    for_pixels(in.samples, irradiance, [&](std::size_t pixel, std::span<float> values) {
      const Eigen::Array2d at =
          (in.samples.projector_px[pixel].cast<double>().array() + 0.5) / size_px.array() * 2.0 - 1.0;
      const Eigen::Array2d inside = at.max(-1.0).min(1.0);
      const double term = std::legendre(order[0], inside.x()) * std::legendre(order[1], inside.y());
      const double factor = std::exp((in.to - in.from) * term);
      for (std::size_t k = 0; k < values.size(); ++k)
        scale_over(values[k], factor, unprojected_light(in.twin, in.samples, pixel, in.samples.images[k]));
    });
  };
}

/// Returns sum over the kernel of one pixel of an image; its part inside the image is scaled to unit sum.
double blurred_at(const GrayImage& image, int x, int y, const std::vector<double>& kernel) {
  const int reach = static_cast<int>(kernel.size()) - 1;
  double sum = 0.0, weights = 0.0;
  for (int v = std::max(0, y - reach); v <= std::min(image.height - 1, y + reach); ++v)
    for (int u = std::max(0, x - reach); u <= std::min(image.width - 1, x + reach); ++u) {
      const double w = kernel[static_cast<std::size_t>(std::abs(u - x))] *
                       kernel[static_cast<std::size_t>(std::abs(v - y))];
      sum += w * static_cast<double>(image(u, v));
      weights += w;
    }
  return sum / weights;
}

/// An object moves along one of its degrees of freedom at constant speed while the n images are taken, by
/// `value` from the first to the last, about its place in the twin. The pose's derivatives say what that
/// does.
Effect motion_effect(std::size_t pose_parameter, std::size_t n_images) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const GridSamples& s = in.samples;
    if (!s.pose_slopes || pose_parameter >= s.pose_slopes->size()) return;
    const std::vector<float>& slope = (*s.pose_slopes)[pose_parameter];
    std::vector<double> moved;  // by when the image is taken
    for (const int image : s.images)
      moved.push_back((in.to - in.from) * (image / static_cast<double>(n_images - 1) - 0.5));
    for (std::size_t i = 0; i < irradiance.size(); ++i)
      shift(irradiance[i], moved[i % moved.size()] * static_cast<double>(slope[i]));
  };
}

/// The camera's image is blurred by a Gaussian of variance value - start besides, px of the sensor, of whose
/// area a pixel of the image is `image_px2`: what that changes in the twin's own whole images is added.
Effect camera_psf_effect(double start, double image_px2) {
  return [=](const EffectInput& in, std::vector<float>& irradiance) {
    const GridSamples& s = in.samples;
    if (!s.frame) return;
    const auto kernel_of = [&](double variance) {
      return variance > start ? render::psf_kernel(std::sqrt(image_px2 * (variance - start)))
                              : std::vector<double>{1.0};
    };
    const std::vector<double> now = kernel_of(in.to), then = kernel_of(in.from);
    const std::size_t n = s.images.size();
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < n; ++k) {  // image by image: the rows of one stay in the cache
      const GrayImage& image = s.frame->images[static_cast<std::size_t>(s.images[k])];
      for (std::size_t p = 0; p < s.n_pixels(); ++p) {
        const Eigen::Vector2i at = place_px(s, p).cast<int>();
        shift(irradiance[p * n + k],
              blurred_at(image, at.x(), at.y(), now) - blurred_at(image, at.x(), at.y(), then));
      }
    }
  };
}

Vector2d size_px(const Lens& lens) { return {lens.width(), lens.height()}; }

/// Lists the parameters of one group.
class ClosedList : private GroupList {
 public:
  ClosedList(const Twin& twin, std::string group, const std::vector<int>& use_steps)
      : GroupList(std::move(group)),
        twin_(twin),
        use_steps_(use_steps),
        patterns_(expand_sequence(twin.fringes)) {}

  std::vector<Parameter> run() {
    if (group_ == "light") add_light();
    if (group_ == "projector_field") add_field();
    if (group_ == "image_shift") add_all(image_shift_parameters(twin_, compared_images()));
    if (group_ == "image_harmonics") add_all(image_harmonics_parameters(twin_, compared_images()));
    if (group_ == "raster") add_all(raster_parameters(twin_));
    if (group_ == "motion") add_motion();
    for (std::size_t c = 0; c < twin_.cameras.size(); ++c) {
      const std::size_t first = list_.size();
      if (group_ == "exposure") add_exposure(c);
      if (group_ == "timing" && twin_.projector) add_all(timing_parameters(twin_, c, compared_images()));
      if (group_ == "room_light") add_room_light(twin_.cameras[c]);
      if (group_ == "camera_response") add_all(response_parameters(twin_.cameras[c]));
      if (group_ == "camera_knee") add_all(knee_parameters(twin_, c));
      if (group_ == "camera_psf") add_psf(twin_.cameras[c]);
      for (std::size_t k = first; k < list_.size(); ++k) list_[k].camera = c;
    }
    return std::move(list_);
  }

 private:
  std::vector<int> phase_steps() const {
    std::vector<int> images;
    for (std::size_t k = 0; k < patterns_.size(); ++k)
      if (patterns_[k].kind == PatternSpec::Kind::phase_step) images.push_back(static_cast<int>(k));
    return images;
  }

  /// Returns the images of the steps that are compared: the others say nothing of their light.
  std::vector<int> compared_images() const {
    std::vector<int> images = phase_steps();
    std::erase_if(images, [this](int image) {
      return !use_steps_.empty() &&
             std::ranges::find(use_steps_, patterns_[static_cast<std::size_t>(image)].step) ==
                 use_steps_.end();
    });
    return images;
  }

  /// Adds ln of a factor over the geometric mean for all of these images but the first, which has minus the
  /// sum of the others.
  void add_factors(const std::string& of, const std::string& what, const std::vector<double>& factors,
                   Effect (*effect)(int image, int first),
                   const std::function<std::vector<double>&(Twin&)>& of_twin) {
    const std::vector<int> images = compared_images();
    const auto log_factor = [&](int image) {
      return std::log(factor_of(factors, static_cast<std::size_t>(image)));
    };
    double mean = 0.0;
    for (const int image : images) mean += log_factor(image) / static_cast<double>(images.size());
    for (std::size_t k = 1; k < images.size(); ++k) {
      const int image = images[k], first = images[0];
      Parameter& p = add(fmt::format("{}image_{}.{}", of, image, what), "", log_factor(image) - mean, 3e-3,
                         effect(image, first));
      p.change = [image, first, of_twin, n = patterns_.size()](Twin& t, double d) {
        change_factors(of_twin(t), image, first, n, d);
      };
      // the room's light is no factor's, and another lamp, albedo or pose changes it; an exposure that
      // reaches into another pattern sees that one's light, too
      p.is_closed = !twin_.room.has_lamp() && !sees_other_patterns(twin_);
    }
  }

  void add_light() {
    if (twin_.projector)
      add_factors("", "light", twin_.projector->light_factors, light_effect,
                  [](Twin& t) -> std::vector<double>& { return t.projector->light_factors; });
  }

  void add_exposure(std::size_t camera) {
    add_factors(twin_.cameras[camera].name + ".", "exposure", twin_.cameras[camera].exposure_factors,
                exposure_effect,
                [camera](Twin& t) -> std::vector<double>& { return t.cameras[camera].exposure_factors; });
  }

  /// As far as two terms of the second order, with the black level as the constant.
  void add_room_light(const Camera& camera) {
    const std::pair<int, int> powers[] = {{1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    const char* names[] = {"x", "y", "xx", "xy", "yy"};
    for (int i = 0; i < 5; ++i)
      add(fmt::format("{}.room_light.{}", camera.name, names[i]), "DN", 0.0,
          1e-3 * (camera.sensor.max_dn() - camera.sensor.black_level_dn),
          room_light_effect(powers[i].first, powers[i].second, size_px(camera.lens)));
  }

  void add_all(std::vector<Parameter> parameters) {
    std::ranges::move(parameters, std::back_inserter(list_));
  }

  void add_field() {
    if (!twin_.projector) return;
    for (std::size_t k = 0; k < kLightFieldTerms.size(); ++k) {
      const LegendreOrders& order = kLightFieldTerms[k];
      Parameter& p = add(fmt::format("projector.light_field.{}_{}", order[0], order[1]), "",
                         twin_.projector->light_field_term(k), 0.01,
                         field_effect(order, size_px(twin_.projector->lens)));
      p.change = [k](Twin& t, double d) {
        std::vector<double>& field = t.projector->light_field;
        field.resize(kLightFieldTerms.size());
        field[k] += d;
      };
      // light that comes over another surface has passed another place of the projector's image
      p.is_closed = twin_.render.bounces == 0 && !twin_.room.has_lamp();
      p.largest = p.start + kMostField, p.smallest = p.start - kMostField;
    }
  }

  /// Of all degrees of freedom that the group pose has, in its order.
  void add_motion() {
    if (!twin_.projector || patterns_.size() < 2) return;
    list_ = motion_parameters(twin_);
    for (std::size_t k = 0; k < list_.size(); ++k) {
      list_[k].change = {};
      list_[k].effect = motion_effect(k, patterns_.size());
    }
  }

  void add_psf(const Camera& camera) {
    const double start = camera.psf_px * camera.psf_px, side_px = camera.pixel_side_px();
    Parameter& p =
        add(camera.name + ".psf_px", "px", start, 0.02, camera_psf_effect(start, side_px * side_px));
    p.is_variance = true;
    p.smallest = start;
    p.largest = start + kMostBlurPx * kMostBlurPx;
  }

  const Twin& twin_;
  const std::vector<int>& use_steps_;
  std::vector<PatternSpec> patterns_;
};

}  // namespace

double unprojected_light(const Twin& twin, const GridSamples& samples, std::size_t pixel, int image) {
  const Camera& camera = twin.cameras[samples.camera];
  const Projector& projector = *twin.projector;
  const double offset = texture_offset(twin, samples, pixel, image);
  if (!(projector.ambient > 0.0) && samples.room_light.empty()) return offset;
  const Vector2d at = place_px(samples, pixel);
  const auto i = static_cast<std::size_t>(image);
  const double room =
      samples.room_light.empty() ? projector.ambient : static_cast<double>(samples.room_light[pixel]);
  const double ambient = room * render::vignetting_factor(camera, at.x(), at.y()) *
                         factor_of(projector.ambient_factors, i) * factor_of(camera.exposure_factors, i);
  return camera.texture ? camera.texture->factor_at(texture_pixel(camera, samples, pixel)) * ambient + offset
                        : ambient;
}

bool sees_other_patterns(const Twin& twin) {
  return std::ranges::any_of(twin.cameras, [](const Camera& camera) { return camera.timing.has_value(); });
}

std::vector<Parameter> closed_parameters(const Twin& twin, const std::string& group,
                                         const std::vector<int>& use_steps) {
  return ClosedList(twin, group, use_steps).run();
}

Effect vignetting_effect(std::size_t camera, std::function<void(Twin&, double)> change) {
  return [camera, change = std::move(change)](const EffectInput& in, std::vector<float>& irradiance) {
    Twin changed = in.twin;
    change(changed, in.to - in.from);
    for_pixels(in.samples, irradiance, [&](std::size_t pixel, std::span<float> values) {
      const Vector2d at = place_px(in.samples, pixel);
      const double factor = render::vignetting_factor(changed.cameras[camera], at.x(), at.y()) /
                            render::vignetting_factor(in.twin.cameras[camera], at.x(), at.y());
      for (std::size_t k = 0; k < values.size(); ++k)
        scale_over(values[k], factor, texture_offset(in.twin, in.samples, pixel, in.samples.images[k]));
    });
  };
}

Effect factor_effect() {
  return [](const EffectInput& in, std::vector<float>& irradiance) {
    for (float& value : irradiance) scale(value, in.to / in.from);
  };
}

void find_room_light(render::Renderer& renderer, const Twin& twin, std::vector<GridSamples>& samples) {
  if (!twin.projector || !twin.room.has_lamp()) return;
  constexpr double kAsGoodAsDark = 1e-30;
  Twin view = twin;
  view.projector->intensity = kAsGoodAsDark;
  view.projector->ambient_factors.clear(), view.projector->light_factors.clear();
  view.render.bounces = 0;
  for (Camera& camera : view.cameras)
    camera.vignetting = {}, camera.texture = nullptr, camera.exposure_factors.clear(), camera.timing.reset();
  for (GridSamples& s : samples) {
    const ImageF image = render_grid(renderer, view, s.camera, s.grid, kRoomPoints).front();
    s.room_light.clear();
    for (const std::size_t cell : s.cell) s.room_light.push_back(image.data[cell]);
  }
}

void find_projector_places(render::Renderer& renderer, const Twin& twin, std::vector<GridSamples>& samples) {
  const Twin view = render::showing_places(twin);
  for (GridSamples& s : samples) {
    const std::vector<ImageF> images = render_grid(renderer, view, s.camera, s.grid, 4);
    s.projector_px.clear();
    for (const std::size_t cell : s.cell)
      s.projector_px.push_back(render::place_in_projector_px(images, cell, *twin.projector).cast<float>());
  }
}

}  // namespace fringetwin::compare
