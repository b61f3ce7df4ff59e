// SPDX-License-Identifier: Apache-2.0
// The adaptive trace: a ray through every pixel's centre decides what the pixel needs (docs/PHYSICS.md).
//   nothing, or one surface all around    closed form, no further ray
//   one surface, but bent too much        Gauss-Legendre, two orders compared
//   facets of one lit mesh                clipped exactly, no further ray
//   an edge                               scan lines that find it, more of them until they agree
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <ctime>

#include "render/adaptive_error.hpp"
#include "render/renderer_impl.hpp"
#include "render/sample_table.hpp"
#include "twin/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t slots_per_dispatch = 4U << 20;
constexpr std::size_t output_bytes = 64U << 20;
constexpr std::uint32_t most_panels = 16;
constexpr int list_limit_px = 1 << 15;        // coordinates in a list entry
constexpr std::size_t exact_float = 1 << 24;  // identities travel as floats

// Half of what the target allows is left to the pixels with an estimate of their own (the others: the
// closed form's), and none of them may have more than this many times the rms target.
constexpr double share_of_budget = 0.5, share_of_outlines = 0.15, share_of_round = 0.7, most_allowance = 16.0;
// Rounding, as shares of single_precision_error_rad: on the paper's rig 3.0e-5 and 3e-6 rad on average over
// the scenes of adaptive_test.
constexpr double rounding_single = 0.6, rounding_double = 0.06;

std::uint32_t list_code(int x, int y, bool along_y) {
  return static_cast<std::uint32_t>(x) | static_cast<std::uint32_t>(y) << 15 | (along_y ? 1U << 31 : 0U);
}

struct Sums {
  const float* values = nullptr;
  std::size_t stride = 0;
  double at(std::size_t channel, std::size_t slot) const {
    return static_cast<double>(values[channel * stride + slot]);
  }
};

class AdaptiveTrace {
 public:
  AdaptiveTrace(Renderer::Impl& impl, const TraceJob& job, const Sampling& sampling)
      : impl_(impl), job_(job), sampling_(sampling) {
    const Sensor& sensor = job.camera.sensor;
    irradiance_target_ = sampling.gray_error * sensor.max_dn() / sensor.gain_dn;
    rounding_rad_ = (impl.precise ? rounding_double : rounding_single) * single_precision_error_rad(job.twin);
    const double left = sampling.phase_error_rad * sampling.phase_error_rad - rounding_rad_ * rounding_rad_;
    phase_target_rad_ = left > 0.0 ? std::sqrt(left) : 0.25 * sampling.phase_error_rad;
  }

  void run(const std::vector<PassPlan>& passes) {
    stage("probe", job_.blocks.size() * BLOCK_PIXELS, [&] { probe(); });
    for (std::size_t i = 0; i < passes.size(); ++i) {
      pass_ = &passes[i];
      first_pass_ = i == 0;
      targets_ = sum_targets(job_.twin, *pass_, first_pass_, job_.out);
      run_pass();
      note_estimate();
    }
  }

 private:
  SpecConstants constants(const SampleSetup& samples, std::uint32_t list) const {
    SpecConstants c = make_constants(job_.twin, job_.camera, job_.scene, job_.lens, job_.projector, samples,
                                     *pass_, job_.shortcuts.kinds);
    c[SPEC_PIXEL_LIST] = list;
    return c;
  }

  AdaptiveTargets limits() const {
    return {phase_target_rad_, irradiance_target_, closed_form_ ? 0 : base_order(), panels_};
  }

  int base_order() const { return impl_.precise ? 3 : 2; }

  static void must_finish(bool finished) {
    if (!finished) throw LoopLimit();
  }

  // What a step costs, for benchmarks.
  template <class Work>
  void stage(const char* name, std::size_t pixels, Work work) {
    const std::clock_t start = std::clock();
    const std::uint64_t rays = job_.out->rays;
    work();
    job_.out->stages.push_back({name, pixels, job_.out->rays - rays,
                                1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC});
  }

