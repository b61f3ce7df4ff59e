// SPDX-License-Identifier: Apache-2.0
// The adaptive trace of pixels inside one surface, on creases of a mesh and on outlines of a mesh.
#include <cmath>
#include <complex>

#include "render/trace/adaptive_trace.hpp"

namespace fringetwin::render {
namespace {

constexpr double kShareOfOutlines = 0.15;
constexpr std::uint32_t kMostParts = 4;  // of a pixel's side, for pieces of facets

}  // namespace

// Runs the Gauss rule of n x n nodes over a list.
template <class Use>
void AdaptiveTrace::run_rule(const std::vector<std::uint32_t>& list, int order, Use use) {
  SampleSetup samples;
  samples.table = gauss_samples(order * order, job_.twin.sampled_side_px(job_.camera), {}, 0.0);
  samples.n = static_cast<std::uint32_t>(order * order);
  device_.upload_samples(samples);
  device_.upload_pass(job_, *pass_, samples, limits());
  device_.fill(BIND_PIXELS, list);
  reserve_output(std::min(most_slots(), list.size() + BLOCK_PIXELS));
  run_list(device_.bound_kernel(Kernel::trace, constants(samples, PIXELS_LISTED)), list, 1, samples.n, use);
  job_.out->rays += std::uint64_t{samples.n} * list.size();
}

// Traces a list by one rule, whose error the classification has bounded.
void AdaptiveTrace::run_gauss(const std::vector<std::uint32_t>& list, int order) {
  run_rule(list, order, [&](std::size_t first, std::size_t n, const Sums& sums) {
#pragma omp parallel for
    for (std::size_t i = 0; i < n; ++i) write(list[first + i], i, sums);
  });
}

// Traces a list by two orders of the rule; pixels on which they do not agree go to the scan lines.
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
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t e = first + i;
      const auto old = [&](std::size_t c) { return static_cast<double>(before[c * list.size() + e]); };
      double fringe = 0.0, chain = 0.0;
      for (std::size_t p = 0; p < pass_->pitches.size(); ++p) {
        const PitchSlot& pitch = pass_->pitches[p];
        const std::complex<double> a(old(1 + 2 * p), old(2 + 2 * p)),
            b(sums.at(2 + 2 * p, i), sums.at(3 + 2 * p, i));
        if (std::norm(b) > 0.0 && pitch.harmonic == 1)
          phase[e] = std::max(phase[e], kOrderSafety * std::abs(std::arg(a * std::conj(b))));
        chain = (pitch.harmonic == 1 ? 0.0 : chain) + pitch.share * std::abs(a - b);
        fringe = std::max(fringe, chain);
      }
      gray[e] = kOrderSafety * irradiance_error(old(0) - sums.at(0, i), fringe);
      worse[e] = std::max(phase[e] / phase_target_rad_, gray[e] / irradiance_target_);
      if (!std::isfinite(phase[e] + gray[e])) worse[e] = HUGE_VAL;
    }
    gather(sums, first, n, &values);
  });
  const auto n_known = static_cast<double>(n_lit_ + list.size());
  const double most = largest_error_to_keep(worse, 0.5 * kShareOfBudget * n_known, kMostAllowance);
  for (std::size_t e = 0; e < list.size(); ++e) {
    if (!(worse[e] <= most)) {
      to_scan_lines(list[e], far_from_edges(list[e]) ? kInsideSurface : 0);
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
  ComputePipeline& kernel = list_kernel(Kernel::border, PIXELS_LISTED, list);
  run_list(kernel, list, 1, 0, [&](std::size_t first, std::size_t n, const Sums&) {
    const auto* answer = answers(n);
    for (std::size_t i = 0; i < n; ++i)
      if (answer[i] == BORDER_DENSE)
        mixed_.push_back(list[first + i] | kInsideSurface);
      else
        (answer[i] == BORDER_CROSSED  ? mixed_
         : answer[i] == BORDER_FACETS ? facets_
                                      : smooth_)
            .push_back(list[first + i]);
  });
  job_.out->rays += 8 * list.size();
}

// Adds up the squares of one pixel and returns their errors.
AdaptiveTrace::FacetErrors AdaptiveTrace::add_squares(const Sums& sums, std::size_t slot,
                                                      std::size_t n_squares, bool by_piece,
                                                      float* values) const {
  const std::size_t n_channels = pass_->channels();
  const auto sum = [&](std::size_t c) {
    double v = 0.0;
    for (std::size_t s = 0; s < n_squares; ++s) v += sums.at(c, slot + s);
    return v;
  };
  for (std::size_t c = 0; c < n_channels; ++c) values[c] = static_cast<float>(sum(c));
  double amplitude = static_cast<double>(values[0]);
  for (std::size_t p = 0; by_piece && p < pass_->pitches.size(); ++p)
    if (pass_->pitches[p].harmonic == 1)
      amplitude = std::min(amplitude, static_cast<double>(std::hypot(values[2 + 2 * p], values[3 + 2 * p])));
  const double error = sum(n_channels);
  return {irradiance_error(error, error), sum(n_channels + 1) / std::max(amplitude, 1e-30)};
}

// Averages over facets: the quick way (PIXELS_LISTED) or piece by piece (PIXELS_PIECES). `share` of the
// budget may be used; returns what does not fit.
std::vector<std::uint32_t> AdaptiveTrace::run_facets(const std::vector<std::uint32_t>& list,
                                                     std::uint32_t kind, double share) {
  const std::size_t n_squares = std::size_t{panels_} * panels_, n_channels = pass_->channels();
  ComputePipeline& kernel = list_kernel(Kernel::facets, kind, list, n_squares);
  std::vector<float> values(n_channels * list.size());
  std::vector<FacetErrors> found(list.size());
  std::vector<double> worse(list.size());
  run_list(kernel, list, n_squares, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
    const std::int32_t* squares = answers(n * n_squares);
    for (std::size_t i = 0; i < n; ++i) {
      FacetErrors& f = found[first + i];
      f = add_squares(sums, i * n_squares, n_squares, kind == PIXELS_PIECES,
                      &values[n_channels * (first + i)]);
      f.answer = *std::max_element(squares + i * n_squares, squares + (i + 1) * n_squares);
      if (!std::isfinite(f.irradiance + f.phase_rad)) f.answer = FACETS_UNKNOWN;
      worse[first + i] = f.answer == FACETS_DONE
                             ? std::max(f.phase_rad / phase_target_rad_, f.irradiance / irradiance_target_)
                             : HUGE_VAL;
    }
  });
  const auto n_known = static_cast<double>(n_lit_ + list.size() + smooth_.size());
  const double most = largest_error_to_keep(worse, share * kShareOfBudget * n_known, kMostAllowance);
  std::vector<std::uint32_t> rest;
  for (std::size_t e = 0; e < list.size(); ++e) {
    if (worse[e] <= most) {
      count_error(found[e].phase_rad, found[e].irradiance);
      write(list[e], 0, Sums{&values[n_channels * e], 1});
    } else if (found[e].answer == FACETS_UNKNOWN) {
      to_scan_lines(list[e], kInsideSurface);  // two orders of a rule would agree too soon at a crease
    } else {
      rest.push_back(list[e]);
    }
  }
  return rest;
}

