// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/light_lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::render {
namespace {

constexpr int kFinestRoughPx = 2;  // squares of a rough surface: what is smaller is its noise
constexpr std::size_t kOneOf = 8;  // rough squares is quartered to see whether that helps
constexpr float kSigmas = 3.0F;    // by which noise alone sets a middle apart once in 400

// Of the first of every `step` values.
double root_mean_square(const std::vector<float>& values, std::size_t step) {
  double sum = 0.0;
  for (std::size_t i = 0; i < values.size(); i += step) sum += std::pow(static_cast<double>(values[i]), 2);
  return values.empty() ? 0.0
                        : std::sqrt(sum * static_cast<double>(step) / static_cast<double>(values.size()));
}

// Returns up to how much is usual among values that are noise; 0 of none.
float most_usual(std::vector<float> values) {
  return values.empty() ? 0.0F : kUsualMedians * static_cast<float>(upper_median(values));
}

}  // namespace

LightLattice::LightLattice(const SeenImage& seen, RoughnessAtSteps& roughness, std::size_t channels,
                           std::size_t numbers, float tolerance, const Gather& gather, int first_step_px)
    : seen_(seen), channels_(channels), numbers_(numbers), number_(seen.at.size(), -1) {
  std::vector<Square> squares = first_squares(first_step_px), smaller;
  std::vector<Waiting> waiting;
  while (!squares.empty()) {
    gather_corners_and_middles(squares, gather);
    std::vector<Told> told;
    for (const Square& s : squares) told.push_back(told_by(s, tolerance, roughness));
    const auto helps = quartering_helps(squares, told);
    std::vector<float> offs;
    for (const Told& t : told)
      if (t.on_one_surface()) offs.push_back(t.off);
    const float most_off = helps == false ? most_usual(std::move(offs)) : 0.0F;
    smaller.clear();
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const bool first = squares[i].larger_off == 0.0F;
      if (told[i].enough || (told[i].on_one_surface() && told[i].off <= most_off))
        take(squares[i], told[i]);
      else if (told[i].rough() && first && i % kOneOf != 0)
        waiting.push_back({squares[i], told[i]});
      else
        quarter(squares[i], told[i].off, smaller);
    }
    if (helps || smaller.empty()) release(std::exchange(waiting, {}), helps.value_or(true), smaller);
    squares.swap(smaller);
  }
}

// Takes a square between whose corners light is interpolated.
void LightLattice::take(const Square& s, const Told& told) {
  squares_.push_back(s);
  off_sq_ += told.rough() ? std::pow(static_cast<double>(told.off), 2) : 0.0;
}

// Takes rough squares that waited for what quarters of others say: those that are off by no more than most,
// or none.
void LightLattice::release(const std::vector<Waiting>& waiting, bool helps, std::vector<Square>& smaller) {
  std::vector<float> offs;
  for (const Waiting& w : waiting) offs.push_back(w.told.off);
  const float most_off = helps ? 0.0F : most_usual(std::move(offs));
  for (const auto& [square, told] : waiting) {
    if (told.off <= most_off)
      take(square, told);
    else
      quarter(square, told.off, smaller);
  }
}

// Squares of the first step that see something.
std::vector<LightLattice::Square> LightLattice::first_squares(int step) const {
  std::vector<Square> squares;
  const auto last = [step](int from, int size) { return std::min(from + step, size - 1); };
  for (int y = 0; y < std::max(1, seen_.height - 1); y += step)
    for (int x = 0; x < std::max(1, seen_.width - 1); x += step) {
      const Square s{x, y, last(x, seen_.width), last(y, seen_.height)};
      bool any = false;
      for (int v = s.y0; v <= s.y1 && !any; ++v)
        for (int u = s.x0; u <= s.x1 && !any; ++u) any = seen_.sees(seen_.pixel_of(u, v));
      if (any) squares.push_back(s);
    }
  return squares;
}

void LightLattice::gather_corners_and_middles(const std::vector<Square>& squares, const Gather& gather) {
  std::vector<std::uint32_t> wanted;
  for (const Square& s : squares) {
    for (const int y : {s.y0, s.y1})
      for (const int x : {s.x0, s.x1}) want(x, y, wanted);
    want((s.x0 + s.x1) / 2, (s.y0 + s.y1) / 2, wanted);
  }
  gather_new(wanted, gather);
}

void LightLattice::want(int x, int y, std::vector<std::uint32_t>& pixels) const {
  const std::size_t pixel = seen_.pixel_of(x, y);
  if (seen_.sees(pixel) && number_[pixel] < 0) pixels.push_back(static_cast<std::uint32_t>(pixel));
}