  void probe();
  void run_pass();
  void classify();
  void run_gauss(const std::vector<std::uint32_t>& list, int order);
  void run_checked(const std::vector<std::uint32_t>& list);
  void sort_out_uncrossed();
  void run_facets(const std::vector<std::uint32_t>& list);
  void run_outlines(const std::vector<std::uint32_t>& list);
  void run_lines();
  double add_lines(const Sums& sums, std::size_t slot, float* values) const;
  void note_estimate();

  // Runs `kernel` over `list` with `per_entry` invocations each and hands each part to
  // use(first entry, number of entries, sums).
  template <class Use>
  void run_list(ComputePipeline& kernel, const std::vector<std::uint32_t>& list, std::size_t per_entry,
                std::uint32_t n_samples, Use use);
  template <class Use>
  void run_rule(const std::vector<std::uint32_t>& list, int order, Use use);
  void reserve_output(std::size_t slots);
  std::size_t most_slots() const {
    const std::size_t slots = output_bytes / ((pass_->channels() + 2) * sizeof(float));
    return std::min(slots_per_dispatch, slots / BLOCK_PIXELS * BLOCK_PIXELS);  // whole work groups write
  }

  void write(std::uint32_t code, std::size_t slot, const Sums& sums) {
    const int x = static_cast<int>(code & 0x7fffU), y = static_cast<int>((code >> 15) & 0x7fffU);
    for (std::size_t c = 0; c < targets_.size(); ++c)
      if (targets_[c].image)
        (*targets_[c].image)(x, y) = sums.values[c * sums.stride + slot] * targets_[c].factor;
  }

  // Along which axis does what a pixel's centre rays saw change more? Scan lines should cross it.
  bool changes_along_y(std::uint32_t code) const {
    const int x = static_cast<int>(code & 0x7fffU), y = static_cast<int>((code >> 15) & 0x7fffU);
    const int width = job_.out->mean.width, height = job_.out->mean.height;
    const auto at = [&](int i, int j) {
      const auto k =
          static_cast<std::size_t>(std::clamp(j, 0, height - 1)) * static_cast<std::size_t>(width) +
          static_cast<std::size_t>(std::clamp(i, 0, width - 1));
      return seen_[k];
    };
    const gpu::vec4 c = at(x, y);
    const auto bend = [&](const gpu::vec4& a, const gpu::vec4& b) {
      return std::abs(a.x - 2.0F * c.x + b.x) + std::abs(a.y - 2.0F * c.y + b.y) +
             std::abs(a.z - 2.0F * c.z + b.z) / std::max(c.z, 1e-6F);
    };
    return bend(at(x, y - 1), at(x, y + 1)) > bend(at(x - 1, y), at(x + 1, y));
  }

  void to_scan_lines(std::uint32_t code) {
    mixed_.push_back((code & 0x3fffffffU) | (changes_along_y(code) ? 1U << 31 : 0U));
  }

  // Error of an irradiance image, given the errors of its mean and of its cosine and sine.
  double irradiance_error(double mean, double fringe) const {
    return job_.twin.fringes.mean * std::abs(mean) + job_.twin.fringes.amplitude * fringe;
  }

  void count_error(double phase_rad, double irradiance) {
    phase_squares_ += phase_rad * phase_rad;
    gray_squares_ += irradiance * irradiance;
    ++n_lit_;
  }

  Renderer::Impl& impl_;
  const TraceJob& job_;
  const Sampling sampling_;
  const PassPlan* pass_ = nullptr;
  const gpu::vec4* seen_ = nullptr;  // the probe buffer as the host sees it
  bool first_pass_ = true;
  bool closed_form_ = true;
  std::uint32_t panels_ = 1;
  std::vector<SumTarget> targets_;
  double irradiance_target_ = 0.0, rounding_rad_ = 0.0, phase_target_rad_ = 0.0;
  std::vector<std::uint32_t> regular_, smooth_, facets_, outlines_, mixed_;
  double phase_squares_ = 0.0, gray_squares_ = 0.0, mixed_squares_ = 0.0;
  std::size_t n_lit_ = 0, n_facets_ = 0, n_smooth_ = 0, n_mixed_ = 0, n_outlines_ = 0;
};

