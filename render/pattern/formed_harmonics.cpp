// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/formed_harmonics.hpp"

#include <algorithm>
#include <array>
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
  double gx = 0.0, gy = 0.0, xx = 0.0, xy = 0.0, yy = 0.0, light_x = 0.0, light_y = 0.0;
};

// Returns the bound of what forming leaves out, of the fundamental: the skewness that bends, creases and
// shading make; what of the fourth and sixth cumulant is not that of an even turn along one axis of the
// pixel; the eighth cumulant. Without creases the numbers are those of the Taylor series (1/120, 1/24) and a
// margin; a crease or a step of the light in the middle of the pixel is the worst (1/48 and 1/32 of the
// differences that it makes).
double formed_error(const HarmonicWeights& w, const Run& r, bool creases) {
  const double x2 = r.gx * r.gx, y2 = r.gy * r.gy, gg = x2 + y2;
  const double along = x2 * r.xx + y2 * r.yy, across = r.gx * r.gy * r.xy;
  const double shade = gg * (r.gx * r.light_x + r.gy * r.light_y);
  double skew = (along + shade) / 100.0 + across / 20.0, fourth = x2 * y2 / 60.0;
  if (creases) {
    skew = along / 40.0 + across / 12.0 + shade / 30.0;
    fourth += 0.02 * std::sqrt(gg) * (along + 2.0 * across + shade);
  }
  return w.k3 * skew + w.k4 * fourth + w.k6 * x2 * y2 * gg / 84.0 + w.k8 * gg * gg * gg * gg / 256.0;
}

constexpr int kWide = BLOCK_WIDTH + 2, kHigh = BLOCK_HEIGHT + 2;

// The fundamental of a block and the pixels around it, and how it turns from each pixel to the next.
struct Window {
  using Values = std::array<float, kWide * kHigh>;
  Values c{}, s{}, mean{};      // a unit vector; mean 0: not known
  Values turn_x{}, turn_y{};    // to the right, down
  Values known_x{}, known_y{};  // 1 or 0
  void load(const Transport& t, std::size_t direction, std::size_t pitch, std::span<const PixelState> states,
            int x0, int y0);
  void find_turns();
  Run run_at(int at) const;
  bool known_at(int at) const {
    return known_x[at - 1] + known_x[at] > 0.0F && known_y[at - kWide] + known_y[at] > 0.0F;
  }
};

void Window::load(const Transport& t, std::size_t direction, std::size_t pitch,
                  std::span<const PixelState> states, int x0, int y0) {
  const int width = t.mean.width, height = t.mean.height;
  const ImageF &cosine = t.cosine[direction][pitch], &sine = t.sine[direction][pitch];
  for (int j = 0; j < kHigh; ++j) {
    const int y = y0 + j - 1;
    if (y < 0 || y >= height) continue;
    const int from = std::max(0, 1 - x0), to = std::min(kWide, width - x0 + 1);
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(y) * width + x0 - 1;
    for (int i = from; i < to; ++i) {
      const float a = cosine.data[row + i], b = sine.data[row + i];
      const float light = a * a + b * b > 0.0F ? t.mean.data[row + i] : 0.0F;
      const float per_size = 1.0F / std::sqrt(std::max(a * a + b * b, 1e-30F));
      c[j * kWide + i] = a * per_size;
      s[j * kWide + i] = b * per_size;
      mean[j * kWide + i] = light;
    }
    if (states.empty()) continue;
    for (int i = from; i < to; ++i)
      if (states[row + i] == PixelState::own) mean[j * kWide + i] = 0.0F;
  }
}

// A turn of less than 1.37 rad; larger ones are 10 and fail every bound.
void Window::find_turns() {
  const auto find = [&](int step, Values* turn, Values* known) {
    for (int at = 0; at + step < kWide * kHigh; ++at) {
      const float sine = c[at] * s[at + step] - s[at] * c[at + step];
      const float cosine = c[at] * c[at + step] + s[at] * s[at + step], q = sine * sine;
      const float small = sine * (1.0F + q * (1.0F / 6.0F + q * (3.0F / 40.0F + q * (0.045F + q * 0.06F))));
      (*turn)[at] = cosine > 0.2F ? small : 10.0F;
      (*known)[at] = mean[at] > 0.0F && mean[at + step] > 0.0F ? 1.0F : 0.0F;
    }
  };
  find(1, &turn_x, &known_x);
  find(kWide, &turn_y, &known_y);
}

// A neighbour that is not known says nothing.
Run Window::run_at(int at) const {
  const auto most = [](float a, float known_a, float b, float known_b) {
    return static_cast<double>(std::max(std::abs(a) * known_a, std::abs(b) * known_b));
  };
  const auto change = [&](int to) { return mean[to] / mean[at] - 1.0F; };
  const auto bend = [](const Values& turn, const Values& known, int a, int b) {
    return static_cast<double>(std::abs(turn[b] - turn[a]) * known[a] * known[b]);
  };
  const int left = at - 1, up = at - kWide, down = at + kWide;
  Run r;
  r.gx = most(turn_x[left], known_x[left], turn_x[at], known_x[at]);
  r.gy = most(turn_y[up], known_y[up], turn_y[at], known_y[at]);
  r.xx = bend(turn_x, known_x, left, at);
  r.yy = bend(turn_y, known_y, up, at);
  r.xy = std::max({bend(turn_x, known_x, at, down), bend(turn_x, known_x, at, up),
                   bend(turn_x, known_x, left, down - 1), bend(turn_x, known_x, left, up - 1)});
  r.light_x = most(change(left), known_x[left], change(at + 1), known_x[at]);
  r.light_y = most(change(up), known_y[up], change(down), known_y[at]);
  return r;
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
    if (formed_error(w, {.gx = swing_rad}, false) > 0.5 * phase_error_rad) return {};
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
  std::array<FormedError, BLOCK_PIXELS> worst{};
  const double fill = limits.fill;
  for (std::size_t d = 0; d < plan.weights.size(); ++d) {
    const HarmonicWeights& weights = plan.weights[d];
    if (!weights.any()) continue;
    Window w;
    w.load(transport, d, weights.pitch, states, x0, y0);
    w.find_turns();
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const int at = (j + 1) * kWide + i + 1;
        if (!(w.mean[at] > 0.0F)) continue;
        const std::size_t place = static_cast<std::size_t>(y0 + j) * width + x0 + i;
        Run run = w.run_at(at);
        for (double* first : {&run.gx, &run.gy, &run.light_x, &run.light_y}) *first *= fill;
        for (double* second : {&run.xx, &run.xy, &run.yy}) *second *= fill * fill;
        const bool creases = states.empty() || states[place] == PixelState::facets;
        const double error = w.known_at(at) ? formed_error(weights, run, creases) : HUGE_VAL;
        FormedError& here = worst[static_cast<std::size_t>(j * BLOCK_WIDTH + i)];
        here.irradiance =
            std::max(here.irradiance, static_cast<double>(w.mean[at]) * weights.fundamental * error);
        here.phase_rad = std::max(here.phase_rad, weights.in_phase > 0.0 ? weights.in_phase * error : 0.0);
      }
  }
  FormedErrors kept;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      FormedError& e = worst[static_cast<std::size_t>(j * BLOCK_WIDTH + i)];
      e.place = static_cast<std::uint32_t>((y0 + j) * width + x0 + i);
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
