// SPDX-License-Identifier: Apache-2.0
#include "render/pattern/waveform.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/base/quadrature.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

using std::numbers::pi;
constexpr double kReachSigmas = 8.5;  // a Gaussian beyond holds 2e-17
constexpr int kMostHarmonics = 512;   // smaller blurs are convolved directly
constexpr int kPanelNodes = 16;

// Evaluates a response, which is defined on [0, 1]; the cosine may leave that range by a rounding error.
double respond(const ProjectorResponse& response, double value) {
  return is_linear(response) ? value : response(std::clamp(value, 0.0, 1.0));
}

// Returns the t in (0, pi) where response(mean + amplitude cos t) has a kink, ascending.
std::vector<double> find_kinks(const ProjectorResponse& response, double mean, double amplitude) {
  std::vector<double> levels{0.0, 1.0};
  if (response.kind == ProjectorResponse::Kind::table) {
    levels.clear();
    const std::size_t n = response.table.size();
    for (std::size_t i = 0; i < n; ++i) levels.push_back(static_cast<double>(i) / static_cast<double>(n - 1));
  }
  std::vector<double> kinks;
  if (amplitude == 0.0) return kinks;
  for (double level : levels) {
    const double c = (level - mean) / amplitude;
    if (std::abs(c) < 1.0) kinks.push_back(std::acos(c));
  }
  std::ranges::sort(kinks);
  return kinks;
}

// Cuts [a, b] into panels no wider than `widest`, halving towards those ends where the integrand may
// behave like |t - end|^power.
std::vector<double> panel_ends(double a, double b, double widest, bool grade_a, bool grade_b) {
  std::vector<double> ends{a};
  constexpr int kLevels = 40;
  const double width = b - a;
  if (grade_a)
    for (int i = kLevels; i >= 2; --i) ends.push_back(a + std::ldexp(width, -i));
  if (grade_b) {
    ends.push_back(a + 0.5 * width);
    for (int i = 2; i <= kLevels; ++i) ends.push_back(b - std::ldexp(width, -i));
  }
  ends.push_back(b);
  std::vector<double> fine{a};
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const int pieces = std::max(1, static_cast<int>(std::ceil((ends[i] - ends[i - 1]) / widest)));
    for (int j = 1; j <= pieces; ++j)
      fine.push_back(j == pieces ? ends[i] : ends[i - 1] + (ends[i] - ends[i - 1]) * j / pieces);
  }
  return fine;
}

// Calls visit(t, weight) over [a, b], split at `breaks` (ascending); power-law branch points may lie
// at every break.
template <class Visit>
void integrate(double a, double b, const std::vector<double>& breaks, double widest, bool graded,
               Visit visit) {
  const GaussRule& rule = gauss_rule(kPanelNodes);
  std::vector<double> ends{a};
  for (double t : breaks)
    if (t > a && t < b) ends.push_back(t);
  ends.push_back(b);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const auto panels = panel_ends(ends[i - 1], ends[i], widest, graded, graded);
    for (std::size_t j = 1; j < panels.size(); ++j) {
      const double center = 0.5 * (panels[j] + panels[j - 1]), half = 0.5 * (panels[j] - panels[j - 1]);
      for (std::size_t q = 0; q < rule.nodes.size(); ++q)
        visit(center + half * rule.nodes[q], half * rule.weights[q]);
    }
  }
}

bool is_power(const ProjectorResponse& response) { return response.kind == ProjectorResponse::Kind::gamma; }

// A part of a waveform's period in which the shown value runs linearly.
struct Stretch {
  double from_rad, to_rad, from, to;
};

// Cuts one period of a waveform that is no sine into its stretches.
std::vector<Stretch> stretches_of(const Fringes& fringes) {
  const std::vector<double>& values = fringes.waveform.values;
  const std::size_t n = values.size();
  const auto shown = [&](std::size_t i) {
    return fringes.mean + fringes.amplitude * (2.0 * values[i % n] - 1.0);
  };
  const auto phase = [&](std::size_t i) {
    return 2.0 * pi * static_cast<double>(i) / static_cast<double>(n);
  };
  const std::size_t next = fringes.waveform.kind == Waveform::Kind::levels ? 0 : 1;
  std::vector<Stretch> all;
  for (std::size_t i = 0; i < n; ++i) all.push_back({phase(i), phase(i + 1), shown(i), shown(i + next)});
  return all;
}