void AdaptiveTrace::reserve_output(std::size_t slots) {
  impl_.reserve(BIND_OUTPUT, slots * (pass_->channels() + 2) * sizeof(float));
  impl_.reserve(BIND_OBJECTS, slots * sizeof(std::int32_t));
}

template <class Use>
void AdaptiveTrace::run_list(ComputePipeline& kernel, const std::vector<std::uint32_t>& list,
                             std::size_t per_entry, std::uint32_t n_samples, Use use) {
  const std::size_t band = std::max<std::size_t>(1, most_slots() / per_entry);
  for (std::size_t first = 0; first < list.size(); first += band) {
    const std::size_t n = std::min(band, list.size() - first);
    const std::size_t groups = (n * per_entry + BLOCK_PIXELS - 1) / BLOCK_PIXELS;
    gpu::Push push{};
    push.first_block = static_cast<gpu::uint>(first);
    push.n_blocks_band = static_cast<gpu::uint>(groups);
    push.end_sample = n_samples;
    push.sentinel = SENTINEL_LOOPS;
    push.n_pixels = static_cast<gpu::uint>(n);
    must_finish(impl_.dispatch(kernel, push, static_cast<std::uint32_t>(groups), job_.out));
    const std::size_t stride = groups * BLOCK_PIXELS;
    const auto* values = reinterpret_cast<const float*>(
        impl_.buffers[BIND_OUTPUT]->read((pass_->channels() + 1) * stride * sizeof(float)));
    use(first, n, Sums{values, stride});
  }
}

void AdaptiveTrace::probe() {
  const auto n_pixels = job_.out->mean.size();
  impl_.reserve(BIND_PROBE, n_pixels * sizeof(gpu::vec4)).clear();
  const PassPlan nothing;
  pass_ = &nothing;
  const SampleSetup none;
  impl_.upload_samples(none);
  impl_.upload_pass(job_, nothing, none, limits());
  reserve_output(1);
  ComputePipeline& kernel = impl_.bound_kernel(Kernel::probe, constants(none, 0));
  const std::size_t band = slots_per_dispatch / BLOCK_PIXELS;
  for (std::size_t first = 0; first < job_.blocks.size(); first += band) {
    gpu::Push push{};
    const std::size_t n = std::min(band, job_.blocks.size() - first);
    push.first_block = static_cast<gpu::uint>(first);
    push.sentinel = SENTINEL_LOOPS;
    must_finish(impl_.dispatch(kernel, push, static_cast<std::uint32_t>(n), job_.out));
  }
  job_.out->rays += job_.blocks.size() * BLOCK_PIXELS;

  seen_ = reinterpret_cast<const gpu::vec4*>(impl_.buffers[BIND_PROBE]->read(n_pixels * sizeof(gpu::vec4)));
  const auto& materials = job_.scene.materials;
#pragma omp parallel for
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(n_pixels); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (seen_[k].w == 0.0F) continue;
    const float place = std::abs(seen_[k].w) - 1.0F;
    const auto after = std::upper_bound(materials.begin(), materials.end(), place,
                                        [](float p, const gpu::vec4& m) { return p < m.w; });
    job_.out->object.data[k] =
        job_.scene.object_of_primitive[static_cast<std::size_t>(after - materials.begin()) - 1];
  }
}

void AdaptiveTrace::run_pass() {
  closed_form_ = !impl_.precise;
  phase_squares_ = gray_squares_ = mixed_squares_ = 0.0;
  n_lit_ = n_outlines_ = 0;
  regular_.clear();
  smooth_.clear();
  facets_.clear();
  outlines_.clear();
  mixed_.clear();
  stage("classify", job_.blocks.size() * BLOCK_PIXELS, [&] { classify(); });
  n_smooth_ = smooth_.size();
  n_facets_ = facets_.size();
  if (!regular_.empty()) stage("gauss", regular_.size(), [&] { run_gauss(regular_, base_order()); });
  if (!outlines_.empty()) stage("outlines", outlines_.size(), [&] { run_outlines(outlines_); });
  if (!mixed_.empty()) stage("border", mixed_.size(), [&] { sort_out_uncrossed(); });
  if (!facets_.empty()) stage("facets", facets_.size(), [&] { run_facets(facets_); });
  if (!smooth_.empty()) stage("smooth", smooth_.size(), [&] { run_checked(smooth_); });
  n_mixed_ = mixed_.size();
  run_lines();
}

