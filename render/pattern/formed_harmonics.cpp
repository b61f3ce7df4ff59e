// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/formed_harmonics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "render/base/pixel_list.hpp"
#include "render/pattern/waveform.hpp"
#include "render/shaders/shared.h"
#include "twin/base/constants.hpp"

// Compiled for vectors of more than one width; without fused operations all of them round alike.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define FRINGETWIN_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define FRINGETWIN_WIDE
#endif

namespace fringetwin::render {
namespace {

// Of one pitch, by sizes of the harmonics in the light that arrives.
HarmonicWeights weights_of(const Twin& twin, const PhaseSeries& series, double pitch_px) {
  HarmonicWeights w;
  const double blur_px = twin.projector->blur_px;
  w.fundamental = series.size(1) * blur_attenuation(1, blur_px, pitch_px);
  double all = 0.0, in_phase = 0.0;
  for (std::size_t order = 2; order < series.a.size(); ++order) {
    const auto k = static_cast<double>(order);
    const double size =
        series.size(order) * blur_attenuation(static_cast<int>(order), blur_px, pitch_px) / w.fundamental;
    w.k2 += size * k * k;
    w.k3 += size * (k * k * k - k) / 6.0;
    w.k4 += size * (k * k * k * k - k * k) / 24.0;
    w.k6 += size * std::pow(k, 6) / 720.0;
    w.k8 += size * std::pow(k, 8) / 37800.0;
    const int of_steps = static_cast<int>(order) % twin.fringes.steps;
    const bool alike = of_steps == 1 % twin.fringes.steps || of_steps == twin.fringes.steps - 1;
    all += size * k * k * k;
    in_phase += alike ? size * k * k * k : 0.0;
  }
  w.in_phase = all > 0.0 ? in_phase / all : 0.0;
  return w;
}

// Of all pitches of a direction, as if they were the finest one's: the phase of a wider one turns less.
HarmonicWeights weights_of(const Twin& twin, const DirectionFringes& d,
                           const std::vector<PhaseSeries>& series) {
  HarmonicWeights all;
  for (std::size_t p = 0; p < series.size(); ++p)
    if (series[p].a.size() > 2 && (all.fundamental == 0.0 || d.pitches_px[p] < d.pitches_px[all.pitch])) {
      all.pitch = p;
      all.fundamental = 1.0;
    }
  if (all.fundamental == 0.0) return all;
  all.fundamental = weights_of(twin, series[all.pitch], d.pitches_px[all.pitch]).fundamental;
  for (std::size_t p = 0; p < series.size(); ++p) {
    if (series[p].a.size() <= 2) continue;
    const HarmonicWeights w = weights_of(twin, series[p], d.pitches_px[p]);
    const double finer = d.pitches_px[all.pitch] / d.pitches_px[p], size = w.fundamental / all.fundamental;
    all.k2 = std::max(all.k2, size * w.k2);
    all.k3 = std::max(all.k3, size * w.k3 * std::pow(finer, 3));
    all.k4 = std::max(all.k4, size * w.k4 * std::pow(finer, 4));
    all.k6 = std::max(all.k6, size * w.k6 * std::pow(finer, 6));
    all.k8 = std::max(all.k8, size * w.k8 * std::pow(finer, 8));
    all.in_phase = std::max(all.in_phase, w.in_phase);
  }
  return all;
}

// How the phase of a fringe runs through a pixel, in sizes: gradient, second differences, and the relative
// change of the light to the neighbours; per side of the pixel's square.
struct Run {
  float gx = 0.0F, gy = 0.0F, xx = 0.0F, xy = 0.0F, yy = 0.0F, light_x = 0.0F, light_y = 0.0F;
};

// HarmonicWeights as the bounds take them.
struct BoundWeights {
  float k3, k4, k6, k8;
  explicit BoundWeights(const HarmonicWeights& w)
      : k3(static_cast<float>(w.k3)),
        k4(static_cast<float>(w.k4)),
        k6(static_cast<float>(w.k6)),
        k8(static_cast<float>(w.k8)) {}
};

// Returns 1 or, where x is not above 0, 0. A condition would keep its loops from being vectors.
inline float one_above(float x) { return 0.5F + std::copysign(0.5F, x - 1e-30F); }
constexpr float kNoBound = 1e30F;

inline float root(float x) {  // to 1e-6; std::sqrt() would keep its loops from being vectors
  const float from = x + 1e-30F;
  auto y = std::bit_cast<float>(0x5f3759df - (std::bit_cast<std::int32_t>(from) >> 1));
  for (int i = 0; i < 3; ++i) y *= 1.5F - 0.5F * from * y * y;
  return from * y;
}

// Returns the bound of what forming leaves out, of the fundamental: the skewness that bends, creases and
// shading make; what of the fourth and sixth cumulant is not that of an even turn along one axis of the
// pixel; the eighth cumulant. Without creases the numbers are those of the Taylor series (1/120, 1/24) and a
// margin; a crease or a step of the light in the middle of the pixel is the worst (1/48 and 1/32 of the
// differences that it makes). `creases`: 1 or 0.
inline float formed_error(const BoundWeights& w, const Run& r, float creases) {
  const float x2 = r.gx * r.gx, y2 = r.gy * r.gy, gg = x2 + y2;
  const float along = x2 * r.xx + y2 * r.yy, across = r.gx * r.gy * r.xy;
  const float shade = gg * (r.gx * r.light_x + r.gy * r.light_y);
  const float smooth = (along + shade) * (1.0F / 100.0F) + across * (1.0F / 20.0F);
  const float creased = along * (1.0F / 40.0F) + across * (1.0F / 12.0F) + shade * (1.0F / 30.0F);
  const float skew = smooth + creases * (creased - smooth);
  const float fourth =
      x2 * y2 * (1.0F / 60.0F) + creases * 0.02F * root(gg) * (along + 2.0F * across + shade);
  return w.k3 * skew + w.k4 * fourth + w.k6 * x2 * y2 * gg * (1.0F / 84.0F) +
         w.k8 * gg * gg * gg * gg * (1.0F / 256.0F);
}

constexpr int kWide = BLOCK_WIDTH + 2, kHigh = BLOCK_HEIGHT + 2;

// The fundamental of a block and the pixels around it, and how it turns from each pixel to the next.
struct Window {
  using Values = std::array<float, kWide * kHigh>;
  Values c{}, s{}, mean{};      // a unit vector; mean 0: not known
  Values turn_x{}, turn_y{};    // to the right, down
  Values known_x{}, known_y{};  // 1 or 0
  bool load(const Transport& t, std::size_t direction, std::size_t pitch, std::span<const PixelState> states,
            int x0, int y0);
  void bound_row(const BoundWeights& weights, float fill, int row, const float* creases, float* error) const;
};

FRINGETWIN_WIDE void to_unit_vectors(const float* cosine, const float* sine, const float* mean, int n,
                                     float* c, float* s, float* light) {
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float a = cosine[i], b = sine[i], squares = a * a + b * b;
    const float per_size = root(squares) / (squares + 1e-30F);
    c[i] = a * per_size;
    s[i] = b * per_size;
    light[i] = one_above(squares) * mean[i];
  }
}

// A turn of less than 1.37 rad; larger ones are 10 and fail every bound.
FRINGETWIN_WIDE void find_turns(const float* c, const float* s, const float* mean, int step, float* turn,
                                float* known) {
#pragma GCC ivdep
  for (int at = 0; at < kWide * kHigh - step; ++at) {
    const float sine = c[at] * s[at + step] - s[at] * c[at + step];
    const float cosine = c[at] * c[at + step] + s[at] * s[at + step], q = sine * sine;
    const float small = sine * (1.0F + q * (1.0F / 6.0F + q * (3.0F / 40.0F + q * (0.045F + q * 0.06F))));
    const float is_small = one_above(cosine - 0.2F);
    turn[at] = is_small * small + (1.0F - is_small) * 10.0F;
    known[at] = one_above(std::min(mean[at], mean[at + step]));
  }
}

// Takes up a block and returns true; or returns false where none of it is known.
bool Window::load(const Transport& t, std::size_t direction, std::size_t pitch,
                  std::span<const PixelState> states, int x0, int y0) {
  const int width = t.mean.width, height = t.mean.height;
  const ImageF &cosine = t.cosine[direction][pitch], &sine = t.sine[direction][pitch];
  for (int j = 0; j < kHigh; ++j) {
    const int y = y0 + j - 1;
    if (y < 0 || y >= height) continue;
    const int from = std::max(0, 1 - x0), to = std::min(kWide, width - x0 + 1), at = j * kWide + from;
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(y) * width + x0 - 1 + from;
    to_unit_vectors(&cosine.data[first], &sine.data[first], &t.mean.data[first], to - from, &c[at], &s[at],
                    &mean[at]);
    for (int i = 0; i < to - from; ++i) {
      const bool is_known = states.empty() || states[first + i] != PixelState::own;
      if (!is_known || !std::isfinite(mean[at + i]))
        mean[at + i] = 0.0F;  // one that is no number says nothing
    }
  }
  if (std::ranges::all_of(mean, [](float v) { return v == 0.0F; })) return false;
  find_turns(c.data(), s.data(), mean.data(), 1, turn_x.data(), known_x.data());
  find_turns(c.data(), s.data(), mean.data(), kWide, turn_y.data(), known_y.data());
  return true;
}

// Of a row of the block; 0 where a pixel is not known, kNoBound where it has no neighbours that are. A
// neighbour that is not known says nothing.
FRINGETWIN_WIDE void Window::bound_row(const BoundWeights& weights, float fill, int row, const float* creases,
                                       float* error) const {
  const int from = (row + 1) * kWide + 1;
  const float *m = &mean[from], *tx = &turn_x[from], *ty = &turn_y[from];
  const float *kx = &known_x[from], *ky = &known_y[from];
#pragma GCC ivdep
  for (int i = 0; i < BLOCK_WIDTH; ++i) {
    const int left = i - 1, up = i - kWide, down = i + kWide;
    const float inverse = 1.0F / (m[i] + 1e-30F);
    Run r;
    r.gx = fill * std::max(std::abs(tx[left]) * kx[left], std::abs(tx[i]) * kx[i]);
    r.gy = fill * std::max(std::abs(ty[up]) * ky[up], std::abs(ty[i]) * ky[i]);
    r.xx = fill * fill * (std::abs(tx[i] - tx[left]) * kx[left] * kx[i]);
    r.yy = fill * fill * (std::abs(ty[i] - ty[up]) * ky[up] * ky[i]);
    const float a = std::abs(tx[down] - tx[i]) * kx[i] * kx[down],
                b = std::abs(tx[up] - tx[i]) * kx[i] * kx[up],
                c0 = std::abs(tx[down - 1] - tx[left]) * kx[left] * kx[down - 1],
                d = std::abs(tx[up - 1] - tx[left]) * kx[left] * kx[up - 1];
    r.xy = fill * fill * std::max(std::max(a, b), std::max(c0, d));
    r.light_x = fill * std::max(std::abs(m[left] * inverse - 1.0F) * kx[left],
                                std::abs(m[i + 1] * inverse - 1.0F) * kx[i]);
    r.light_y = fill * std::max(std::abs(m[up] * inverse - 1.0F) * ky[up],
                                std::abs(m[down] * inverse - 1.0F) * ky[i]);
    const float bound = formed_error(weights, r, creases[i]);
    const float known = one_above(std::min(kx[left] + kx[i], ky[up] + ky[i]));
    error[i] = one_above(m[i]) * (bound + (1.0F - known) * kNoBound);
  }
}

}  // namespace

