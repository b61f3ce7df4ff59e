// SPDX-License-Identifier: Apache-2.0
#include "measure/decode/decode.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "measure/decode/decode_input.hpp"
#include "measure/decode/order_repair.hpp"
#include "measure/decode/phase.hpp"
#include "measure/decode/phase_noise.hpp"
#include "measure/decode/unwrap.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/statistics.hpp"
#include "twin/image/rows_of_images.hpp"

namespace fringetwin::measure {
namespace {

constexpr float kInvalid = std::numeric_limits<float>::quiet_NaN();

double percentile_999(const ImageF& image) {
  std::vector<float> values;
  values.reserve(image.size());
  std::ranges::copy_if(image.data, std::back_inserter(values), [](float v) { return std::isfinite(v); });
  return values.empty() ? 0.0 : lower_quantile(values, 0.999);
}

/// Decodes one direction of one camera: masks, phases, sigma, orders, repair.
class DirectionDecoder {
 public:
  DirectionDecoder(const CameraImages& images, const Fringes& fringes, int direction,
                   const std::vector<int>& steps, const DecodeOptions& options, ImageU8& flags)
      : images_(images),
        fringes_(fringes),
        direction_(fringes.directions[direction]),
        options_(options),
        input_(collect_direction(images, fringes, direction, steps)),
        steps_(steps),
        flags_(flags),
        width_(flags.width),
        height_(flags.height) {}

  DirectionDecode run() {
    plan();
    out_.axis = direction_.axis;
    out_.pitches_px = direction_.pitches_px;
    out_.finest = direction_.finest();
    out_.coordinate_px = ImageD(width_, height_, static_cast<double>(kInvalid));
    out_.coordinate_sigma_px = ImageF(width_, height_, kInvalid);
    out_.sigma_rad = ImageF(width_, height_, kInvalid);
    if (fringes_.steps == 0) {
      code_modulation();
      decode_code();
    } else {
      solve_phases();
      choose_noise();
      if (fringes_.unwrap == Unwrap::gray) learn_code_margins();
      throw_if_cancelled();
      unwrap_phases();
      throw_if_cancelled();
      mend_orders();
    }
    return std::move(out_);
  }

 private:
  struct RowScratch {
    std::vector<float> variance, coordinate_variance, threshold;
    std::vector<PitchRow> pitches;
    GrayRow gray_row;
    RowsOfImages gray_rows;
    GrayScratch gray;
  };

  void plan();
  void code_modulation();
  void decode_code();
  void solve_phases();
  void choose_noise();
  void learn_code_margins();
  void unwrap_phases();
  void mend_orders();

  double min_amplitude(const ImageF& amplitude) const {
    return images_.radiance ? kRadianceModulation * percentile_999(amplitude) : options_.min_modulation_dn;
  }
  double pitch_variance(std::size_t pitch, std::size_t at, double gray_variance) const;
  void mask_row(int y);
  void variance_row(int y, RowScratch& scratch) const;
  void order_row(int y, RowScratch& scratch);
  void finish_row(int y, const RowScratch& scratch);
  void point_gray_row(int y, RowScratch& scratch) const;
  std::size_t row(int y) const { return flags_.index(0, y); }
  bool in_range(double x_px) const { return !range_.known || (x_px >= range_.begin && x_px < range_.end); }
  /// Unwrapping plans list the pitches in their own order.
  std::vector<int> plan_order() const;

