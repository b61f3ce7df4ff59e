// SPDX-License-Identifier: Apache-2.0
// The adaptive trace: a ray through every pixel's centre decides what the pixel needs (docs/PHYSICS.md).
//   nothing, or one surface all around    closed form, no further ray
//   one surface, but bent too much        Gauss-Legendre, two orders compared
//   facets of one lit mesh                clipped exactly, no further ray
//   an edge                               scan lines that find it, more of them until they agree
#include "render/trace/adaptive_trace.hpp"

#include "render/pattern/waveform.hpp"
#include "render/trace/pixel_blocks.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

constexpr std::size_t kSlotsPerDispatch = 4U << 20;
constexpr std::size_t kExactFloat = 1 << 24;  // identities travel as floats
// The errors of rounding, as shares of single_precision_error_rad: on the paper's rig 3.3e-5 and 3e-6 rad,
// what the scenes of adaptive_test have on average and a tenth, which the outline of many facets takes.
constexpr double kRoundingSingle = 0.66, kRoundingDouble = 0.06;
// Bounds of formed harmonics, of the targets: of a pixel that is never taken back, of one that always is, and
// the sum of their squares per pixel.
constexpr double kAlwaysFormed = 0.4, kMostFormed = 8.0, kShareOfFormed = 0.25;

}  // namespace

AdaptiveTrace::AdaptiveTrace(TraceDevice& device, const TraceJob& job, const Sampling& sampling)
    : device_(device), job_(job), stretches_(job.tuning.line_stretches) {
  const Sensor& sensor = job.camera.sensor;
  irradiance_target_ = sampling.gray_error * sensor.max_dn() / sensor.gain_dn;
  rounding_rad_ =
      (device.precise() ? kRoundingDouble : kRoundingSingle) * single_precision_error_rad(job.twin);
  const double left = sampling.phase_error_rad * sampling.phase_error_rad - rounding_rad_ * rounding_rad_;
  phase_target_rad_ = left > 0.0 ? std::sqrt(left) : 0.25 * sampling.phase_error_rad;
}

void AdaptiveTrace::run(const std::vector<PassPlan>& without_harmonics) {
  const std::vector<PassPlan>& passes = formed() ? job_.harmonics.own : without_harmonics;
  if (!passes.empty()) plan(passes.front());
  stage("probe", job_.blocks.size() * BLOCK_PIXELS, [&] { probe(); });
  for (std::size_t i = 0; i < passes.size(); ++i) {
    if (i > 0) plan(passes[i]);
    first_pass_ = i == 0;
    run_pass();
    note_estimate();
  }
}

// Takes up a pass: that of most pixels, and that of pixels with harmonics of their own.
void AdaptiveTrace::plan(const PassPlan& pass) {
  whole_ = pass;
  plain_ = formed() ? pass.without_harmonics() : PassPlan{};
  foresee_kernels();
}

// Traces the pairs that most pixels need from here on: all, or the fundamentals alone.
void AdaptiveTrace::use_plain_sums(PixelState written) {
  written_ = written;
  pass_ = formed() ? &plain_ : &whole_;
  weight_ = formed() ? job_.harmonics.worst() : 1.0;
  targets_ = sum_targets(job_.twin, *pass_, first_pass_, job_.out);
}

// Traces all pairs from here on.
void AdaptiveTrace::use_own_sums() {
  written_ = PixelState::own;
  pass_ = &whole_;
  weight_ = 1.0;
  targets_ = sum_targets(job_.twin, *pass_, first_pass_, job_.out);
}

// Has the kernels made in the background that most scenes need, in the order of their use.
void AdaptiveTrace::foresee_kernels() {
  const SampleSetup samples;
  std::vector<KernelStore::Key> keys;
  const auto add = [&](Kernel kernel, std::uint32_t list) {
    const bool plain = kernel == Kernel::closed_form || (kernel == Kernel::facets && list == PIXELS_LISTED);
    pass_ = plain && formed() ? &plain_ : &whole_;
    keys.push_back(device_.kernel_key(kernel, constants(samples, list)));
  };
  add(Kernel::closed_form, 0);
  if (!job_.scene.meshes.empty()) add(Kernel::facets, PIXELS_OUTLINE);
  add(Kernel::border, PIXELS_LISTED);
  if (!job_.scene.meshes.empty())
    for (const std::uint32_t list : {PIXELS_LISTED, PIXELS_PIECES}) add(Kernel::facets, list);
  add(Kernel::lines, PIXELS_LISTED);
  add(Kernel::trace, PIXELS_LISTED);
  device_.kernels().foresee(keys);
}

