// SPDX-License-Identifier: Apache-2.0
// The adaptive trace of pixels that an edge crosses: scan lines find the edge and integrate on either side.
#include <array>

#include "render/trace/adaptive_trace.hpp"

namespace fringetwin::render {
namespace {

constexpr std::uint32_t kMostPanels = 16, kMostStretches = 64;
constexpr double kShareOfRound = 0.7;  // of the budget that is left

}  // namespace

// Adds up one pixel's scan lines to its sums and returns their estimated errors.
AdaptiveTrace::LineErrors AdaptiveTrace::add_lines(const Sums& sums, std::size_t slot, float* values) const {
  const auto at = [&](std::size_t c, std::size_t line) {
    double sum = 0.0;
    for (std::size_t s = 0; s < stretches_; ++s) sum += sums.at(c, slot + stretches_ * line + s);
    return sum;
  };
  const auto channel_error = [&](std::size_t c) {
    double v = 0.0, e = 0.0;
    for (std::size_t p = 0; p < panels_; ++p) {
      std::array<double, LINES_PER_PANEL> g{};
      for (std::size_t l = 0; l < LINES_PER_PANEL; ++l) {
        g[l] = at(c, LINES_PER_PANEL * p + l);
        v += kPanelWeights[l] * g[l];
      }
      e += panel_error(g);
    }
    values[c] = static_cast<float>(v / panels_);
    return e / panels_;
  };
  const double mean = channel_error(0);
  const double hit = channel_error(1);
  double fringe = 0.0, phase = 0.0, chain = 0.0;  // the errors of a pitch and its harmonics add up
  for (std::size_t p = 0; p < pass_->pitches.size(); ++p) {
    const PitchSlot& pitch = pass_->pitches[p];
    const double cosine = channel_error(2 + 2 * p), sine = channel_error(3 + 2 * p);
    chain = (pitch.harmonic == 1 ? 0.0 : chain) + pitch.share * std::hypot(cosine, sine);
    fringe = std::max(fringe, chain);
    if (pitch.harmonic > 1) continue;
    const double amplitude =
        std::hypot(static_cast<double>(values[2 + 2 * p]), static_cast<double>(values[3 + 2 * p]));
    if (amplitude > 0.0) phase = std::max(phase, std::hypot(cosine, sine) / amplitude);
  }
  // The error of borders that bisection left open: independent from line to line.
  double open = 0.0;
  for (std::size_t p = 0; p < panels_; ++p)
    for (std::size_t l = 0; l < LINES_PER_PANEL; ++l)
      open = std::hypot(open, kPanelWeights[l] * at(pass_->channels(), LINES_PER_PANEL * p + l));
  open *= std::max(1.0, job_.twin.fringes.mean + job_.twin.fringes.amplitude * contrast_) / panels_;
  const double gray = std::hypot(irradiance_error(mean, fringe) + job_.twin.projector->ambient * hit, open);
  if (!std::isfinite(gray + phase)) return {HUGE_VAL, HUGE_VAL, open > 0.0};
  return {gray, phase, open > 0.0};
}

// Traces all lines of a list and returns the sums, entry by entry; in more stretches from now on if the
// driver cuts them short.
std::vector<float> AdaptiveTrace::trace_lines(const std::vector<std::uint32_t>& list,
                                              std::vector<LineErrors>* found) {
  const std::size_t n_channels = pass_->channels();
  std::vector<float> values(n_channels * list.size());
  std::vector<LineErrors> errors(list.size());
  const std::uint64_t rays_before = job_.out->rays;
  for (;; stretches_ *= 8) {
    const std::size_t per_entry = LINES_PER_PANEL * std::size_t{panels_} * stretches_;
    ComputePipeline& kernel = list_kernel(Kernel::lines, PIXELS_LISTED, list, per_entry);
    try {
      run_list(kernel, list, per_entry, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
        for (std::size_t i = 0; i < n; ++i)
          errors[first + i] = add_lines(sums, i * per_entry, &values[n_channels * (first + i)]);
      });
      *found = std::move(errors);
      return values;
    } catch (const LoopLimit&) {
      job_.out->rays = rays_before;
      if (stretches_ >= kMostStretches) throw;
    }
  }
}

// Returns the error of an entry that counts against the budget, as one of the irradiance: inside a surface
// the phase counts as well.
double AdaptiveTrace::line_error(const LineErrors& found, bool inside) const {
  if (!inside) return found.irradiance;
  return std::max(found.irradiance, found.phase_rad / phase_target_rad_ * irradiance_target_);
}

// Keeps the entries whose error is at most `most`: writes their values, counts their errors and adds the
// squares to `spent`. The others stay in the list, with their values and errors at the front.
void AdaptiveTrace::keep_lines(double most, std::vector<std::uint32_t>* list, std::vector<float>* values,
                               std::vector<LineErrors>* found, double* spent) {
  const std::size_t n_channels = pass_->channels();
  std::vector<std::uint32_t> next;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::uint32_t code = (*list)[i];
    const LineErrors& errors = (*found)[i];
    const bool inside = (code & kInsideSurface) && !errors.crossed;
    const double error = line_error(errors, inside);
    if (error > most) {
      if (next.size() < i) {
        std::copy_n(&(*values)[n_channels * i], n_channels, &(*values)[n_channels * next.size()]);
        (*found)[next.size()] = errors;
      }
      next.push_back(code);
      continue;
    }
    *spent += error * error;
    if (inside) {
      count_error(errors.phase_rad, errors.irradiance);
      --n_mixed_;
    } else {
      mixed_squares_ += error * error;
    }
    write(code, 0, Sums{&(*values)[n_channels * i], 1});
  }
  *list = std::move(next);
}

// Traces the mixed pixels by scan lines in panels of four, with twice as many panels for those that are not
// good enough.
void AdaptiveTrace::run_lines() {
  static_assert(LINES_PER_PANEL == kPanelWeights.size());
  std::vector<std::uint32_t> list = mixed_;
  const double whole =
      irradiance_target_ * irradiance_target_ * static_cast<double>(n_lit_ + n_outlines_ + mixed_.size());
  const double allowed = std::min(kShareOfBudget * whole, std::max(0.1 * whole, whole - gray_squares_));
  double spent = mixed_squares_;
  std::vector<float> values;
  std::vector<LineErrors> found;
  for (panels_ = 1; !list.empty(); panels_ *= 2) {
    bool finest = panels_ >= kMostPanels;
    stage("lines", list.size(), [&] {
      try {
        values = trace_lines(list, &found);
      } catch (const LoopLimit&) {
        if (panels_ == 1) throw;
        finest = true;  // what the round before found stands, with its errors
      }
    });
    std::vector<double> errors(list.size());
    for (std::size_t i = 0; i < list.size(); ++i)
      errors[i] = line_error(found[i], (list[i] & kInsideSurface) && !found[i].crossed);
    // The target is the rms over all pixels, and few lie on edges: the largest errors are worked on until
    // the others fit into the budget together. Some of it is left to the pixels of the next round, or they
    // would have to become exact.
    const double most = finest ? HUGE_VAL
                               : largest_error_to_keep(errors, kShareOfRound * (allowed - spent),
                                                       kMostAllowance * irradiance_target_);
    keep_lines(most, &list, &values, &found, &spent);
  }
  panels_ = 1;
}

}  // namespace fringetwin::render