double HarmonicsPlan::worst() const {
  double most = 0.0;
  for (const HarmonicWeights& w : weights) most = std::max(most, w.k2);
  return 1.0 + most;
}

bool may_form_harmonics(const Twin& twin) {
  if (!twin.projector) return false;
  const Projector& p = *twin.projector;
  return is_linear(p.response) && twin.fringes.waveform.kind == Waveform::Kind::sine &&
         twin.fringes.has_harmonics() && !p.optics && !p.pixel_structure && !p.has_blur_field() &&
         twin.render.bounces == 0 && !twin.has_subsurface() && twin.render.pixel_fill > 0.0;
}

HarmonicsPlan plan_harmonics(const Twin& twin, const Camera& camera, const SeriesTable& series,
                             double phase_error_rad, double center_x_px, double center_y_px) {
  HarmonicsPlan plan;
  if (!may_form_harmonics(twin) || camera.optics ||
      std::max(camera.lens.width(), camera.lens.height()) > kListLimitPx)
    return plan;
  // Taken for a surface that faces both and is as far from the camera as from the projector.
  const double px_per_px = twin.projector->lens.intrinsics().at(0) / camera.lens.intrinsics().at(0);
  bool any = false;
  for (std::size_t d = 0; d < series.size(); ++d) {
    const DirectionFringes& direction = twin.fringes.directions[d];
    if (std::ranges::any_of(series[d], [](const PhaseSeries& s) { return s.a.empty(); })) return {};
    plan.weights.push_back(weights_of(twin, direction, series[d]));
    const HarmonicWeights& w = plan.weights.back();
    if (!w.any()) continue;
    any = true;
    const double swing_rad =
        kTwoPi / direction.pitches_px[w.pitch] * px_per_px * twin.sampled_side_px(camera);
    const float bound = formed_error(BoundWeights(w), {.gx = static_cast<float>(swing_rad)}, 0.0F);
    if (static_cast<double>(bound) > 0.5 * phase_error_rad) return {};
  }
  if (!any) return {};
  plan.own = plan_passes(twin, series, center_x_px, center_y_px, MAX_PITCHES);
  for (PassPlan& pass : plan.own) pass.direct.clear();
  std::erase_if(plan.own, [](const PassPlan& pass) { return pass.pitches.empty(); });
  return plan;
}