// Closed form over all blocks; sorts the others into the lists.
void AdaptiveTrace::classify() {
  const SampleSetup none;
  impl_.upload_pass(job_, *pass_, none, limits());
  const std::size_t band = std::max<std::size_t>(1, most_slots() / BLOCK_PIXELS);
  const std::size_t most = std::min(band, job_.blocks.size());
  reserve_output(most * BLOCK_PIXELS);
  ComputePipeline& kernel = impl_.bound_kernel(Kernel::closed_form, constants(none, 0));
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  for (std::size_t first = 0; first < job_.blocks.size(); first += band) {
    const std::size_t n = std::min(band, job_.blocks.size() - first);
    gpu::Push push{};
    push.first_block = static_cast<gpu::uint>(first);
    push.n_blocks_band = static_cast<gpu::uint>(n);
    push.sentinel = SENTINEL_LOOPS;
    must_finish(impl_.dispatch(kernel, push, static_cast<std::uint32_t>(n), job_.out));
    const std::size_t stride = n * BLOCK_PIXELS, channels = pass_->channels();
    const Sums sums{reinterpret_cast<const float*>(
                        impl_.buffers[BIND_OUTPUT]->read((channels + 2) * stride * sizeof(float))),
                    stride};
    const auto* kinds = reinterpret_cast<const std::int32_t*>(
        impl_.buffers[BIND_OBJECTS]->read(stride * sizeof(std::int32_t)));
    impl_.scatter_sums(job_, targets_, first, n, sums.values);
    for (std::size_t b = 0; b < n; ++b) {
      const std::uint32_t block = job_.blocks[first + b];
      const int x0 = static_cast<int>(block & 0xffffU) * BLOCK_WIDTH,
                y0 = static_cast<int>(block >> 16) * BLOCK_HEIGHT;
      for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y)
        for (int x = 0; x < BLOCK_WIDTH && x0 + x < width; ++x) {
          const std::size_t slot = b * BLOCK_PIXELS + static_cast<std::size_t>(y * BLOCK_WIDTH + x);
          const int kind = kinds[slot];
          if (kind == PIXEL_DONE) {
            if (sums.values[slot] == 0.0F) continue;
            count_error(sums.at(channels, slot), sums.at(channels + 1, slot));
            if (!closed_form_) regular_.push_back(list_code(x0 + x, y0 + y, false));
          } else {
            const bool outline = kind == PIXEL_OUTLINE || kind == PIXEL_OUTLINE_Y;
            auto& list = kind == PIXEL_SMOOTH   ? smooth_
                         : kind == PIXEL_FACETS ? facets_
                         : outline              ? outlines_
                                                : mixed_;
            list.push_back(list_code(x0 + x, y0 + y, kind == PIXEL_MIXED_Y || kind == PIXEL_OUTLINE_Y));
          }
        }
    }
  }
}

// Runs the Gauss rule of n x n nodes over a list.
template <class Use>
void AdaptiveTrace::run_rule(const std::vector<std::uint32_t>& list, int order, Use use) {
  SampleSetup samples;
  samples.table = gauss_samples(order * order, job_.twin.render.pixel_fill, {}, 0.0);
  samples.n = static_cast<std::uint32_t>(order * order);
  impl_.upload_samples(samples);
  impl_.upload_pass(job_, *pass_, samples, limits());
  impl_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() + BLOCK_PIXELS));
  run_list(impl_.bound_kernel(Kernel::trace, constants(samples, PIXELS_LISTED)), list, 1, samples.n, use);
  job_.out->rays += std::uint64_t{samples.n} * list.size();
}

// One rule, whose error the classification has bounded.
void AdaptiveTrace::run_gauss(const std::vector<std::uint32_t>& list, int order) {
  run_rule(list, order, [&](std::size_t first, std::size_t n, const Sums& sums) {
#pragma omp parallel for
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(n); ++i)
      write(list[first + static_cast<std::size_t>(i)], static_cast<std::size_t>(i), sums);
  });
}