void LightLattice::gather_new(const std::vector<std::uint32_t>& wanted, const Gather& gather) {
  std::vector<std::uint32_t> pixels;
  for (const std::uint32_t pixel : wanted) {
    if (number_[pixel] >= 0) continue;
    number_[pixel] = static_cast<std::int32_t>(pixels_.size() + pixels.size());
    pixels.push_back(pixel);
  }
  if (pixels.empty()) return;
  const LightOfPixels light = gather(pixels);
  FT_CHECK(light.values.size() == pixels.size() * numbers_ && light.sigma.size() == pixels.size(),
           "light of all pixels");
  pixels_.insert(pixels_.end(), pixels.begin(), pixels.end());
  values_.insert(values_.end(), light.values.begin(), light.values.end());
  sigma_.insert(sigma_.end(), light.sigma.begin(), light.sigma.end());
  beside_.insert(beside_.end(), light.beside.begin(), light.beside.end());
  beside_.resize(pixels_.size(), 0.0F);
}

// Returns what a square sees by its corners and its middle, and then by all its pixels.
LightLattice::Sees LightLattice::seen_by(const Square& s, RoughnessAtSteps& roughness) const {
  const int x = (s.x0 + s.x1) / 2, y = (s.y0 + s.y1) / 2;
  if (!seen_.sees(seen_.pixel_of(x, y))) return Sees::edges;
  const SurfacePlace& middle = seen_.place(seen_.pixel_of(x, y));
  // a structure is rough at its own scale, a measured surface from pixel to pixel
  const bool rough = is_rough(roughness.at(1).widened(kSmooth, x, y), kSmooth);
  const auto wide = [&](const SurfaceLimits& limits) {
    if (!rough) return limits;
    const int step_px = std::max(1, std::max(s.x1 - s.x0, s.y1 - s.y0) / 2);
    return roughness.at(step_px).widened(roughness.at(1).widened(limits, x, y), x, y);
  };
  const SurfaceLimits limits = wide(kSmooth);
  int off_surface = 0;
  bool step = false;
  for (const std::size_t corner : corners_of(s)) {
    if (!seen_.sees(corner)) return Sees::edges;
    off_surface += on_one_surface(seen_.place(corner), middle, limits) ? 0 : 1;
    step = step || !on_one_surface(seen_.place(corner), middle, kNoStep);
  }
  if (rough && !step && s.x1 - s.x0 <= kFinestRoughPx && s.y1 - s.y0 <= kFinestRoughPx) return Sees::noise;
  if (off_surface > (rough ? 1 : 0) || !sees_one_surface(s, wide(kRough))) return Sees::edges;
  return rough ? Sees::rough_surface : Sees::smooth_surface;
}