SeriesTable fundamentals_of(const SeriesTable& series) {
  SeriesTable out = series;
  for (auto& direction : out)
    for (PhaseSeries& s : direction) {
      if (s.a.size() > 2) s.a.resize(2);
      if (s.b.size() > 2) s.b.resize(2);
    }
  return out;
}

namespace {

// Orders k of pixels of weight m, whose fundamental is m v, |v| the contrast. A turn by 2 h evenly through
// the pixel leaves sin(kh)/(kh): from the fundamental's by logarithms, L = -ln |v| = h^2/6 + h^4/180 +
// h^6/2835.
constexpr int kStrip = 256;
struct Strip {
  std::array<float, kStrip> x, y, r, fourth, sixth, c, s, size, power;
};

FRINGETWIN_WIDE void begin(const float* mean, const float* cosine, const float* sine, float per_blur, int n,
                           Strip* strip) {
  Strip& o = *strip;
  for (int i = 0; i < n; ++i) {
    const float inverse = per_blur / std::max(mean[i], 1e-30F);
    const float x = cosine[i] * inverse, y = sine[i] * inverse;
    const float r = std::min(1.0F, x * x + y * y), t = std::min(0.25F, 1.0F - r);
    const float L = 0.5F * t * (1.0F + t * (0.5F + t * (0.33333333F + t * (0.25F + t * 0.2F))));
    o.x[i] = o.c[i] = x;
    o.y[i] = o.s[i] = y;
    o.r[i] = r;
    o.fourth[i] = L * L * (0.2F - 0.08F * L);
    o.sixth[i] = L * L * L * 0.07619048F;
    o.size[i] = mean[i];
    o.power[i] = 1.0F;
  }
}

FRINGETWIN_WIDE void next_order(float kk, float blur, int n, Strip* strip, float* cosine, float* sine) {
  Strip& o = *strip;
#pragma GCC ivdep
  for (int i = 0; i < n; ++i) {
    const float c = o.c[i] * o.x[i] - o.s[i] * o.y[i], s = o.s[i] * o.x[i] + o.c[i] * o.y[i];
    o.c[i] = c;
    o.s[i] = s;
    o.power[i] *= o.r[i];  // r^(k - 1): the contrast to the power k^2 in all
    o.size[i] *= o.power[i];
    const float e = kk * ((kk - 1.0F) * o.fourth[i] + (kk * kk - 1.0F) * o.sixth[i]);
    const float left = 1.0F - e * (1.0F - e * (0.5F - e * (0.16666667F - e * 0.041666667F)));
    const float a = o.size[i] * left * blur;
    cosine[i] = a * c;
    sine[i] = a * s;
  }
}

}  // namespace