// Two orders; what they do not agree on goes to the scan lines.
void AdaptiveTrace::run_checked(const std::vector<std::uint32_t>& list) {
  const std::size_t n_compared = 1 + 2 * pass_->pitches.size();  // mean and fringes, without the hit share
  std::vector<float> before(n_compared * list.size());
  const auto channel = [](std::size_t c) { return c == 0 ? 0 : c + 1; };
  run_rule(list, base_order(), [&](std::size_t first, std::size_t n, const Sums& sums) {
    for (std::size_t c = 0; c < n_compared; ++c)
      for (std::size_t i = 0; i < n; ++i)
        before[c * list.size() + first + i] = sums.values[channel(c) * sums.stride + i];
  });
  const std::size_t n_channels = pass_->channels();
  std::vector<float> values(n_channels * list.size());
  std::vector<double> phase(list.size()), gray(list.size()), worse(list.size());
  run_rule(list, base_order() + 1, [&](std::size_t first, std::size_t n, const Sums& sums) {
#pragma omp parallel for
    for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(n); ++k) {
      const auto i = static_cast<std::size_t>(k), e = first + i;
      const auto old = [&](std::size_t c) { return static_cast<double>(before[c * list.size() + e]); };
      double fringe = 0.0;
      for (std::size_t p = 0; p < pass_->pitches.size(); ++p) {
        const std::complex<double> a(old(1 + 2 * p), old(2 + 2 * p)),
            b(sums.at(2 + 2 * p, i), sums.at(3 + 2 * p, i));
        if (std::norm(b) > 0.0)
          phase[e] = std::max(phase[e], order_safety * std::abs(std::arg(a * std::conj(b))));
        fringe = std::max(fringe, std::abs(a - b));
      }
      gray[e] = order_safety * irradiance_error(old(0) - sums.at(0, i), fringe);
      worse[e] = std::max(phase[e] / phase_target_rad_, gray[e] / irradiance_target_);
      if (!std::isfinite(phase[e] + gray[e])) worse[e] = HUGE_VAL;
      for (std::size_t c = 0; c < n_channels; ++c)
        values[n_channels * e + c] = sums.values[c * sums.stride + i];
    }
  });
  const auto n_known = static_cast<double>(n_lit_ + list.size());
  const double most = largest_error_to_keep(worse, 0.5 * share_of_budget * n_known, most_allowance);
  for (std::size_t e = 0; e < list.size(); ++e) {
    if (!(worse[e] <= most)) {
      to_scan_lines(list[e]);
      continue;
    }
    count_error(phase[e], gray[e]);
    write(list[e], 0, Sums{&values[n_channels * e], 1});
  }
}

// Takes out of the mixed pixels those that only lie beside an edge.
void AdaptiveTrace::sort_out_uncrossed() {
  const std::vector<std::uint32_t> list = std::move(mixed_);
  mixed_.clear();
  const SampleSetup none;
  impl_.upload_pass(job_, *pass_, none, limits());
  impl_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() + BLOCK_PIXELS));
  ComputePipeline& kernel = impl_.bound_kernel(Kernel::border, constants(none, PIXELS_LISTED));
  run_list(kernel, list, 1, 0, [&](std::size_t first, std::size_t n, const Sums&) {
    const auto* answer =
        reinterpret_cast<const std::int32_t*>(impl_.buffers[BIND_OBJECTS]->read(n * sizeof(std::int32_t)));
    for (std::size_t i = 0; i < n; ++i)
      (answer[i] == 1 ? mixed_ : answer[i] == 2 ? facets_ : smooth_).push_back(list[first + i]);
  });
  job_.out->rays += 8 * list.size();
}

