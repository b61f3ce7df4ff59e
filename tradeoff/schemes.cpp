// SPDX-License-Identifier: Apache-2.0
#include "tradeoff/schemes.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fringetwin::tradeoff {
namespace {

struct Family {
  const char* name;
  Sampler sampler;
  std::vector<int> samples, quick_samples;
};

const std::vector<Family>& families() {
  static const std::vector<Family> table{
      {"gauss", Sampler::gauss, {1, 4, 9, 16, 64}, {1, 4, 16}},
      {"multi-jittered", Sampler::multi_jittered, {4, 16, 64, 256, 1024}, {16, 64}},
      {"sobol", Sampler::sobol, {4, 16, 64, 256, 1024}, {16}},
  };
  return table;
}

std::vector<double> adaptive_targets(bool quick) {
  return quick ? std::vector<double>{1e-4} : std::vector<double>{1e-2, 1e-3, 1e-4, 2e-5};
}

bool same(const render::Sampling& a, const render::Sampling& b) {
  if (a.sampler != b.sampler || a.precise != b.precise) return false;
  return a.sampler == Sampler::adaptive
             ? a.phase_error_rad == b.phase_error_rad && a.gray_error == b.gray_error
             : a.samples == b.samples;
}

const char* family_name(Sampler sampler) {
  for (const Family& f : families())
    if (f.sampler == sampler) return f.name;
  return "adaptive";
}

std::vector<Scheme> all_of_precision(bool precise, bool quick) {
  std::vector<Scheme> out;
  for (const double target : adaptive_targets(quick))
    out.push_back({.family = family_name(Sampler::adaptive),
                   .sampling = {.sampler = Sampler::adaptive,
                                .samples = 1,
                                .precise = precise,
                                .phase_error_rad = target,
                                .gray_error = target}});
  for (const Family& f : families())
    for (const int n : quick ? f.quick_samples : f.samples)
      out.push_back({.family = f.name,
                     .sampling = {.sampler = f.sampler, .samples = n, .precise = precise},
                     .is_published = f.sampler == Sampler::multi_jittered && n == 1024 && !precise});
  return out;
}

}  // namespace

std::string Scheme::size() const {
  return is_adaptive() ? fmt::format("{:.0e}", sampling.phase_error_rad) : std::to_string(sampling.samples);
}

std::vector<Scheme> scheme_table(const Twin& twin, bool has_double, bool quick) {
  render::Sampling chosen = render::choose_sampling(twin);
  chosen.precise = chosen.precise && has_double;
  std::vector<Scheme> out = all_of_precision(false, quick);
  if (has_double) {
    const auto more = all_of_precision(true, quick);
    out.insert(out.end(), more.begin(), more.end());
  }
  const auto at = std::ranges::find_if(out, [&chosen](const Scheme& s) { return same(s.sampling, chosen); });
  if (at != out.end())
    at->is_default = true;
  else
    out.push_back({.family = family_name(chosen.sampler), .sampling = chosen, .is_default = true});
  return out;
}

}  // namespace fringetwin::tradeoff
