// SPDX-License-Identifier: Apache-2.0
#include "compare/verdict/explain_code.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "compare/phase/phase_rows.hpp"
#include "compare/phase/texture_shift.hpp"
#include "compare/verdict/block_sums.hpp"
#include "twin/base/constants.hpp"

namespace fringetwin::compare {
namespace {

constexpr double kLeastCompared = 0.25;  ///< of the values: half of them are dark, often below what is usable

/// Where the edges of one direction's code lie: for each pixel by how much the real ones lie beside the
/// twin's, in projector px, and how many of these a step to the next column or row of the camera is.
struct EdgePlaces {
  ImageF moved_px;                        ///< real - simulated, by the fringes; NaN where that is not known
  ImageF textured_px;                     ///< by how much a texture within the pixel moves it
  const ImageD* coordinate_px = nullptr;  ///< of the simulated side

  /// Returns the projector px between the pixel's neighbours on both sides along a row (or a column), halved.
  double per_px(int x, int y, bool along_row) const {
    const ImageD& c = *coordinate_px;
    const int dx = along_row ? 1 : 0, dy = along_row ? 0 : 1;
    return 0.5 * (c(x + dx, y + dy) - c(x - dx, y - dy));
  }
};

/// Returns means over 5 x 5 pixels of those that are known: what is left of the noise of a phase. NaN stays.
ImageF smoothed(const ImageF& image) {
  constexpr int kReach = 2;
  ImageF out = image;
#pragma omp parallel for schedule(static)
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (std::isnan(image(x, y))) continue;
      float sum = 0.0F, n = 0.0F;
      for (int v = std::max(0, y - kReach); v <= std::min(image.height - 1, y + kReach); ++v)
        for (int u = std::max(0, x - kReach); u <= std::min(image.width - 1, x + kReach); ++u)
          if (const float value = image(u, v); !std::isnan(value)) sum += value, n += 1.0F;
      out(x, y) = sum / n;
    }
  return out;
}

EdgePlaces edge_places(const measure::DirectionDecode& real, const measure::DirectionDecode& simulated,
                       const PixelTexture* texture, double pixel_side_px) {
  const auto px_per_rad = static_cast<float>(real.pitches_px[real.finest] / kTwoPi);
  EdgePlaces out{smoothed(phase_difference(real, simulated)),
                 std::move(texture_shift(real, simulated, texture, pixel_side_px).largest_rad),
                 &simulated.coordinate_px};
  for (float& value : out.moved_px.data) value *= -px_per_rad;
  for (float& value : out.textured_px.data) value *= px_per_rad;
  return out;
}

/// One gray value with what it may be off by.
struct CodeValue {
  double residual_dn = 0.0;
  double light_dn = 0.0;   ///< predicted, over black
  double noise_dn2 = 0.0;  ///< of the value and of what its pixel has of its own
  double moved_dn = 0.0;   ///< by fringes that lie elsewhere
  double edge_dn2 = 0.0;   ///< by both kinds of moved edges
  double shaded_dn = 0.0;  ///< by the noise of a measured shape
};

class CodeExplanation {
 public:
  CodeExplanation(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise, const CodeInView& code,
                  const RenderingError& rendering, const OwnOfPixels& own, const ShapeInView& shape)
      : pair_(pair),
        fit_(fit),
        noise_(noise),
        code_(code),
        rendering_(rendering),
        own_(own),
        shape_(shape_in_budget(shape, own)) {
    for (std::size_t d = 0; d < code.real.directions.size(); ++d) {
      const measure::DirectionDecode& real = code.real.directions[d];
      const measure::DirectionDecode* simulated = code.simulated.direction(real.axis);
      const bool known = simulated && !simulated->coordinate_px.empty() && !real.coordinate_px.empty() &&
                         !real.pitches_px.empty();
      places_.push_back(known ? edge_places(real, *simulated, code.texture, code.pixel_side_px)
                              : EdgePlaces{});
    }
    for (const int image : pair.code_images()) {
      const auto d = static_cast<std::size_t>(pair.patterns[image].direction);
      if (d < places_.size() && places_[d].coordinate_px) lights_.push_back({image});
    }
    if (rendering_.scatter_dn2.size() > 0)
      for (const CodeLight& light : lights_)
        scatter_of_one_dn2_ +=
            rendering_.scatter_dn2(light.image, light.image) / static_cast<double>(lights_.size());
  }

