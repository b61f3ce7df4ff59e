// SPDX-License-Identifier: Apache-2.0
#include "compare/refine/texture_spread.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "render/pattern/pixel_texture.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::compare {
namespace {

constexpr int kReach = 2;           ///< px: of texture_moment()
constexpr int kBlock = 32;          ///< px: side of what scatters by itself
constexpr double kSmooth = 0.1;     ///< of the light without fringes, from pixel to pixel
constexpr double kFarSigmas = 4.0;  ///< pixels beyond are none of the model's
constexpr int kRounds = 4;          ///< of leaving out such pixels
constexpr double kClearSigmas = 5.0;
constexpr std::size_t kFewest = 1000;
constexpr std::size_t kFewestTellingBlocks =
    12;                             ///< that tell the standard error: of noise 1 in 2500 passes 5 of them
constexpr double kWidestPx = 20.0;  ///< as the twin's key has it

/// What a pixel tells of the spread's square s: minimum of |rest - s * moment|^2 over its values.
struct Telling {
  float product = 0.0F, square = 0.0F;  ///< rest * moment; moment^2 less what the noise of its slopes makes
  float variance = 0.0F;                ///< of one value of the rest
  bool counts = false;
};

/// Returns whether the light without its fringes is smooth as far as the pixel's slopes reach.
bool is_smooth(const ImageF& mean, int x, int y) {
  const double here = mean(x, y);
  for (int d = -kReach; d <= kReach; ++d)
    for (const double near : {static_cast<double>(mean(x + d, y)), static_cast<double>(mean(x, y + d))})
      if (!(near > 0.0) || std::abs(near - here) > kSmooth * here) return false;
  return true;
}

ImageF mean_of(const GrayOverLight& values) {
  ImageF mean(values.light().front().width, values.light().front().height, 0.0F);
  const auto n = static_cast<float>(values.images().size());
  for (const std::size_t k : values.images())
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean.data[i] += static_cast<float>(values.light_at(k, i)) / n;
  return mean;
}

/// The line in the light of a pixel, which can be taken out of any of its values.
class Projected {
 public:
  Projected(const OwnKinds& kinds, const Eigen::VectorXd& light) : kinds_(kinds), light_(centred(light)) {}
  double square() const { return light_.squaredNorm(); }
  Eigen::VectorXd rest_of(const Eigen::VectorXd& values) const {
    Eigen::VectorXd rest = centred(values);
    if (kinds_.factor && square() > 0.0) rest -= rest.dot(light_) / square() * light_;
    return rest;
  }

 private:
  Eigen::VectorXd centred(const Eigen::VectorXd& v) const {
    return kinds_.offset ? Eigen::VectorXd(v.array() - v.mean()) : v;
  }
  OwnKinds kinds_;
  Eigen::VectorXd light_;
};

/// Finds what each pixel tells.
class Pixels {
 public:
  Pixels(const OwnKinds& kinds, const GrayOverLight& values, const PixelTexture& texture)
      : kinds_(kinds), values_(values), texture_(texture), mean_(mean_of(values)) {}

  std::vector<Telling> all() const {
    const ImageF& factor = texture_.factor;
    std::vector<Telling> out(factor.size());
    std::vector<float> noise(factor.size(), 0.0F);  // variance of the factors
#pragma omp parallel for schedule(static)
    for (int y = kReach; y < factor.height - kReach; ++y)
      for (int x = kReach; x < factor.width - kReach; ++x)
        tell(x, y, out[factor.index(x, y)], noise[factor.index(x, y)]);
    const auto row = static_cast<std::size_t>(factor.width);
#pragma omp parallel for schedule(static)
    for (int y = kReach; y < factor.height - kReach; ++y)
      for (int x = kReach; x < factor.width - kReach; ++x) {
        const std::size_t i = factor.index(x, y);
        if (!out[i].counts) continue;
        const Projected line = line_of(i);
        for (const std::size_t distance : {std::size_t{1}, row}) {
          const float of_slope = (64.0F * (noise[i - distance] + noise[i + distance]) +
                                  noise[i - 2 * distance] + noise[i + 2 * distance]) /
                                 144.0F;
          const Eigen::VectorXd slopes = line.rest_of(gathered([&](std::size_t k) {
            return render::slope_along(values_.light()[k], i, distance) / values_.exposure(k);
          }));
          out[i].square -= of_slope * static_cast<float>(slopes.squaredNorm());
        }
      }
    return out;
  }

 private:
  /// Returns value(k) of the images k.
  Eigen::VectorXd gathered(auto value) const {
    Eigen::VectorXd v(static_cast<Eigen::Index>(values_.images().size()));
    std::ranges::transform(values_.images(), v.begin(), value);
    return v;
  }

  Projected line_of(std::size_t i) const {
    return {kinds_, gathered([&](std::size_t k) { return values_.light_at(k, i); })};
  }