  const CameraImages& images_;
  const Fringes& fringes_;
  const DirectionFringes& direction_;
  const DecodeOptions& options_;
  DirectionImages input_;
  std::vector<int> steps_;
  ImageU8& flags_;
  int width_, height_;
  DirectionDecode out_;
  CoordinateRange range_;
  std::optional<StepSolver> solver_;
  HeterodynePlan heterodyne_;
  HierarchicalPlan hierarchical_;
  GrayPlan gray_;
  NoiseModel noise_{kRoundingVariance};
  double min_amplitude_ = 0.0;
};

void DirectionDecoder::plan() {
  const auto& size = direction_.axis == Axis::x ? options_.projector_width_px : options_.projector_height_px;
  if (size) range_ = {-0.5, *size - 0.5, true};
  if (fringes_.steps > 0) solver_.emplace(steps_, fringes_.steps);
  switch (fringes_.unwrap) {
    case Unwrap::heterodyne:
      heterodyne_ = plan_heterodyne(direction_, range_);
      break;
    case Unwrap::hierarchical:
      hierarchical_ = plan_hierarchical(direction_, range_);
      break;
    case Unwrap::gray:
      gray_ = plan_gray(direction_, fringes_.steps, range_);
      break;
    case Unwrap::none:
      out_.unwrapped = false;
      break;
  }
  gray_.min_bit_difference_dn = options_.min_bit_difference_dn;
}

// ---- Gray code only ---------------------------------------------------------------------------------

/// amplitude = half of white - black where there are such images, else of the largest pair difference.
void DirectionDecoder::code_modulation() {
  const bool reference = images_.white && images_.black;
  ImageF amplitude(width_, height_), mean(width_, height_);
  if (reference) {
    for (std::size_t i = 0; i < mean.size(); ++i) {
      amplitude.data[i] = 0.5f * ((*images_.white)[i] - (*images_.black)[i]);
      mean.data[i] = 0.5f * ((*images_.white)[i] + (*images_.black)[i]);
    }
  } else {
    const float share = 0.5f / static_cast<float>(input_.bits.size());
    for (std::size_t b = 0; b < input_.bits.size(); ++b)
      for (std::size_t i = 0; i < mean.size(); ++i) {
        const float p = (*input_.bits[b])[i], q = (*input_.inverse[b])[i];
        amplitude.data[i] = std::max(amplitude.data[i], 0.5f * std::fabs(p - q));
        mean.data[i] += share * (p + q);
      }
  }
  min_amplitude_ = min_amplitude(amplitude);
  if (images_.radiance) gray_.min_bit_difference_dn = 2.0 * min_amplitude_;
  out_.amplitude_dn.push_back(std::move(amplitude));
  out_.mean_dn = std::move(mean);
}

void DirectionDecoder::decode_code() {
  const auto n = static_cast<std::size_t>(width_);
  const double word_px = direction_.pitches_px.front() * (gray_.complementary ? 0.5 : 1.0);
  const double sigma_rad = kTwoPi / direction_.pitches_px.front() * word_px / std::sqrt(12.0);
#pragma omp parallel if (height_ > kSerialRows)
  {
    RowScratch scratch;
    scratch.coordinate_variance.resize(n);
#pragma omp for schedule(static)
    for (int y = 0; y < height_; ++y) {
      point_gray_row(y, scratch);
      read_gray_row(gray_, scratch.gray_row, scratch.threshold.data(), width_, scratch.gray);
      double* x_px = out_.coordinate_px.data.data() + row(y);
      gray_only_row(gray_, width_, scratch.gray, x_px, scratch.coordinate_variance.data());
      for (std::size_t x = 0; x < n; ++x) {
        const std::size_t at = row(y) + x;
        if (!(static_cast<double>(out_.amplitude_dn[0].data[at]) >= min_amplitude_)) {
          flags_.data[at] |= kLowModulation;
          x_px[x] = static_cast<double>(kInvalid);
        }
      }
      finish_row(y, scratch);
      for (std::size_t x = 0; x < n; ++x)
        if (std::isfinite(x_px[x])) out_.sigma_rad.data[row(y) + x] = static_cast<float>(sigma_rad);
    }
  }
}

void DirectionDecoder::point_gray_row(int y, RowScratch& scratch) const {
  const std::size_t at = row(y);
  scratch.gray_rows.start();
  const auto pointer = [&](const GrayImage* image) {
    return image ? scratch.gray_rows.next(*image, at, static_cast<std::size_t>(width_)) : nullptr;
  };
  GrayRow& g = scratch.gray_row;
  g.bits.clear();
  g.inverse.clear();
  for (const GrayImage* image : input_.bits) g.bits.push_back(pointer(image));
  for (const GrayImage* image : input_.inverse) g.inverse.push_back(pointer(image));
  g.complementary = pointer(input_.complementary);
  g.complementary_inverse = pointer(input_.complementary_inverse);
  scratch.threshold.resize(width_);
  if (direction_.gray->threshold == GrayCode::Threshold::mean) {
    const double exposure = images_.gray_code_exposure.value_or(1.0);
    const float scale = std::isfinite(exposure) ? static_cast<float>(exposure) : 1.0f;
    for (int x = 0; x < width_; ++x) scratch.threshold[x] = scale * out_.mean_dn.data[at + x];
  } else if (direction_.gray->threshold == GrayCode::Threshold::white_black) {
    for (int x = 0; x < width_; ++x) {
      const std::size_t i = at + x;
      scratch.threshold[x] = 0.5f * ((*images_.white)[i] + (*images_.black)[i]);
    }
  }
}

// ---- phases -----------------------------------------------------------------------------------------

/// Computes wrapped phase, amplitude and mean; the phase is NaN where a step is saturated.
void DirectionDecoder::solve_phases() {
  const std::size_t pitches = direction_.pitches_px.size();
  out_.wrapped_rad.assign(pitches, ImageF(width_, height_));
  out_.amplitude_dn.assign(pitches, ImageF(width_, height_));
  out_.mean_dn = ImageF(width_, height_);
  const auto limit = static_cast<float>(images_.saturation_dn());
#pragma omp parallel if (height_ > kSerialRows)
  {
    std::vector<float> maximum(width_);
    std::vector<const float*> rows(steps_.size());
    RowsOfImages of_images;
#pragma omp for schedule(static)
    for (int y = 0; y < height_; ++y) {
      const std::size_t at = row(y);
      for (std::size_t p = 0; p < pitches; ++p) {
        of_images.start();
        for (std::size_t i = 0; i < rows.size(); ++i)
          rows[i] = of_images.next(*input_.steps[p][i], at, static_cast<std::size_t>(width_));
        const PhaseRow out{
            .phase_rad = out_.wrapped_rad[p].data.data() + at,
            .amplitude = out_.amplitude_dn[p].data.data() + at,
            .mean = static_cast<int>(p) == out_.finest ? out_.mean_dn.data.data() + at : nullptr,
            .maximum = maximum.data()};
        solve_row(*solver_, rows.data(), width_, out);
        for (std::size_t x = 0; x < maximum.size(); ++x)
          if (maximum[x] >= limit) {
            out.phase_rad[x] = kInvalid;
            flags_.data[at + x] |= kSaturated;
          }
      }
    }
  }
  min_amplitude_ = min_amplitude(out_.amplitude_dn[out_.finest]);
}

/// Sets the variance of a gray value against its mean: known, from the residuals, or quantisation.
void DirectionDecoder::choose_noise() {
  const double largest =
      images_.radiance ? std::max(1e-30, percentile_999(out_.mean_dn)) : images_.saturation_dn();
  const double rounding = largest * static_cast<double>(std::numeric_limits<float>::epsilon()) / 2.0;
  const double floor = images_.radiance ? rounding * rounding : kRoundingVariance;
  if (options_.variance_offset_dn2 || options_.variance_per_dn) {
    noise_ = {options_.variance_offset_dn2.value_or(0.0) + floor, options_.variance_per_dn.value_or(0.0),
              options_.least_variance_dn2 + floor};
    out_.noise_source = NoiseSource::known;
    return;
  }
  std::vector<NoiseInput> pitches;
  for (std::size_t p = 0; p < input_.steps.size(); ++p)
    pitches.push_back({input_.steps[p], &out_.wrapped_rad[p], &out_.amplitude_dn[p]});
  const auto estimated = estimate_noise(
      pitches, *solver_, direction_.axis,
      {.min_amplitude = min_amplitude_, .saturation = images_.saturation_dn(), .least = floor});
  noise_ = estimated.value_or(NoiseModel{floor});
  out_.noise_source = estimated ? NoiseSource::residuals : NoiseSource::quantisation;
}

/// Finds what a settled bit looks like here: the code may be brighter or darker than the phase steps.
void DirectionDecoder::learn_code_margins() {
  constexpr int kRows = 64;
  std::vector<float> bright, dark;
  RowScratch scratch;
  for (int i = 0; i < kRows; ++i) {
    const int y = static_cast<int>((i + 0.5) * height_ / kRows);
    point_gray_row(y, scratch);
    read_gray_row(gray_, scratch.gray_row, scratch.threshold.data(), width_, scratch.gray);
    const float* amplitude = out_.amplitude_dn.front().data.data() + row(y);
    const float* phase = out_.wrapped_rad.front().data.data() + row(y);
    for (int x = 0; x < width_; x += 4) {
      if (!(static_cast<double>(amplitude[x]) >= min_amplitude_) || !std::isfinite(phase[x])) continue;
      for (int b = 0; b < gray_.bits; ++b) {
        const auto at = static_cast<std::size_t>(b) * width_ + x;
        const float margin = scratch.gray.margin[at] / amplitude[x];
        if (margin > 0.0f) bright.push_back(margin);
        if (margin < 0.0f) dark.push_back(-margin);
      }
    }
  }
  if (!bright.empty()) gray_.bright_margin = static_cast<float>(upper_median(bright));
  if (!dark.empty()) gray_.dark_margin = static_cast<float>(upper_median(dark));
}

double DirectionDecoder::pitch_variance(std::size_t pitch, std::size_t at, double gray_variance) const {
  const auto amplitude = static_cast<double>(out_.amplitude_dn[pitch].data[at]);
  double factor = solver_->phase_variance(1.0, 0.0);
  if (!solver_->isotropic()) {
    const auto phase = static_cast<double>(out_.wrapped_rad[pitch].data[at]);
    factor = solver_->phase_variance(std::cos(phase), std::sin(phase));
  }
  return factor * gray_variance / (amplitude * amplitude);
}

void DirectionDecoder::mask_row(int y) {
  const std::size_t at = row(y), n = static_cast<std::size_t>(width_);
  const auto least = static_cast<float>(min_amplitude_);
  for (std::size_t p = 0; p < out_.wrapped_rad.size(); ++p) {
    const float* amplitude = out_.amplitude_dn[p].data.data() + at;
    float* phase = out_.wrapped_rad[p].data.data() + at;
    for (std::size_t x = 0; x < n; ++x)
      if (!(amplitude[x] >= least)) {  // NaN of a radiance image, too
        phase[x] = kInvalid;
        flags_.data[at + x] |= kLowModulation;
      }
  }
}

void DirectionDecoder::variance_row(int y, RowScratch& scratch) const {
  const std::size_t at = row(y), n = static_cast<std::size_t>(width_);
  scratch.variance.resize(n * out_.wrapped_rad.size());
  for (std::size_t x = 0; x < n; ++x) {
    const double gray_variance = noise_.variance(static_cast<double>(out_.mean_dn.data[at + x]));
    for (std::size_t p = 0; p < out_.wrapped_rad.size(); ++p)
      scratch.variance[p * n + x] = static_cast<float>(pitch_variance(p, at + x, gray_variance));
  }
}

std::vector<int> DirectionDecoder::plan_order() const {
  switch (fringes_.unwrap) {
    case Unwrap::heterodyne:
      return {heterodyne_.index[0], heterodyne_.index[1], heterodyne_.index[2]};
    case Unwrap::hierarchical:
      return hierarchical_.index;
    default:
      return {0};
  }
}

void DirectionDecoder::order_row(int y, RowScratch& scratch) {
  const std::size_t at = row(y), n = static_cast<std::size_t>(width_);
  scratch.pitches.clear();
  for (const int i : plan_order()) {
    const auto p = static_cast<std::size_t>(i);
    scratch.pitches.push_back({out_.wrapped_rad[p].data.data() + at, scratch.variance.data() + p * n});
  }
  scratch.coordinate_variance.resize(n);
  double* x_px = out_.coordinate_px.data.data() + at;
  float* variance = scratch.coordinate_variance.data();
  switch (fringes_.unwrap) {
    case Unwrap::heterodyne: {
      const PitchRow three[3] = {scratch.pitches[0], scratch.pitches[1], scratch.pitches[2]};
      unwrap_heterodyne_row(heterodyne_, three, width_, x_px, variance);
      break;
    }
    case Unwrap::hierarchical:
      unwrap_hierarchical_row(hierarchical_, scratch.pitches, width_, x_px, variance);
      break;
    case Unwrap::gray:
      point_gray_row(y, scratch);
      read_gray_row(gray_, scratch.gray_row, scratch.threshold.data(), width_, scratch.gray);
      unwrap_gray_row(gray_, scratch.pitches.front(), out_.amplitude_dn.front().data.data() + at, width_,
                      scratch.gray, x_px, variance);
      break;
    case Unwrap::none:
      break;
  }
}

/// Makes coordinates outside the projector and doubtful orders invalid, and writes sigma where they are
/// valid.
void DirectionDecoder::finish_row(int y, const RowScratch& scratch) {
  const std::size_t at = row(y), n = static_cast<std::size_t>(width_);
  double* x_px = out_.coordinate_px.data.data() + at;
  for (std::size_t x = 0; x < n; ++x) {
    const bool valid = std::isfinite(x_px[x]) && in_range(x_px[x]);
    if (valid) {
      out_.coordinate_sigma_px.data[at + x] = std::sqrt(scratch.coordinate_variance[x]);
      continue;
    }
    x_px[x] = static_cast<double>(kInvalid);
    bool masked = out_.wrapped_rad.empty() &&
                  !(static_cast<double>(out_.amplitude_dn[0].data[at + x]) >= min_amplitude_);
    for (const ImageF& phase : out_.wrapped_rad) masked = masked || !std::isfinite(phase.data[at + x]);
    if (!masked) flags_.data[at + x] |= kOrderInvalid;
  }
}

void DirectionDecoder::unwrap_phases() {
  const auto finest = static_cast<std::size_t>(out_.finest);
  const auto n = static_cast<std::size_t>(width_);
#pragma omp parallel if (height_ > kSerialRows)
  {
    RowScratch scratch;
#pragma omp for schedule(static)
    for (int y = 0; y < height_; ++y) {
      mask_row(y);
      variance_row(y, scratch);
      const float* phase = out_.wrapped_rad[finest].data.data() + row(y);
      float* sigma = out_.sigma_rad.data.data() + row(y);
      for (std::size_t x = 0; x < n; ++x)
        sigma[x] = std::isfinite(phase[x]) ? std::sqrt(scratch.variance[finest * n + x]) : kInvalid;
      if (!out_.unwrapped) continue;
      order_row(y, scratch);
      finish_row(y, scratch);
    }
  }
  std::vector<float> levels, noise;
  for (std::size_t i = 0; i < flags_.size(); i += 97)
    if (std::isfinite(out_.wrapped_rad[finest].data[i])) {
      levels.push_back(out_.mean_dn.data[i]);
      noise.push_back(static_cast<float>(noise_.variance(static_cast<double>(levels.back()))));
    }
  if (noise.empty()) return;
  out_.noise_dn = std::sqrt(upper_median(noise));
  if (out_.noise_source == NoiseSource::residuals) out_.noise_known_to = noise_.known_to(levels);
}

void DirectionDecoder::mend_orders() {
  if (!out_.unwrapped) return;
  OrderRepairOptions o;
  o.period_px = direction_.pitches_px[out_.finest];
  if (gray_.cyclic) o.cycle_px = gray_.span_px;
  if (!options_.repair_orders) o.max_passes = 0;
  if (fringes_.unwrap == Unwrap::heterodyne)
    o.resolve = [this](std::size_t at, double predicted_px) {
      const double gray_variance = noise_.variance(static_cast<double>(out_.mean_dn.data[at]));
      double t[3], variance[3];
      for (int i = 0; i < 3; ++i) {
        const auto p = static_cast<std::size_t>(heterodyne_.index[i]);
        t[i] = kPerCycle * static_cast<double>(out_.wrapped_rad[p].data[at]);
        variance[i] = pitch_variance(p, at, gray_variance);
      }
      return resolve_heterodyne(heterodyne_, t, variance, predicted_px);
    };
  out_.repair = repair_orders(out_.coordinate_px, o);
  if (out_.repair.n_changed == 0 || !range_.known) return;
  for (std::size_t i = 0; i < flags_.size(); ++i)
    if (std::isfinite(out_.coordinate_px.data[i]) && !in_range(out_.coordinate_px.data[i])) {
      out_.coordinate_px.data[i] = static_cast<double>(kInvalid);
      out_.coordinate_sigma_px.data[i] = kInvalid;
      flags_.data[i] |= kOrderInvalid;
    }
}

}  // namespace

const DirectionDecode* CameraDecode::direction(Axis axis) const {
  for (const DirectionDecode& d : directions)
    if (d.axis == axis) return &d;
  return nullptr;
}

/// Decodes images as they are.
static CameraDecode decode_as_they_are(const CameraImages& images, const Fringes& fringes,
                                       const DecodeOptions& options) {
  const std::vector<int> steps = options.use_steps.empty() ? all_steps(fringes.steps) : options.use_steps;
  CameraDecode out;
  out.camera = images.camera;
  out.clip = images.clip;
  out.radiance = images.radiance;
  out.flags = ImageU8(images.images.front().width, images.images.front().height, kValid);
  for (std::size_t d = 0; d < fringes.directions.size(); ++d)
    out.directions.push_back(
        DirectionDecoder(images, fringes, static_cast<int>(d), steps, options, out.flags).run());
  return out;
}

CameraDecode decode(const CameraImages& images, const Fringes& fringes, const DecodeOptions& options) {
  check_decode_input(images, fringes);
  if (!options.light) return decode_as_they_are(images, fringes, options);
  std::optional<LightFactors> light = estimate_light(images, fringes, *options.light);
  const bool differs = light && light->differ();
  CameraDecode out =
      differs ? decode_as_they_are(with_steady_light(images, *light, options.light->black_level_dn), fringes,
                                   options)
              : decode_as_they_are(images, fringes, options);
  out.clip = images.clip;
  out.light = std::move(light);
  out.light_taken_out = differs;
  return out;
}

}  // namespace fringetwin::measure