// Returns where the response to a stretch has kinks, ascending.
std::vector<double> kinks_in(const Stretch& s, const ProjectorResponse& response) {
  std::vector<double> kinks;
  for (const double t : find_kinks(response, 0.5 * (s.from + s.to), 0.5 * std::abs(s.to - s.from))) {
    const double part = 0.5 * (1.0 + (s.to > s.from ? 1.0 : -1.0) * std::cos(t));
    kinks.push_back(s.from_rad + part * (s.to_rad - s.from_rad));
  }
  std::ranges::sort(kinks);
  return kinks;
}

// Adds the Fourier integrals over a stretch whose light runs linearly: in closed form.
void add_linear_stretch(const Stretch& s, double light_from, double light_to, PhaseSeries* series) {
  const double width = s.to_rad - s.from_rad, slope = (light_to - light_from) / width;
  series->a[0] += 0.5 * (light_from + light_to) * width / (2.0 * pi);
  for (std::size_t k = 1; k < series->a.size(); ++k) {
    const auto order = static_cast<double>(k);
    const double c0 = std::cos(order * s.from_rad), s0 = std::sin(order * s.from_rad);
    const double c1 = std::cos(order * s.to_rad), s1 = std::sin(order * s.to_rad);
    series->a[k] += ((light_to * s1 - light_from * s0) + slope / order * (c1 - c0)) / (pi * order);
    series->b[k] += (-(light_to * c1 - light_from * c0) + slope / order * (s1 - s0)) / (pi * order);
  }
}

// Adds them over a stretch behind a response that bends: by quadrature, as cosine_series().
void add_bent_stretch(const Stretch& s, const ProjectorResponse& response, PhaseSeries* series) {
  const double widest = std::min(pi / 8.0, 8.0 / static_cast<double>(series->a.size()));
  const bool graded =
      is_power(response) && std::min(s.from, s.to) < 0.1 * std::max(s.from, s.to);  // towards value 0
  integrate(s.from_rad, s.to_rad, kinks_in(s, response), widest, graded, [&](double t, double weight) {
    const double part = (t - s.from_rad) / (s.to_rad - s.from_rad);
    const double wf = weight / pi * respond(response, s.from + part * (s.to - s.from));
    series->a[0] += 0.5 * wf;
    for (std::size_t k = 1; k < series->a.size(); ++k) {
      series->a[k] += wf * std::cos(static_cast<double>(k) * t);
      series->b[k] += wf * std::sin(static_cast<double>(k) * t);
    }
  });
}

}  // namespace

bool is_linear(const ProjectorResponse& response) {
  return response.kind == ProjectorResponse::Kind::linear ||
         (response.kind == ProjectorResponse::Kind::gamma && response.gamma == 1.0);
}

bool throws_pure_cosines(const Twin& twin) {
  return twin.projector && is_linear(twin.projector->response) &&
         twin.fringes.waveform.kind == Waveform::Kind::sine && !twin.fringes.has_harmonics();
}

double pattern_margin_px(const Projector& projector) {
  double shift_px = 0.0;  // an image whose patterns lie elsewhere is looked up beyond the border
  for (const double of_image : projector.image_shifts_px) shift_px = std::max(shift_px, std::abs(of_image));
  const double margin_px = 2.0 + std::ceil(shift_px);
  if (!projector.optics) return margin_px;
  const Optics& o = *projector.optics;
  const auto& k = projector.lens.intrinsics();
  // This covers the circle of confusion from a fifth of the focus distance on.
  return margin_px +
         std::ceil(2.0 * o.focal_length_mm / o.f_number / o.focus_distance_mm * std::max(k[0], k[1]));
}

double blur_attenuation(int harmonic, double sigma_px, double pitch_px) {
  const double u = pi * harmonic * sigma_px / pitch_px;
  return std::exp(-2.0 * u * u);
}

PhaseSeries cosine_series(const ProjectorResponse& response, double mean, double amplitude, int harmonics) {
  FT_CHECK(harmonics >= 0, "number of harmonics");
  PhaseSeries series;
  series.a.assign(static_cast<std::size_t>(harmonics) + 1, 0.0);
  if (is_linear(response)) {
    series.a[0] = mean;
    if (harmonics >= 1) series.a[1] = amplitude;
    return series;
  }
  const double widest = std::min(pi / 8.0, 8.0 / std::max(1, harmonics));
  integrate(0.0, pi, find_kinks(response, mean, amplitude), widest, is_power(response),
            [&](double t, double weight) {
              const double wf = weight / pi * respond(response, mean + amplitude * std::cos(t));
              for (std::size_t k = 0; k < series.a.size(); ++k)
                series.a[k] += (k == 0 ? wf : 2.0 * wf) * std::cos(static_cast<double>(k) * t);
            });
  return series;
}