  void tell(int x, int y, Telling& out, float& noise) const {
    const std::size_t i = texture_.factor.index(x, y);
    if (!(texture_.factor.data[i] > 0.0F) || !is_smooth(mean_, x, y)) return;
    for (const std::size_t k : values_.images())
      if (!values_.is_usable(k, i)) return;
    const Projected line = line_of(i);
    const auto freedom = static_cast<double>(values_.images().size()) - 1.0 - (kinds_.offset ? 1.0 : 0.0);
    if (!(line.square() > 0.0) || freedom < 1.0) return;
    const Eigen::VectorXd rest = line.rest_of(gathered([&](std::size_t k) { return values_.gray_at(k, i); }));
    const Eigen::VectorXd moment = line.rest_of(gathered([&](std::size_t k) {
      return render::texture_moment(texture_.factor, values_.light()[k], x, y) / values_.exposure(k);
    }));
    const double variance = rest.squaredNorm() / freedom;
    noise = static_cast<float>(variance / line.square());
    out = {static_cast<float>(rest.dot(moment)), static_cast<float>(moment.squaredNorm()),
           static_cast<float>(variance), true};
  }

  OwnKinds kinds_;
  const GrayOverLight& values_;
  const PixelTexture& texture_;
  ImageF mean_;
};

/// Pixels of an image, dealt to blocks.
class Blocks {
 public:
  Blocks(int width, int height)
      : width_(width), across_((width + kBlock - 1) / kBlock), down_((height + kBlock - 1) / kBlock) {}
  std::size_t count() const { return static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_); }
  std::size_t of(std::size_t pixel) const {
    const auto x = static_cast<int>(pixel % static_cast<std::size_t>(width_)),
               y = static_cast<int>(pixel / static_cast<std::size_t>(width_));
    return static_cast<std::size_t>(y / kBlock * across_ + x / kBlock);
  }

 private:
  int width_, across_, down_;
};

/// Gives the pixels of a block the median of their variances: that of a single pixel is known too badly, and
/// holds what is wrong with it.
void share_variances(const Blocks& blocks, std::vector<Telling>& pixels) {
  std::vector<std::vector<float>> of_block(blocks.count());
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].counts) of_block[blocks.of(i)].push_back(pixels[i].variance);
  for (std::vector<float>& v : of_block)
    if (!v.empty()) {
      const auto median = static_cast<float>(upper_median(v));
      v = {median};
    }
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (pixels[i].counts) pixels[i].variance = of_block[blocks.of(i)].front();
}

/// The spread's square and its variance by the scatter of the blocks that have pixels.
struct Solution {
  double square = 0.0, variance = 0.0;
  std::size_t n_blocks = 0;
};

Solution solve(const Blocks& blocks, const std::vector<Telling>& pixels) {
  std::vector<double> products(blocks.count(), 0.0), squares(blocks.count(), 0.0);
  std::vector<bool> has_pixels(blocks.count(), false);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (const Telling& t = pixels[i]; t.counts) {
      products[blocks.of(i)] += static_cast<double>(t.product);
      squares[blocks.of(i)] += static_cast<double>(t.square);
      has_pixels[blocks.of(i)] = true;
    }
  double product = 0.0, square = 0.0, scatter = 0.0;
  for (std::size_t b = 0; b < products.size(); ++b) product += products[b], square += squares[b];
  Solution out;
  out.n_blocks = static_cast<std::size_t>(std::ranges::count(has_pixels, true));
  if (!(square > 0.0) || out.n_blocks < 2) return out;
  out.square = product / square;
  for (std::size_t b = 0; b < products.size(); ++b)
    scatter += std::pow(products[b] - out.square * squares[b], 2);
  const auto n = static_cast<double>(out.n_blocks);
  out.variance = n / (n - 1.0) * scatter / (square * square);
  return out;
}

/// Returns how far the pixel's own answer lies from s, in standard errors.
double off(const Telling& t, double s) {
  const double noise = std::sqrt(static_cast<double>(t.variance) * static_cast<double>(t.square));
  return noise > 0.0 ? (static_cast<double>(t.product) - s * static_cast<double>(t.square)) / noise : 0.0;
}

}  // namespace

GrayOverLight::GrayOverLight(const CameraImages& real, const std::vector<GrayImage>& light,
                             const std::vector<int>& images, const std::vector<double>& exposures,
                             const Refinement::Line& line)
    : real_(real),
      light_(light),
      exposures_(exposures),
      line_(line),
      images_(images.begin(), images.end()),
      saturation_dn_(real.saturation_dn()) {}

std::optional<TextureSpread> fit_texture_spread(const OwnKinds& kinds, const GrayOverLight& values,
                                                const PixelTexture& texture) {
  if (!kinds.factor || values.images().size() < 3) return std::nullopt;
  std::vector<Telling> pixels = Pixels(kinds, values, texture).all();
  const Blocks blocks(texture.factor.width, texture.factor.height);
  share_variances(blocks, pixels);
  Solution found = solve(blocks, pixels);
  for (int round = 0; round < kRounds; ++round) {
    for (Telling& t : pixels) t.counts = t.counts && std::abs(off(t, found.square)) <= kFarSigmas;
    found = solve(blocks, pixels);
  }
  const auto n = std::ranges::count_if(pixels, &Telling::counts);
  const double sigma = std::sqrt(found.variance), spread_px = std::sqrt(std::max(0.0, found.square));
  if (n < static_cast<std::ptrdiff_t>(kFewest) || found.n_blocks < kFewestTellingBlocks ||
      !(found.square > kClearSigmas * sigma) || spread_px > kWidestPx)
    return std::nullopt;
  return TextureSpread{spread_px, 0.5 * sigma / spread_px};
}

}  // namespace fringetwin::compare