std::size_t AdaptiveTrace::most_slots() const {
  const std::size_t slots = kMostOutputBytes / ((pass_->channels() + 2) * sizeof(float));
  return std::min(kSlotsPerDispatch, slots / BLOCK_PIXELS * BLOCK_PIXELS);  // whole work groups write
}

bool AdaptiveTrace::far_from_edges(std::uint32_t code) const {
  const auto [x, y] = listed_pixel(code);
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  const auto place = [&](int i, int j) { return seen_[static_cast<std::size_t>(j) * width + i].w; };
  for (int j = std::max(0, y - 2); j <= std::min(height - 1, y + 2); ++j)
    for (int i = std::max(0, x - 2); i <= std::min(width - 1, x + 2); ++i)
      if (place(i, j) != place(x, y)) return false;
  return true;
}

// Returns true where the things that the centre rays saw change more along y than along x: scan lines should
// run across the edge.
bool AdaptiveTrace::changes_along_y(std::uint32_t code) const {
  const auto [x, y] = listed_pixel(code);
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  const auto at = [&](int i, int j) {
    const auto k = static_cast<std::size_t>(std::clamp(j, 0, height - 1)) * static_cast<std::size_t>(width) +
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

void AdaptiveTrace::reserve_output(std::size_t slots) {
  device_.reserve(BIND_OUTPUT, slots * (pass_->channels() + 2) * sizeof(float));
  device_.reserve(BIND_OBJECTS, slots * sizeof(std::int32_t));
}

ComputePipeline& AdaptiveTrace::list_kernel(Kernel kernel, std::uint32_t kind,
                                            const std::vector<std::uint32_t>& list, std::size_t per_entry) {
  const SampleSetup none;
  device_.upload_pass(job_, *pass_, none, limits());
  device_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() * per_entry + BLOCK_PIXELS));
  return device_.bound_kernel(kernel, constants(none, kind));
}

void AdaptiveTrace::gather(const Sums& sums, std::size_t first, std::size_t n,
                           std::vector<float>* values) const {
  const std::size_t n_channels = pass_->channels();
#pragma omp parallel for
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < n_channels; ++c)
      (*values)[n_channels * (first + i) + c] = sums.values[c * sums.stride + i];
}

// Has "nothing was seen" stand wherever the neighbourhood of a traced pixel reaches beyond the active blocks.
// The whole image is not written: of a small object in a large one that took a seventh of the frame's time.
void AdaptiveTrace::clear_probe() {
  constexpr int kReachPx = 2;  // of closed_form.comp and far_from_edges()
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  const bool below = !job_.scene.below_surfaces.empty();
  Buffer& places =
      device_.reserve(BIND_PROBE, (below ? 1 + PROBE_MORE : 1) * job_.out->mean.size() * sizeof(gpu::vec4));
  if (below) return places.clear();  // what lies below stands in tables of its own behind that of the image
  std::vector<Buffer::Part> parts;
  for (const PixelRun& run : pixels_around(job_.blocks, width, height, kReachPx))
    parts.push_back({sizeof(gpu::vec4) *
                         (static_cast<std::size_t>(run.y_px) * width + static_cast<std::size_t>(run.x_px)),
                     sizeof(gpu::vec4) * static_cast<std::size_t>(run.n_px)});
  places.clear(parts);
}

// Traces the centre ray of every pixel and notes the object that it saw.
void AdaptiveTrace::probe() {
  const auto n_pixels = job_.out->mean.size();
  clear_probe();
  const PassPlan nothing;
  pass_ = &nothing;
  const SampleSetup none;
  device_.upload_samples(none);
  device_.upload_pass(job_, nothing, none, limits());
  reserve_output(1);
  ComputePipeline& kernel = device_.bound_kernel(Kernel::probe, constants(none, 0));
  const std::size_t band = kSlotsPerDispatch / BLOCK_PIXELS;
  for (std::size_t first = 0; first < job_.blocks.size(); first += band) {
    gpu::Push push{};
    const std::size_t n = std::min(band, job_.blocks.size() - first);
    push.first_block = static_cast<gpu::uint>(first);
    push.sentinel = SENTINEL_LOOPS;
    must_finish(device_.dispatch(kernel, push, static_cast<std::uint32_t>(n), job_.out));
  }
  job_.out->rays += job_.blocks.size() * BLOCK_PIXELS;

  seen_ = device_.read<gpu::vec4>(BIND_PROBE, n_pixels);
  const auto& materials = job_.scene.materials;
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  const auto note = [&](std::size_t i) {
    if (seen_[i].w == 0.0F) return;
    const float place = std::abs(seen_[i].w) - 1.0F;
    const auto after = std::upper_bound(materials.begin(), materials.end(), place,
                                        [](float p, const gpu::vec4& m) { return p < m.w; });
    job_.out->object.data[i] = job_.scene.object_of_primitive[after - materials.begin() - 1];
  };
#pragma omp parallel for
  for (std::size_t b = 0; b < job_.blocks.size(); ++b) {
    const auto [x0, y0] = corner_of(job_.blocks[b]);
    for (int y = y0; y < std::min(y0 + BLOCK_HEIGHT, height); ++y)
      for (int x = x0; x < std::min(x0 + BLOCK_WIDTH, width); ++x)
        note(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x));
  }
}