void AdaptiveTrace::run_facets(const std::vector<std::uint32_t>& list) {
  const SampleSetup none;
  impl_.upload_pass(job_, *pass_, none, limits());
  impl_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() + BLOCK_PIXELS));
  ComputePipeline& kernel = impl_.bound_kernel(Kernel::facets, constants(none, PIXELS_LISTED));
  run_list(kernel, list, 1, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
    const auto* incomplete =
        reinterpret_cast<const std::int32_t*>(impl_.buffers[BIND_OBJECTS]->read(n * sizeof(std::int32_t)));
    for (std::size_t i = 0; i < n; ++i) {
      if (incomplete[i]) {
        smooth_.push_back(list[first + i]);
        continue;
      }
      const double missing = std::abs(sums.at(1, i) - 1.0);
      count_error(missing, missing * irradiance_error(sums.at(0, i), sums.at(0, i)));
      write(list[first + i], i, sums);
    }
  });
}

// Edges between facets of one mesh and nothing, or between facets that face the projector and others.
void AdaptiveTrace::run_outlines(const std::vector<std::uint32_t>& list) {
  const SampleSetup none;
  impl_.upload_pass(job_, *pass_, none, limits());
  impl_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() + BLOCK_PIXELS));
  ComputePipeline& kernel = impl_.bound_kernel(Kernel::facets, constants(none, PIXELS_OUTLINE));
  const std::size_t n_channels = pass_->channels();
  std::vector<float> values(n_channels * list.size());
  std::vector<double> errors(list.size());
  run_list(kernel, list, 1, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
    const auto* rejected =
        reinterpret_cast<const std::int32_t*>(impl_.buffers[BIND_OBJECTS]->read(n * sizeof(std::int32_t)));
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t e = first + i;
      errors[e] = rejected[i] ? HUGE_VAL : irradiance_error(0.0, sums.at(n_channels, i));
      for (std::size_t c = 0; c < n_channels; ++c)
        values[n_channels * e + c] = sums.values[c * sums.stride + i];
    }
  });
  const auto n_known = static_cast<double>(n_lit_ + list.size() + facets_.size() + smooth_.size());
  const double most =
      largest_error_to_keep(errors, share_of_outlines * irradiance_target_ * irradiance_target_ * n_known,
                            most_allowance * irradiance_target_);
  for (std::size_t e = 0; e < list.size(); ++e) {
    if (!(errors[e] <= most)) {
      mixed_.push_back(list[e]);
      continue;
    }
    mixed_squares_ += errors[e] * errors[e];
    ++n_outlines_;
    write(list[e], 0, Sums{&values[n_channels * e], 1});
  }
}

// One pixel's scan lines to its sums; returns the estimated error of an irradiance image.
double AdaptiveTrace::add_lines(const Sums& sums, std::size_t slot, float* values) const {
  const auto channel_error = [&](std::size_t c) {
    double v = 0.0, e = 0.0;
    for (std::size_t p = 0; p < panels_; ++p) {
      std::array<double, LINES_PER_PANEL> g{};
      for (std::size_t l = 0; l < LINES_PER_PANEL; ++l) {
        g[l] = sums.at(c, slot + LINES_PER_PANEL * p + l);
        v += panel_weights[l] * g[l];
      }
      e += panel_error(g);
    }
    values[c] = static_cast<float>(v / panels_);
    return e / panels_;
  };
  const double mean = channel_error(0);
  const double hit = channel_error(1);
  double fringe = 0.0;
  for (std::size_t p = 0; p < pass_->pitches.size(); ++p) {
    const double cosine = channel_error(2 + 2 * p), sine = channel_error(3 + 2 * p);
    fringe = std::max(fringe, std::hypot(cosine, sine));
  }
  const double error = irradiance_error(mean, fringe) + job_.twin.projector->ambient * hit;
  return std::isfinite(error) ? error : HUGE_VAL;
}

