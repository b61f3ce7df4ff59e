// SPDX-License-Identifier: Apache-2.0
// Traces a camera adaptively (docs/PHYSICS.md): a ray through every pixel's centre decides what the pixel
// needs, and more rays are spent only where the estimated error is above the targets. Internal to render/
// (includes volk).
//   adaptive_trace.cpp      looks at every pixel's neighbourhood and sorts the pixels
//   adaptive_surfaces.cpp   pixels without an edge, and edges of meshes that are clipped exactly
//   adaptive_lines.cpp      the other edges
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/base/pixel_list.hpp"
#include "render/trace/adaptive_error.hpp"
#include "render/trace/sample_table.hpp"
#include "render/trace/sum_targets.hpp"
#include "render/trace/trace_device.hpp"
#include "twin/base/stopwatch.hpp"

namespace fringetwin::render {

// Half of what the target allows is left to the pixels with an estimate of their own (the others: the
// closed form's), and none of them may have more than this many times the rms target.
constexpr double kShareOfBudget = 0.5, kMostAllowance = 16.0;

/// The mark of a pixel that no edge is known to cross: its phase counts, unless scan lines find one.
constexpr std::uint32_t kInsideSurface = 1U << 30;

/// The sums that a dispatch wrote: channel by channel, `stride` slots each.
struct Sums {
  const float* values = nullptr;
  std::size_t stride = 0;
  double at(std::size_t channel, std::size_t slot) const {
    return static_cast<double>(values[channel * stride + slot]);
  }
};

/// Returns true where the adaptive trace serves the scene: without depth of field, projector optics and
/// pixels, albedo maps and images that are no cosines (but for added harmonics), and within the
/// device's limits.
bool can_trace_adaptively(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const std::vector<PassPlan>& passes, const VkPhysicalDeviceLimits& limits);
/// Traces all passes to the targets of `sampling` and fills job.out, its estimate included. Needs
/// can_trace_adaptively() and an uploaded scene. Throws LoopLimit where the driver cuts an invocation's
/// loops.
void trace_adaptively(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes,
                      const Sampling& sampling);
/// Thrown where the driver's limit of loop iterations cuts an invocation short.
struct LoopLimit {};

/// One run: its pixels in lists by what they need, and the errors so far.
class AdaptiveTrace {
 public:
  AdaptiveTrace(TraceDevice& device, const TraceJob& job, const Sampling& sampling);
  /// Throws LoopLimit where the driver cuts an invocation short.
  void run(const std::vector<PassPlan>& without_harmonics);

 private:
  SpecConstants constants(const SampleSetup& samples, std::uint32_t list) const {
    SpecConstants c = make_constants(job_, samples, *pass_);
    c[SPEC_PIXEL_LIST] = list;
    return c;
  }

  AdaptiveTargets limits() const {
    const double share = std::sqrt(1.0 - kShareOfBudget);  // the closed form's
    return {share * phase_target_rad_, share * irradiance_target_ / weight_, closed_form_ ? 0 : base_order(),
            panels_, stretches_};
  }

  int base_order() const { return device_.precise() ? 3 : 2; }

  static void must_finish(bool finished) {
    if (!finished) throw LoopLimit();
  }

  // Runs a step and notes its cost, for benchmarks.
  template <class Work>
  void stage(const char* name, std::size_t pixels, Work work) {
    const Stopwatch watch;
    const std::uint64_t rays = job_.out->rays;
    work();
    job_.out->stages.push_back({name, pixels, job_.out->rays - rays, 1e3 * watch.elapsed().cpu_s});
  }

  /// True where harmonics are formed from the fundamental but for pixels in lists.
  bool formed() const { return job_.harmonics.formed(); }
  void plan(const PassPlan& pass);
  void use_plain_sums(PixelState written);
  void use_own_sums();
  void take_back_unformed(std::vector<std::uint32_t>* pieces);
  void foresee_kernels();
  void clear_probe();
  void probe();
  void run_pass();
  void classify();
  void run_gauss(const std::vector<std::uint32_t>& list, int order);
  void run_checked(const std::vector<std::uint32_t>& list);
  void sort_out_uncrossed();
  struct FacetErrors {
    double irradiance = 0.0, phase_rad = 0.0;
    int answer = 0;  ///< FACETS_ (shared.h)
  };
  FacetErrors add_squares(const Sums& sums, std::size_t slot, std::size_t n_squares, bool by_piece,
                          float* values) const;
  std::vector<std::uint32_t> run_facets(const std::vector<std::uint32_t>& list, std::uint32_t kind,
                                        double share);
  void run_pieces(std::vector<std::uint32_t> rest);
  void run_outlines(const std::vector<std::uint32_t>& list);
  void run_lines();
  struct LineErrors {
    double irradiance = 0.0;  ///< of an image
    double phase_rad = 0.0;   ///< largest of all pitches
    bool crossed = false;     ///< a border between surfaces was found
  };
  std::vector<float> trace_lines(const std::vector<std::uint32_t>& list, std::vector<LineErrors>* found);
  double line_error(const LineErrors& found, bool inside) const;
  void keep_lines(double most, std::vector<std::uint32_t>* list, std::vector<float>* values,
                  std::vector<LineErrors>* found, double* spent);
  LineErrors add_lines(const Sums& sums, std::size_t slot, float* values) const;
  void note_estimate();