PhaseSeries fringe_series(const ProjectorResponse& response, const Fringes& fringes, const Harmonics& added,
                          int harmonics) {
  PhaseSeries series;
  if (fringes.waveform.kind == Waveform::Kind::sine) {
    series = cosine_series(response, fringes.mean, fringes.amplitude, harmonics);
    if (added.empty()) return series;
    series.b.assign(series.a.size(), 0.0);
  } else {
    series.a.assign(static_cast<std::size_t>(harmonics) + 1, 0.0);
    series.b = series.a;
    for (const Stretch& s : stretches_of(fringes)) {
      if (is_linear(response) || s.from == s.to)
        add_linear_stretch(s, respond(response, s.from), respond(response, s.to), &series);
      else
        add_bent_stretch(s, response, &series);
    }
  }
  for (std::size_t i = 0; i < added.size() && i + 2 < series.a.size(); ++i) {
    series.a[i + 2] += added[i].cosine;
    series.b[i + 2] += added[i].sine;
  }
  return series;
}

double total_variation(const ProjectorResponse& response, const Fringes& fringes) {
  FT_CHECK(fringes.waveform.kind != Waveform::Kind::sine, "the variation of a waveform that is a table");
  const std::vector<Stretch> all = stretches_of(fringes);
  double sum = 0.0, before = respond(response, all.back().to);
  for (const Stretch& s : all) {
    std::vector<double> at = kinks_in(s, response);
    at.insert(at.begin(), s.from_rad);
    at.push_back(s.to_rad);
    for (const double t : at) {  // monotonic between the kinks
      const double part = (t - s.from_rad) / (s.to_rad - s.from_rad);
      const double light = respond(response, s.from + part * (s.to - s.from));
      sum += std::abs(light - before);
      before = light;
    }
  }
  return sum;
}

EffectivePattern::EffectivePattern(const Twin& twin, const PatternSpec& pattern)
    : fringes_(twin.fringes), pattern_(pattern) {
  FT_CHECK(twin.projector.has_value(), "a pattern needs a projector");
  response_ = twin.projector->response;
  sigma_px_ = twin.projector->blur_px;
  margin_px_ = pattern_margin_px(*twin.projector);
  const DirectionFringes& d = fringes_.directions.at(pattern.direction);
  const std::size_t p = pattern.is_gray() ? 0 : static_cast<std::size_t>(pattern.pitch);
  const double size_px = d.axis == Axis::x ? twin.projector->lens.width() : twin.projector->lens.height();
  if (pattern.is_gray() && twin.projector->has_halo()) shown_px_ = size_px;
  pitch_px_ = d.pitches_px.at(p);
  origin_px_ = d.phase_origin_px.at(p);
  if (!pattern.is_gray() && d.contrast_of(p) != 1.0) {
    contrast_ = d.contrast_of(p);
    mean_light_ = fringe_series(response_, fringes_, {}, 0).a[0];
  }
  if (twin.projector->pixel_structure) {
    method_ = Method::pixels;
    pixel_fill_ = twin.projector->pixel_fill;
    levels_ = twin.projector->quantise_bits ? std::exp2(*twin.projector->quantise_bits) - 1.0 : 0.0;
    return;
  }
  if (sigma_px_ == 0.0) return;
  if (pattern.is_gray()) {
    method_ = Method::edges;
    find_edges(size_px);
    return;
  }
  shift_rad_ = 2.0 * pi * pattern.step / fringes_.steps;
  const Harmonics& added = d.harmonics_of(p);
  const bool sine = fringes_.waveform.kind == Waveform::Kind::sine;
  // exp(-2 u^2) < 1e-17 at u = 4.43
  double needed = is_linear(response_) && sine ? 1.0 : std::ceil(4.43 * pitch_px_ / (pi * sigma_px_));
  method_ = needed > kMostHarmonics ? Method::convolution : Method::series;
  if (!added.empty()) needed = std::max(needed, static_cast<double>(added.size() + 1));
  if (method_ == Method::convolution) {
    find_breaks();
    if (added.empty()) return;
    series_.a.assign(added.size() + 2, 0.0);
    series_.b = series_.a;
    for (std::size_t i = 0; i < added.size(); ++i) {
      series_.a[i + 2] = added[i].cosine;
      series_.b[i + 2] = added[i].sine;
    }
  } else {
    series_ = fringe_series(response_, fringes_, added, std::max(1, static_cast<int>(needed)));
  }
  for (std::size_t k = 1; k < series_.a.size(); ++k) {
    const double left = blur_attenuation(static_cast<int>(k), sigma_px_, pitch_px_);
    series_.a[k] *= left;
    if (!series_.b.empty()) series_.b[k] *= left;
  }
}