// Scan lines in panels of four, twice as many panels for what is not good enough.
void AdaptiveTrace::run_lines() {
  static_assert(LINES_PER_PANEL == panel_weights.size());
  std::vector<std::uint32_t> list = mixed_;
  const std::size_t n_channels = pass_->channels();
  for (panels_ = 1; !list.empty(); panels_ *= 2) {
    const SampleSetup none;
    impl_.upload_pass(job_, *pass_, none, limits());
    impl_.fill(BIND_PIXELS, list);
    const std::size_t per_entry = LINES_PER_PANEL * std::size_t{panels_};
    reserve_output(std::min(most_slots(), list.size() * per_entry + BLOCK_PIXELS));
    ComputePipeline& kernel = impl_.bound_kernel(Kernel::lines, constants(none, PIXELS_LISTED));
    std::vector<float> values(n_channels * list.size());
    std::vector<double> errors(list.size());
    stage("lines", list.size(), [&] {
      run_list(kernel, list, per_entry, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
        for (std::size_t i = 0; i < n; ++i)
          errors[first + i] = add_lines(sums, i * per_entry, &values[n_channels * (first + i)]);
      });
    });
    // The target is the rms over all pixels, and few lie on edges: the largest errors are worked on until
    // the others fit into the budget together. Some of it is left to the pixels of the next round, or they
    // would have to become exact.
    const double budget = share_of_budget * irradiance_target_ * irradiance_target_ *
                              static_cast<double>(n_lit_ + n_outlines_ + mixed_.size()) -
                          mixed_squares_;
    const double most = panels_ < most_panels ? largest_error_to_keep(errors, share_of_round * budget,
                                                                      most_allowance * irradiance_target_)
                                              : HUGE_VAL;
    std::vector<std::uint32_t> next;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (errors[i] > most) {
        next.push_back(list[i]);
        continue;
      }
      mixed_squares_ += errors[i] * errors[i];
      write(list[i], 0, Sums{&values[n_channels * i], 1});
    }
    list = std::move(next);
  }
  panels_ = 1;
}

// The largest of all passes: each holds other pitches.
void AdaptiveTrace::note_estimate() {
  const auto n_lit = static_cast<double>(std::max<std::size_t>(1, n_lit_));
  const auto n_all = static_cast<double>(std::max<std::size_t>(1, n_lit_ + n_outlines_ + n_mixed_));
  const Sensor& sensor = job_.camera.sensor;
  ErrorEstimate estimate;
  estimate.phase_rad = std::sqrt(phase_squares_ / n_lit + rounding_rad_ * rounding_rad_);
  estimate.gray = std::sqrt((gray_squares_ + mixed_squares_) / n_all) * sensor.gain_dn / sensor.max_dn();
  if (const auto& before = job_.out->estimate) {
    estimate.phase_rad = std::max(estimate.phase_rad, before->phase_rad);
    estimate.gray = std::max(estimate.gray, before->gray);
  }
  estimate.mixed_share = static_cast<double>(n_outlines_ + n_mixed_) / n_all;
  estimate.facets_share = static_cast<double>(n_facets_) / n_all;
  estimate.smooth_share = static_cast<double>(n_smooth_) / n_all;
  job_.out->estimate = estimate;
}

}  // namespace

bool can_trace_adaptively(const TraceJob& job, const std::vector<PassPlan>& passes,
                          const VkPhysicalDeviceLimits& limits) {
  // Images that are no cosines (gray code, pattern images, a response that is not linear) have edges of their
  // own in the pixels, which nothing here looks for.
  for (const PassPlan& pass : passes)
    if (!pass.direct.empty() || std::any_of(pass.pitches.begin(), pass.pitches.end(),
                                            [](const PitchSlot& p) { return p.harmonic > 1; }))
      return false;
  const std::size_t n_pixels = job.out->mean.size();
  if (n_pixels * sizeof(gpu::vec4) > limits.maxStorageBufferRange || n_pixels > limits.maxTexelBufferElements)
    return false;
  const Lens& lens = job.camera.lens;
  // The closed form and the scan lines know neither defocus, raster or texture nor light from elsewhere.
  const Projector& projector = *job.twin.projector;
  if (projector.optics || projector.pixel_structure || !job.scene.maps.empty() || job.twin.render.bounces > 0)
    return false;
  return !job.camera.optics && job.twin.render.pixel_fill > 0.0 && lens.width() < list_limit_px &&
         lens.height() < list_limit_px && job.scene.n_surfaces < exact_float;
}

void trace_adaptively(Renderer::Impl& impl, const TraceJob& job, const std::vector<PassPlan>& passes,
                      const Sampling& sampling) {
  AdaptiveTrace(impl, job, sampling).run(passes);
}

}  // namespace fringetwin::render