// Averages over facets that the quick way does not serve piece by piece, then in quarters and in sixteenths
// of the pixel; the rest goes to the scan lines.
void AdaptiveTrace::run_pieces(std::vector<std::uint32_t> rest) {
  for (; panels_ <= kMostParts && !rest.empty(); panels_ *= 2)
    stage("pieces", rest.size(), [&] { rest = run_facets(rest, PIXELS_PIECES, 0.125 / panels_); });
  panels_ = 1;
  for (const std::uint32_t code : rest) to_scan_lines(code, kInsideSurface);
}

// Clips pixels on outlines: edges between facets of one mesh and nothing, or between facets that face the
// projector and others. Pixels that this does not serve become mixed ones.
void AdaptiveTrace::run_outlines(const std::vector<std::uint32_t>& list) {
  ComputePipeline& kernel = list_kernel(Kernel::facets, PIXELS_OUTLINE, list);
  const std::size_t n_channels = pass_->channels();
  std::vector<float> values(n_channels * list.size());
  std::vector<double> errors(list.size());
  run_list(kernel, list, 1, 0, [&](std::size_t first, std::size_t n, const Sums& sums) {
    const auto* rejected = answers(n);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t e = first + i;
      errors[e] = irradiance_error(0.0, sums.at(n_channels, i));
      if (rejected[i] || !std::isfinite(errors[e])) errors[e] = HUGE_VAL;
    }
    gather(sums, first, n, &values);
  });
  const auto n_known = static_cast<double>(n_lit_ + list.size() + facets_.size() + smooth_.size());
  const double most =
      largest_error_to_keep(errors, kShareOfOutlines * irradiance_target_ * irradiance_target_ * n_known,
                            kMostAllowance * irradiance_target_);
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

}  // namespace fringetwin::render