// Finds where the light of one turn is not smooth.
void EffectivePattern::find_breaks() {
  if (fringes_.waveform.kind != Waveform::Kind::sine) {
    for (const Stretch& s : stretches_of(fringes_)) {
      breaks_.push_back(s.from_rad);
      for (const double kink : kinks_in(s, response_)) breaks_.push_back(kink);
    }
    return;
  }
  for (const double kink : find_kinks(response_, fringes_.mean, fringes_.amplitude)) {
    breaks_.push_back(kink);
    breaks_.push_back(-kink);
  }
  breaks_.push_back(pi);  // where the value is lowest
}

// Returns the response to the shown value at a phase.
double EffectivePattern::light(double phase_rad) const {
  const double wave = fringes_.waveform.kind == Waveform::Kind::sine
                          ? std::cos(phase_rad)
                          : fringes_.waveform(phase_rad / (2.0 * pi));
  return respond(response_, fringes_.mean + fringes_.amplitude * wave);
}

double EffectivePattern::operator()(double coordinate_px) const {
  const double light = full_contrast(coordinate_px);
  return contrast_ == 1.0 ? light : mean_light_ + contrast_ * (light - mean_light_);
}

// Returns the light of a fringe whose contrast is 1.
double EffectivePattern::full_contrast(double coordinate_px) const {
  switch (method_) {
    case Method::direct:
      return respond(response_, pattern_value(fringes_, pattern_, coordinate_px)) +
             harmonic_light(fringes_, pattern_, coordinate_px);
    case Method::series:
      return series_(2.0 * pi * (coordinate_px - origin_px_) / pitch_px_ + shift_rad_);
    case Method::convolution:
      return convolve(coordinate_px);
    case Method::edges:
      return sum_edges(coordinate_px);
    case Method::pixels:
      return mix_pixels(coordinate_px);
  }
  return 0.0;
}

// Computes the convolution integral itself by quadrature, for blurs too small for a short series.
double EffectivePattern::convolve(double coordinate_px) const {
  const double rad_per_px = 2.0 * pi / pitch_px_;
  const double t0 = rad_per_px * (coordinate_px - origin_px_) + shift_rad_, s = rad_per_px * sigma_px_;
  const double lowest = t0 - kReachSigmas * s, highest = t0 + kReachSigmas * s;
  std::vector<double> breaks;
  for (int turn = static_cast<int>(std::floor(lowest / (2.0 * pi)));
       turn <= static_cast<int>(std::ceil(highest / (2.0 * pi))); ++turn) {
    for (const double t : breaks_) breaks.push_back(2.0 * pi * turn + t);
  }
  std::ranges::sort(breaks);
  double sum = 0.0;
  integrate(lowest, highest, breaks, s, is_power(response_), [&](double t, double weight) {
    const double u = (t - t0) / s;
    sum += weight * std::exp(-0.5 * u * u) * light(t);
  });
  return sum / (s * std::sqrt(2.0 * pi)) + (series_.a.empty() ? 0.0 : series_(t0));
}

// Finds the edges of a Gray image: it is constant on half words, and an edge is where two neighbours differ.
// A halo reaches far over the image's border: there its first and last pixels go on, and not the code's next
// words, which nobody shows.
void EffectivePattern::find_edges(double size_px) {
  const DirectionFringes& d = fringes_.directions[pattern_.direction];
  const double offset = d.gray ? d.gray->offset_periods : 0.0;
  const double cell = 0.5 * pitch_px_, start = origin_px_ + offset * pitch_px_;
  const double reach = margin_px_ + 0.5 + (kReachSigmas + 1.0) * sigma_px_;
  const auto first = static_cast<long>(std::floor((-reach - start) / cell)) - 1;
  const auto last = static_cast<long>(std::ceil((size_px + reach - start) / cell)) + 1;
  const auto value = [&](long i) {
    const double center = start + (static_cast<double>(i) + 0.5) * cell;
    return respond(response_, pattern_value(fringes_, pattern_, shown_at(center)));
  };
  first_value_ = value(first);
  double previous = first_value_;
  for (long i = first + 1; i <= last; ++i) {
    const double next = value(i);
    if (next != previous)
      edges_.push_back({start + static_cast<double>(i) * cell, previous, next - previous});
    previous = next;
  }
}