  // Runs `kernel` over `list` with `per_entry` invocations each and hands each part to
  // use(first entry, number of entries, sums).
  template <class Use>
  void run_list(ComputePipeline& kernel, const std::vector<std::uint32_t>& list, std::size_t per_entry,
                std::uint32_t n_samples, Use use);
  template <class Use>
  void run_rule(const std::vector<std::uint32_t>& list, int order, Use use);
  void reserve_output(std::size_t slots);
  /// Returns a kernel that works on a list and takes no samples, everything it reads in place.
  ComputePipeline& list_kernel(Kernel kernel, std::uint32_t kind, const std::vector<std::uint32_t>& list,
                               std::size_t per_entry = 1);
  /// Returns what each of n invocations said of its pixel (PIXEL_, BORDER_, FACETS_).
  const std::int32_t* answers(std::size_t n) { return device_.read<std::int32_t>(BIND_OBJECTS, n); }
  /// Copies the sums of a list's entries first ... first + n - 1 to values[entry][channel].
  void gather(const Sums& sums, std::size_t first, std::size_t n, std::vector<float>* values) const;
  /// Returns how many slots of sums one dispatch may write.
  std::size_t most_slots() const;

  void write(std::uint32_t code, std::size_t slot, const Sums& sums) {
    const auto [x, y] = listed_pixel(code);
    for (std::size_t c = 0; c < targets_.size(); ++c)
      if (targets_[c].image)
        (*targets_[c].image)(x, y) = sums.values[c * sums.stride + slot] * targets_[c].factor;
    if (formed()) note_sums(x, y, slot, sums);
  }
  // Keeps the harmonics of a pixel with sums of its own, and remembers which pixels have them.
  void note_sums(int x, int y, std::size_t slot, const Sums& sums) {
    const std::size_t place =
        static_cast<std::size_t>(y) * job_.out->mean.width + static_cast<std::size_t>(x);
    states_[place] = written_;
    if (written_ != PixelState::own) return;
    keep_harmonics(whole_, static_cast<std::uint32_t>(place), job_.out,
                   [&](std::size_t c) { return sums.values[c * sums.stride + slot] * targets_[c].factor; });
  }

  bool changes_along_y(std::uint32_t code) const;
  /// Returns true when the rays of 5 x 5 pixels saw one surface: the pixel and its neighbours are whole.
  bool far_from_edges(std::uint32_t code) const;
  void to_scan_lines(std::uint32_t code, std::uint32_t mark) {
    mixed_.push_back((code & 0x3fffffffU) | mark | (changes_along_y(code) ? 1U << 31 : 0U));
  }

  // Returns the error of an irradiance image, given those of its mean and of its cosine and sine (with what
  // is formed from them).
  double irradiance_error(double mean, double fringe) const {
    return job_.twin.fringes.mean * std::abs(mean) +
           job_.twin.fringes.amplitude * contrast_ * weight_ * fringe;
  }

  void count_error(double phase_rad, double irradiance) {
    phase_squares_ += phase_rad * phase_rad;
    gray_squares_ += irradiance * irradiance;
    ++n_lit_;
  }

  TraceDevice& device_;
  const TraceJob& job_;
  const PassPlan* pass_ = nullptr;
  PassPlan whole_, plain_;  // all pairs; the fundamentals alone, where harmonics are formed
  bool first_pass_ = true;
  double contrast_ = job_.twin.fringes.largest_contrast();
  double weight_ = 1.0;  // of an error of the contrast, with that of the harmonics that are formed
  PixelState written_ = PixelState::plain;
  std::vector<PixelState> states_;
  // The probe buffer as the host sees it: valid in active blocks and 2 px around them.
  const gpu::vec4* seen_ = nullptr;
  bool closed_form_ = true;
  std::uint32_t panels_ = 1, stretches_;
  std::vector<SumTarget> targets_;
  double irradiance_target_ = 0.0, rounding_rad_ = 0.0, phase_target_rad_ = 0.0;
  std::vector<std::uint32_t> regular_, smooth_, facets_, outlines_, mixed_;
  double phase_squares_ = 0.0, gray_squares_ = 0.0, mixed_squares_ = 0.0;
  std::size_t n_lit_ = 0, n_facets_ = 0, n_smooth_ = 0, n_mixed_ = 0, n_outlines_ = 0;
};

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
    must_finish(device_.dispatch(kernel, push, static_cast<std::uint32_t>(groups), job_.out));
    const std::size_t stride = groups * BLOCK_PIXELS;
    use(first, n, Sums{device_.read<float>(BIND_OUTPUT, (pass_->channels() + 2) * stride), stride});
  }
}

}  // namespace fringetwin::render