// Squares without pixels between their corners tell enough: those have their own light.
LightLattice::Told LightLattice::told_by(const Square& s, float tolerance,
                                         RoughnessAtSteps& roughness) const {
  if (s.x1 - s.x0 <= 1 && s.y1 - s.y0 <= 1) return {.enough = true};
  Told out{.sees = seen_by(s, roughness)};
  if (!out.on_one_surface()) return {.enough = out.sees == Sees::noise, .sees = out.sees};
  const std::array<std::size_t, 4> corners = corners_of(s);
  const int x = (s.x0 + s.x1) / 2, y = (s.y0 + s.y1) / 2;
  const auto part = [](int at, int from, int to) {
    return to > from ? static_cast<float>(at - from) / static_cast<float>(to - from) : 0.0F;
  };
  const float u = part(x, s.x0, s.x1), v = part(y, s.y0, s.y1);
  const std::array<float, 4> weights{(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  const auto number = [this](std::size_t pixel) { return static_cast<std::size_t>(number_[pixel]); };
  const std::size_t middle = number(seen_.pixel_of(x, y));
  float variance = sigma_[middle] * sigma_[middle];
  for (std::size_t k = 0; k < 4; ++k) {
    const float sigma = weights[k] * sigma_[number(corners[k])];
    variance += sigma * sigma;
  }
  const float* own = &values_[middle * numbers_];
  for (std::size_t c = 0; c < channels_; ++c) {
    float told = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) told += weights[k] * values_[number(corners[k]) * numbers_ + c];
    out.off = std::max(out.off, std::abs(told - own[c]));
  }
  out.enough = out.off <= tolerance * (own[0] + beside_[middle]) + kSigmas * std::sqrt(variance);
  return out;
}

std::array<std::size_t, 4> LightLattice::corners_of(const Square& s) const {
  return {seen_.pixel_of(s.x0, s.y0), seen_.pixel_of(s.x1, s.y0), seen_.pixel_of(s.x0, s.y1),
          seen_.pixel_of(s.x1, s.y1)};
}

// Returns whether all pixels of a square see the surface of its middle: things may be smaller than squares.
// Of a rough surface most do.
bool LightLattice::sees_one_surface(const Square& s, const SurfaceLimits& limits) const {
  constexpr float kMostOff = 0.15F;  // of a rough surface's pixels
  const SurfacePlace& middle = seen_.place(seen_.pixel_of((s.x0 + s.x1) / 2, (s.y0 + s.y1) / 2));
  const auto pixels = static_cast<float>((s.x1 - s.x0 + 1) * (s.y1 - s.y0 + 1));
  int left = is_rough(limits, kRough) ? static_cast<int>(kMostOff * pixels) : 0;
  for (int y = s.y0; y <= s.y1; ++y)
    for (int x = s.x0; x <= s.x1; ++x) {
      const std::size_t pixel = seen_.pixel_of(x, y);
      if (!seen_.sees(pixel)) return false;
      if (!on_one_surface(seen_.place(pixel), middle, limits) && --left < 0) return false;
    }
  return true;
}

// Returns whether squares are off by less than the larger ones that they are quarters of, in the median; none
// where too few tell. Where light bends, a quarter is off by a fourth. Where it does not help, the surface is
// rough from place to place, as measured ones are, or there is noise; squares that are off by more are
// quartered all the same.
std::optional<bool> LightLattice::quartering_helps(const std::vector<Square>& squares,
                                                   const std::vector<Told>& told) {
  constexpr std::size_t kFewest = 100;
  constexpr float kHelps = 0.5F;
  std::vector<float> shares;
  for (std::size_t i = 0; i < squares.size(); ++i)
    if (told[i].on_one_surface() && squares[i].larger_off > 0.0F)
      shares.push_back(told[i].off / squares[i].larger_off);
  if (shares.size() < kFewest) return std::nullopt;
  return static_cast<float>(upper_median(shares)) <= kHelps;
}

void LightLattice::quarter(const Square& s, float off, std::vector<Square>& out) {
  const int x = (s.x0 + s.x1) / 2, y = (s.y0 + s.y1) / 2;
  const auto add = [&](int x0, int y0, int x1, int y1) {
    if (x1 > x0 || y1 > y0) out.push_back({x0, y0, x1, y1, off});
  };
  if (x == s.x0) {  // a row or column of two pixels
    add(s.x0, s.y0, s.x1, y);
    add(s.x0, y, s.x1, s.y1);
    return;
  }
  if (y == s.y0) {
    add(s.x0, s.y0, x, s.y1);
    add(x, s.y0, s.x1, s.y1);
    return;
  }
  add(s.x0, s.y0, x, y);
  add(x, s.y0, s.x1, y);
  add(s.x0, y, x, s.y1);
  add(x, y, s.x1, s.y1);
}

double LightLattice::noise() const {
  const double rough = squares_.empty() ? 0.0 : off_sq_ / static_cast<double>(squares_.size());
  return std::hypot(root_mean_square(sigma_, 1), std::sqrt(rough));
}
double LightLattice::light() const { return root_mean_square(values_, numbers_); }

ImageF LightLattice::interpolated(const std::vector<float>& values, std::size_t numbers,
                                  std::size_t number) const {
  FT_CHECK(values.size() == pixels_.size() * numbers && number < numbers, "light of all pixels");
  ImageF out(seen_.width, seen_.height, 0.0F);
#pragma omp parallel for schedule(dynamic, 256)
  for (std::size_t i = 0; i < squares_.size(); ++i) {
    const Square& s = squares_[i];
    const auto at = [&](int x, int y) {
      const std::int32_t gathered = number_[seen_.pixel_of(x, y)];
      return gathered < 0 ? 0.0F : values[static_cast<std::size_t>(gathered) * numbers + number];
    };
    const float a = at(s.x0, s.y0), b = at(s.x1, s.y0), c = at(s.x0, s.y1), d = at(s.x1, s.y1);
    const auto width = static_cast<float>(std::max(1, s.x1 - s.x0)),
               height = static_cast<float>(std::max(1, s.y1 - s.y0));
    // light bends: the middle is off the plane of the corners, on average to one side
    const auto hump = [](float u, float v) { return 16.0F * u * (1 - u) * v * (1 - v); };
    const int x_middle = (s.x0 + s.x1) / 2, y_middle = (s.y0 + s.y1) / 2;
    float bend = 0.0F;
    if (x_middle > s.x0 && y_middle > s.y0) {
      const float u = static_cast<float>(x_middle - s.x0) / width,
                  v = static_cast<float>(y_middle - s.y0) / height;
      bend = (at(x_middle, y_middle) - ((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d))) /
             hump(u, v);
    }
    // the last row and column are those of the next square, but for the image's own
    const int y_end = s.y1 == seen_.height - 1 ? s.y1 + 1 : std::max(s.y1, s.y0 + 1);
    const int x_end = s.x1 == seen_.width - 1 ? s.x1 + 1 : std::max(s.x1, s.x0 + 1);
    for (int y = s.y0; y < y_end; ++y)
      for (int x = s.x0; x < x_end; ++x) {
        const float u = static_cast<float>(x - s.x0) / width, v = static_cast<float>(y - s.y0) / height;
        out(x, y) = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d) + bend * hump(u, v);
      }
  }
  // what gathered has its own light, also at corners that squares of different size share
  for (std::size_t i = 0; i < pixels_.size(); ++i) out.data[pixels_[i]] = values[i * numbers + number];
  return out;
}

}  // namespace fringetwin::render