void form_harmonics(const Transport& transport, std::size_t direction, std::size_t pitch, double pitch_px,
                    double blur_px, std::ptrdiff_t first, std::ptrdiff_t n,
                    std::span<const FormedPair> pairs) {
  const auto per_blur = static_cast<float>(1.0 / blur_attenuation(1, blur_px, pitch_px));
  Strip strip;
  for (std::ptrdiff_t from = 0; from < n; from += kStrip) {
    const int length = static_cast<int>(std::min<std::ptrdiff_t>(kStrip, n - from));
    begin(&transport.mean.data[first + from], &transport.cosine[direction][pitch].data[first + from],
          &transport.sine[direction][pitch].data[first + from], per_blur, length, &strip);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto k = static_cast<int>(i) + 2;
      next_order(static_cast<float>(k * k), static_cast<float>(blur_attenuation(k, blur_px, pitch_px)),
                 length, &strip, pairs[i].cosine + from, pairs[i].sine + from);
    }
  }
  const auto& own = transport.own_harmonics[direction][pitch];
  auto at = std::ranges::lower_bound(own.places, static_cast<std::uint32_t>(first));
  for (; at != own.places.end() && *at < first + n; ++at) {
    const float* sums = &own.sums[static_cast<std::size_t>(at - own.places.begin()) * 2 * pairs.size()];
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      pairs[i].cosine[*at - first] = sums[2 * i];
      pairs[i].sine[*at - first] = sums[2 * i + 1];
    }
  }
}