void AdaptiveTrace::run_pass() {
  closed_form_ = !device_.precise();
  phase_squares_ = gray_squares_ = mixed_squares_ = 0.0;
  n_lit_ = n_outlines_ = 0;
  regular_.clear();
  smooth_.clear();
  facets_.clear();
  outlines_.clear();
  mixed_.clear();
  if (formed()) states_.assign(job_.out->mean.size(), PixelState::plain);
  use_plain_sums(PixelState::plain);
  stage("classify", job_.blocks.size() * BLOCK_PIXELS, [&] { classify(); });
  n_smooth_ = smooth_.size();
  n_facets_ = facets_.size();
  if (!regular_.empty()) stage("gauss", regular_.size(), [&] { run_gauss(regular_, base_order()); });
  use_own_sums();
  if (!outlines_.empty()) stage("outlines", outlines_.size(), [&] { run_outlines(outlines_); });
  if (!mixed_.empty()) stage("border", mixed_.size(), [&] { sort_out_uncrossed(); });
  std::vector<std::uint32_t> pieces;
  use_plain_sums(PixelState::facets);
  if (!facets_.empty())
    stage("facets", facets_.size(), [&] { pieces = run_facets(facets_, PIXELS_LISTED, 0.25); });
  use_own_sums();
  if (formed()) stage("unformed", job_.blocks.size() * BLOCK_PIXELS, [&] { take_back_unformed(&pieces); });
  if (!pieces.empty()) run_pieces(std::move(pieces));
  if (!smooth_.empty()) stage("smooth", smooth_.size(), [&] { run_checked(smooth_); });
  n_mixed_ = mixed_.size();
  run_lines();
}

// Finds the pixels whose harmonics cannot be formed from what has been written, and puts them into the lists:
// the largest bounds, until those of the others fit into the budget.
void AdaptiveTrace::take_back_unformed(std::vector<std::uint32_t>* pieces) {
  const FormedLimits limits{kAlwaysFormed * irradiance_target_, kAlwaysFormed * phase_target_rad_,
                            job_.twin.sampled_side_px(job_.camera)};
  std::vector<std::vector<FormedError>> found(job_.blocks.size());
  double irradiance_squares = 0.0, phase_squares = 0.0;
#pragma omp parallel for schedule(dynamic, 16) reduction(+ : irradiance_squares, phase_squares)
  for (std::size_t b = 0; b < job_.blocks.size(); ++b) {
    const auto [x0, y0] = corner_of(job_.blocks[b]);
    const FormedErrors kept = find_unformed(*job_.out, job_.harmonics, states_, x0, y0, limits, &found[b]);
    irradiance_squares += kept.irradiance_squares;
    phase_squares += kept.phase_squares;
  }
  std::vector<FormedError> large;
  for (const auto& f : found) large.insert(large.end(), f.begin(), f.end());
  std::vector<double> worse;
  for (const FormedError& e : large)
    worse.push_back(std::max(e.irradiance / irradiance_target_, e.phase_rad / phase_target_rad_));
  const double most = largest_error_to_keep(worse, kShareOfFormed * static_cast<double>(n_lit_), kMostFormed);
  for (std::size_t i = 0; i < large.size(); ++i) {
    if (worse[i] <= most) {
      irradiance_squares += large[i].irradiance * large[i].irradiance;
      phase_squares += large[i].phase_rad * large[i].phase_rad;
      continue;
    }
    const std::uint32_t place = large[i].place;
    (states_[place] == PixelState::facets ? *pieces : smooth_)
        .push_back(list_code_at(place, job_.out->mean.width));
    --n_lit_;  // counted again with its own sums
  }
  gray_squares_ += irradiance_squares;
  phase_squares_ += phase_squares;
}