  std::optional<CodeVerdict> run() {
    if (lights_.empty()) return std::nullopt;
    find_lights();
    CodeVerdict out;
    ExplainedRow& row = out.row;
    const Sums s = sum_blocks(pair_.width(), pair_.height(), row.regions,
                              [this](int x0, int y0, int x1, int y1) { return block(x0, y0, x1, y1); });
    row.quantity = "code";
    row.region = pair_.camera->name;
    row.unit = "DN";
    row.compared_fraction = share_of(s.n, std::max<std::uint64_t>(1, s.n_inside));
    if (!take_sums(s, row) || row.compared_fraction < kLeastCompared) return std::nullopt;
    const auto n = static_cast<double>(s.n);
    row.lines = noise_lines(noise_, s.noise / n, rendering_, scatter_of_one_dn2_);
    row.lines.push_back({"edges where the fringes lie, not where the twin says", s.texture / n});
    row.lines.push_back({"fit of the black level", black_dn2()});
    if (shape_.noise && shape_.shades) row.lines.push_back({kShapeLine, s.shape / n});
    judge(s, noise_.known_to(some_levels()), 1.0, row);
    out.lights = lights_;
    return out;
  }

 private:
  bool is_inside(int x, int y) const {
    return x > 0 && y > 0 && x + 1 < pair_.width() && y + 1 < pair_.height() && code_.interior(x, y) != 0;
  }

  /// Returns the gray values per projector px that an edge through this pixel makes at most: both neighbours'
  /// differences together, since an edge may lie between the pixel and either of them.
  double slope_at(const EdgePlaces& places, int image, int x, int y) const {
    const double per_column = places.per_px(x, y, true), per_row = places.per_px(x, y, false);
    const bool along_row = std::abs(per_column) >= std::abs(per_row);
    const int dx = along_row ? 1 : 0, dy = along_row ? 0 : 1;
    const double here = light_at(image, x, y);
    const double before = light_at(image, x - dx, y - dy), after = light_at(image, x + dx, y + dy);
    return (std::abs(here - before) + std::abs(after - here)) / (along_row ? per_column : per_row);
  }
  double light_at(int image, int x, int y) const {
    return fit_.row.gain_dn * pair_.irradiance_at(image, code_.interior.index(x, y));
  }

  /// Returns the variance of the black level that the steps tell, one draw for all values: it moves dark
  /// ones, and no factor takes that.
  double black_dn2() const { return std::pow(fit_.row.black_level_sigma_dn, 2); }

  /// Returns nothing where the value must not be used. `line`: of what its pixel has of its own.
  std::optional<CodeValue> value_at(const CodeLight& light, int x, int y, const OwnLightSums& line) const {
    const std::size_t i = code_.interior.index(x, y);
    const double real = pair_.real_at(light.image, i), light_dn = light_at(light.image, x, y);
    const double predicted = light.factor * light_dn + fit_.row.black_level_dn;
    if (!is_usable(fit_.usable, real, pair_.source_at(light.image, i), predicted)) return std::nullopt;
    const EdgePlaces& places = places_[pair_.patterns[light.image].direction];
    const double slope = slope_at(places, light.image, x, y),
                 moved = slope * static_cast<double>(places.moved_px.data[i]),
                 textured = slope * static_cast<double>(places.textured_px.data[i]);
    if (!std::isfinite(moved)) return std::nullopt;
    CodeValue out{real - predicted, light_dn, noise_.variance(predicted), moved,
                  moved * moved + textured * textured};
    if (own_.kinds.any()) out.noise_dn2 += line.variance_at(own_.kinds, pair_.irradiance_at(light.image, i));
    out.shaded_dn = shape_.shading_at(i) * (light_dn - fit_.row.gain_dn * shape_.ambient);
    return out;
  }

  /// Returns the predicted levels of the values of some pixels: a code's lie beyond those of the steps, which
  /// tell the noise.
  std::vector<float> some_levels() const {
    constexpr std::size_t kPixels = 2000;
    std::vector<float> levels;
    for (const std::size_t i : set_pixels(code_.interior, kPixels))
      for (const CodeLight& light : lights_) {
        const double dn = fit_.row.gain_dn * pair_.irradiance_at(light.image, i) + fit_.row.black_level_dn;
        const double real = pair_.real_at(light.image, i);
        if (is_usable(fit_.usable, real, pair_.source_at(light.image, i), dn))
          levels.push_back(static_cast<float>(dn));
      }
    return levels;
  }