FRINGETWIN_WIDE void add_formed(const FormedPair& pair, float c, float s, std::ptrdiff_t n, float* out) {
  const float *cosine = pair.cosine, *sine = pair.sine;
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < n; ++i) out[i] += c * cosine[i] - s * sine[i];
}

FormedErrors find_unformed(const Transport& transport, const HarmonicsPlan& plan,
                           std::span<const PixelState> states, int x0, int y0, const FormedLimits& limits,
                           std::vector<FormedError>* large) {
  const int width = transport.mean.width, height = transport.mean.height;
  const int columns = std::min(BLOCK_WIDTH, width - x0), rows = std::min(BLOCK_HEIGHT, height - y0);
  std::array<float, BLOCK_PIXELS> irradiance{}, phase{};
  bool any = false;
  for (std::size_t d = 0; d < plan.weights.size(); ++d) {
    const HarmonicWeights& weights = plan.weights[d];
    if (!weights.any()) continue;
    Window w;
    if (!w.load(transport, d, weights.pitch, states, x0, y0)) continue;
    any = true;
    const BoundWeights of_bound(weights);
    const auto fundamental = static_cast<float>(weights.fundamental),
               in_phase = static_cast<float>(weights.in_phase);
    for (int j = 0; j < rows; ++j) {
      std::array<float, BLOCK_WIDTH> creases{}, error;
      const std::ptrdiff_t place = static_cast<std::ptrdiff_t>(y0 + j) * width + x0;
      for (int i = 0; i < columns; ++i)
        creases[i] = states.empty() || states[place + i] == PixelState::facets ? 1.0F : 0.0F;
      w.bound_row(of_bound, static_cast<float>(limits.fill), j, creases.data(), error.data());
      const float* light = &w.mean[(j + 1) * kWide + 1];
      for (int i = 0; i < columns; ++i) {
        if (error[i] == 0.0F) continue;
        const int at = j * BLOCK_WIDTH + i;
        irradiance[at] = std::max(irradiance[at], light[i] * fundamental * error[i]);
        if (in_phase > 0.0F) phase[at] = std::max(phase[at], in_phase * error[i]);
      }
    }
  }
  FormedErrors kept;
  for (int j = 0; any && j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int at = j * BLOCK_WIDTH + i;
      const FormedError e{static_cast<std::uint32_t>((y0 + j) * width + x0 + i),
                          static_cast<double>(irradiance[at]), static_cast<double>(phase[at])};
      if (e.irradiance <= limits.irradiance && e.phase_rad <= limits.phase_rad)
        kept.add(e);
      else
        large->push_back(e);
    }
  return kept;
}

void sort_harmonics(Transport* transport) {
  for (auto& direction : transport->own_harmonics)
    for (auto& own : direction) {
      const std::size_t n = own.places.size(), per_place = n > 0 ? own.sums.size() / n : 0;
      std::vector<std::uint32_t> order(n);
      std::iota(order.begin(), order.end(), 0U);
      std::ranges::sort(order, {}, [&](std::uint32_t i) { return own.places[i]; });
      Transport::OwnHarmonics sorted;
      for (const std::uint32_t i : order) {
        sorted.places.push_back(own.places[i]);
        sorted.sums.insert(sorted.sums.end(), own.sums.begin() + static_cast<std::ptrdiff_t>(i * per_place),
                           own.sums.begin() + static_cast<std::ptrdiff_t>((i + 1) * per_place));
      }
      own = std::move(sorted);
    }
}

}  // namespace fringetwin::render