// Evaluates the closed form over all blocks and sorts the pixels that need more into the lists.
void AdaptiveTrace::classify() {
  const SampleSetup none;
  device_.upload_pass(job_, *pass_, none, limits());
  const std::size_t band = std::max<std::size_t>(1, most_slots() / BLOCK_PIXELS);
  const std::size_t most = std::min(band, job_.blocks.size());
  reserve_output(most * BLOCK_PIXELS);
  ComputePipeline& kernel = device_.bound_kernel(Kernel::closed_form, constants(none, 0));
  const int width = job_.out->mean.width, height = job_.out->mean.height;
  for (std::size_t first = 0; first < job_.blocks.size(); first += band) {
    const std::size_t n = std::min(band, job_.blocks.size() - first);
    gpu::Push push{};
    push.first_block = static_cast<gpu::uint>(first);
    push.n_blocks_band = static_cast<gpu::uint>(n);
    push.sentinel = SENTINEL_LOOPS;
    must_finish(device_.dispatch(kernel, push, static_cast<std::uint32_t>(n), job_.out));
    const std::size_t stride = n * BLOCK_PIXELS, channels = pass_->channels();
    const Sums sums{device_.read<float>(BIND_OUTPUT, (channels + 2) * stride), stride};
    const auto* kinds = answers(stride);
    scatter_sums(job_, targets_, first, n, sums.values);
    for (std::size_t b = 0; b < n; ++b) {
      const auto [x0, y0] = corner_of(job_.blocks[first + b]);
      for (int y = 0; y < BLOCK_HEIGHT && y0 + y < height; ++y)
        for (int x = 0; x < BLOCK_WIDTH && x0 + x < width; ++x) {
          const std::size_t slot = b * BLOCK_PIXELS + static_cast<std::size_t>(y * BLOCK_WIDTH + x);
          const int kind = kinds[slot];
          if (kind == PIXEL_DONE) {
            if (sums.values[slot] == 0.0F) continue;
            count_error(sums.at(channels, slot), weight_ * sums.at(channels + 1, slot));
            if (!closed_form_) regular_.push_back(list_code(x0 + x, y0 + y));
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

// Notes the estimate of this pass where it is larger than those of the passes before: each holds other
// pitches.
void AdaptiveTrace::note_estimate() {
  const auto n_lit = static_cast<double>(std::max<std::size_t>(1, n_lit_));
  const auto n_all = static_cast<double>(std::max<std::size_t>(1, n_lit_ + n_outlines_ + n_mixed_));
  const Sensor& sensor = job_.camera.sensor;
  ErrorEstimate estimate{
      .phase_rad = std::sqrt(phase_squares_ / n_lit + rounding_rad_ * rounding_rad_),
      .gray = std::sqrt((gray_squares_ + mixed_squares_) / n_all) * sensor.gain_dn / sensor.max_dn()};
  estimate.gray_inside =
      n_facets_ > 0 ? estimate.gray : std::sqrt(gray_squares_ / n_lit) * sensor.gain_dn / sensor.max_dn();
  if (const auto& before = job_.out->estimate) {
    estimate.gray_inside = std::max(estimate.gray_inside, before->gray_inside);
    estimate.phase_rad = std::max(estimate.phase_rad, before->phase_rad);
    estimate.gray = std::max(estimate.gray, before->gray);
  }
  estimate.mixed_share = static_cast<double>(n_outlines_ + n_mixed_) / n_all;
  estimate.facets_share = static_cast<double>(n_facets_) / n_all;
  estimate.smooth_share = static_cast<double>(n_smooth_) / n_all;
  job_.out->estimate = estimate;
}

bool can_trace_adaptively(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const std::vector<PassPlan>& passes, const VkPhysicalDeviceLimits& limits) {
  // Images that are no cosines (gray code, pattern images, a response that is not linear) have edges of their
  // own in the pixels, which nothing here looks for. Harmonics that are added are few and weak.
  const bool weak = is_linear(twin.projector->response) && twin.fringes.waveform.kind == Waveform::Kind::sine;
  for (const PassPlan& pass : passes)
    if (!pass.direct.empty() ||
        (!weak && std::ranges::any_of(pass.pitches, [](const PitchSlot& p) { return p.harmonic > 1; })))
      return false;
  const Lens& lens = camera.lens;
  const std::size_t n_pixels = static_cast<std::size_t>(lens.width()) * lens.height(),
                    n_texels = n_pixels * (scene.below_surfaces.empty() ? 1 : 1 + PROBE_MORE);
  if (n_texels * sizeof(gpu::vec4) > limits.maxStorageBufferRange || n_texels > limits.maxTexelBufferElements)
    return false;
  // The closed form and the scan lines know neither defocus, a blur that varies, raster or texture nor light
  // of a lamp.
  const Projector& projector = *twin.projector;
  if (projector.optics || projector.pixel_structure || projector.has_blur_field() || !scene.maps.empty() ||
      twin.room.has_lamp())
    return false;
  return !camera.optics && twin.render.pixel_fill > 0.0 && lens.width() < kListLimitPx &&
         lens.height() < kListLimitPx && scene.n_surfaces < kExactFloat;
}

void trace_adaptively(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes,
                      const Sampling& sampling) {
  AdaptiveTrace(device, job, sampling).run(passes);
}

}  // namespace fringetwin::render