  /// Finds the factor of each image's light by weighted least squares.
  void find_lights() {
    std::vector<std::vector<std::array<double, 2>>> rows(static_cast<std::size_t>(pair_.height()));
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < pair_.height(); ++y) {
      rows[y].assign(lights_.size(), {0.0, 0.0});
      if (y % (2 * row_step(pair_.width(), pair_.height())) != 0) continue;
      for (int x = 0; x < pair_.width(); ++x) {
        if (!is_inside(x, y)) continue;
        const OwnLightSums line = own_light_sums(pair_, own_, noise_, code_.interior.index(x, y));
        for (std::size_t k = 0; k < lights_.size(); ++k)
          if (const auto value = value_at(lights_[k], x, y, line)) {
            const double weight = 1.0 / (value->noise_dn2 + value->edge_dn2);
            rows[y][k][0] += weight * value->residual_dn * value->light_dn;
            rows[y][k][1] += weight * value->light_dn * value->light_dn;
          }
      }
    }
    for (std::size_t k = 0; k < lights_.size(); ++k) {
      double moment = 0.0, weight = 0.0;
      for (const auto& row : rows) moment += row[k][0], weight += row[k][1];
      if (!(weight > 0.0)) continue;
      lights_[k].factor = 1.0 + moment / weight;
      lights_[k].sigma = 1.0 / std::sqrt(weight);
    }
  }

  Sums block(int x0, int y0, int x1, int y1) const {
    Sums out;
    std::vector<BlockSum> levels(lights_.size());  // a region of each image: an edge is in one of them
    const double shared = rendering_.gray_dn * rendering_.gray_dn;
    for (int y = y0; y < y1; y += row_step(pair_.width(), pair_.height()))
      for (int x = x0; x < x1; ++x)
        if (is_inside(x, y)) pixel(x, y, shared, out, levels);
    for (const BlockSum& level : levels) add_region(level, shared, out);
    return out;
  }

  void pixel(int x, int y, double shared, Sums& out, std::vector<BlockSum>& levels) const {
    const std::size_t i = code_.interior.index(x, y);
    const OwnLightSums line = own_light_sums(pair_, own_, noise_, i);
    const double region_share = shape_.noise ? std::sqrt(shape_.shares_at(i).slope) : 0.0;
    out.n_inside += lights_.size();
    for (std::size_t k = 0; k < lights_.size(); ++k) {
      const auto value = value_at(lights_[k], x, y, line);
      if (!value) continue;
      const double scatter =
          scatter_of_one_dn2_ > 0.0 ? rendering_.scatter_dn2(lights_[k].image, lights_[k].image) : 0.0;
      const double own = value->noise_dn2 + value->edge_dn2 + scatter,
                   shaded = value->shaded_dn * value->shaded_dn;
      out.add(value->residual_dn * value->residual_dn, value->noise_dn2, own + shaded, shared, black_dn2());
      out.texture += value->edge_dn2;
      out.shape += shaded;
      levels[k].add(1.0, value->residual_dn, own + (rendering_.scatters_alike - 1.0) * scatter, black_dn2());
      levels[k].together += value->moved_dn;
      levels[k].slopes += value->shaded_dn * region_share;
      ++levels[k].pixels;
    }
  }

  const GrayPair& pair_;
  const GainFit& fit_;
  const GrayNoise& noise_;
  const CodeInView& code_;
  RenderingError rendering_;
  const OwnOfPixels& own_;
  ShapeInView shape_;
  double scatter_of_one_dn2_ = 0.0;
  std::vector<EdgePlaces> places_;  ///< of each direction; empty where it is not compared
  std::vector<CodeLight> lights_;
};

}  // namespace

std::optional<CodeVerdict> explain_code(const GrayPair& pair, const GainFit& fit, const GrayNoise& noise,
                                        const CodeInView& code, const RenderingError& rendering,
                                        const OwnOfPixels& own, const ShapeInView& shape) {
  return CodeExplanation(pair, fit, noise, code, rendering, own, shape).run();
}

std::string light_text(const CodeVerdict& code, const GrayPair& pair, const Fringes& fringes) {
  constexpr double kSigmas = 5.0;  // of the worst of many images
  const CodeLight* worst = nullptr;
  int n = 0;
  for (const CodeLight& light : code.lights) {
    const double off = std::abs(light.factor - 1.0);
    if (!(off > kLeastOtherLight + kSigmas * light.sigma)) continue;
    ++n;
    if (!worst || off > std::abs(worst->factor - 1.0)) worst = &light;
  }
  if (!worst) return "";
  return fmt::format(
      "{}: {} of the {} images of the code have other light than the twin says, most of all \"{}\": "
      "{:+.2f} % (the verdict on the code leaves each image its own light{})",
      pair.camera->name, n, code.lights.size(), pair.patterns[worst->image].label(fringes),
      100.0 * (worst->factor - 1.0),
      code.row.state == kExplained ? "" : "; with what the twin is wrong about mended, it may be another");
}

}  // namespace fringetwin::compare