double EffectivePattern::sum_edges(double coordinate_px) const {
  // Edges farther left than the blur reaches are settled: the value before the first other one has them.
  const double settled_px = coordinate_px - kReachSigmas * sigma_px_;
  auto e = std::lower_bound(edges_.begin(), edges_.end(), settled_px,
                            [](const Edge& edge, double x) { return edge.position_px < x; });
  double value = e != edges_.end() ? e->before
                 : edges_.empty()  ? first_value_
                                   : edges_.back().before + edges_.back().step;
  for (; e != edges_.end(); ++e) {
    const double u = (coordinate_px - e->position_px) / sigma_px_;
    if (u < -kReachSigmas) break;
    value += e->step * 0.5 * std::erfc(-u / std::numbers::sqrt2);
  }
  return value;
}

namespace {

// The normal distribution's integral, from a table: linear between nodes 1/1024 of a sigma apart it is exact
// to 3e-8, half of what single precision rounds 1 by.
class NormalIntegral {
 public:
  NormalIntegral() {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      nodes_[i] =
          0.5 * std::erfc(-(static_cast<double>(i) / kNodesPerSigma - kReachSigmas) / std::numbers::sqrt2);
  }
  double operator()(double u) const {
    const double at = (u + kReachSigmas) * kNodesPerSigma;
    const auto left = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(nodes_.size() - 2)));
    return nodes_[left] + (at - static_cast<double>(left)) * (nodes_[left + 1] - nodes_[left]);
  }

 private:
  static constexpr double kNodesPerSigma = 1024.0;
  std::vector<double> nodes_ =
      std::vector<double>(static_cast<std::size_t>(2.0 * kReachSigmas * kNodesPerSigma) + 2);
};

}  // namespace

std::vector<double> EffectivePattern::table(double first_px, double per_px, std::size_t n) const {
  std::vector<double> values(n);
  if (method_ != Method::edges) {
    for (std::size_t i = 0; i < n; ++i) values[i] = (*this)(first_px + static_cast<double>(i) / per_px);
    return values;
  }
  static const NormalIntegral integral;
  const double sigma = sigma_px_ * per_px, last = static_cast<double>(n);
  std::vector<double> settled(n + 1, 0.0);  // what edges add from a sample on
  settled[0] = first_value_;
  for (const Edge& edge : edges_) {
    const double at = (edge.position_px - first_px) * per_px;
    const auto from = static_cast<std::size_t>(std::clamp(std::ceil(at - kReachSigmas * sigma), 0.0, last)),
               to = static_cast<std::size_t>(
                   std::clamp(std::floor(at + kReachSigmas * sigma) + 1.0, 0.0, last));
    for (std::size_t i = from; i < to; ++i)
      values[i] += edge.step * integral((static_cast<double>(i) - at) / sigma);
    settled[to] += edge.step;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) values[i] += sum += settled[i];
  return values;
}

double EffectivePattern::shown_at(double center_px) const {
  return shown_px_ > 0.0 ? std::clamp(center_px, 0.0, shown_px_ - 1.0) : center_px;
}

double EffectivePattern::pixel_value(double center_px) const {
  double value = pattern_value(fringes_, pattern_, shown_at(center_px));
  if (levels_ > 0.0) value = std::round(value * levels_) / levels_;
  return respond(response_, value) + harmonic_light(fringes_, pattern_, center_px);
}

// Returns the mean of the pixels around, each weighted with the part of the blur spot on its lit square: the
// light that arrives over the light that arrives of a white image.
double EffectivePattern::mix_pixels(double coordinate_px) const {
  const double nearest = std::floor(coordinate_px + 0.5);
  if (sigma_px_ == 0.0) return pixel_value(nearest);
  const double reach = std::ceil(kReachSigmas * sigma_px_) + 1.0;
  const double scale = 1.0 / (sigma_px_ * std::numbers::sqrt2);
  double sum = 0.0, weights = 0.0;
  for (double i = nearest - reach; i <= nearest + reach; i += 1.0) {
    const double d = std::abs(coordinate_px - i);
    const double weight =
        std::erfc((d - 0.5 * pixel_fill_) * scale) - std::erfc((d + 0.5 * pixel_fill_) * scale);
    sum += weight * pixel_value(i);
    weights += weight;
  }
  return weights > 1e-280 ? sum / weights : pixel_value(nearest);
}

}  // namespace fringetwin::render
