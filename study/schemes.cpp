// SPDX-License-Identifier: Apache-2.0
#include "study/schemes.hpp"

namespace fringetwin::study {
namespace {

// Below this target the renderer traces in double precision (render/renderer.hpp).
constexpr double double_precision_below_rad = 5e-5;

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

bool same(const render::Sampling& a, const render::Sampling& b) {
  return a.sampler == b.sampler && a.samples == b.samples;
}

const char* family_name(Sampler sampler) {
  for (const Family& f : families())
    if (f.sampler == sampler) return f.name;
  return "other";
}

}  // namespace

std::vector<Scheme> scheme_table(const RenderOptions& options, bool quick) {
  const render::Sampling chosen = render::choose_sampling(options);
  std::vector<Scheme> out;
  bool has_default = false;
  for (const Family& f : families())
    for (const int n : quick ? f.quick_samples : f.samples) {
      Scheme s{f.name, {f.sampler, n}, f.sampler == Sampler::multi_jittered && n == 1024, false};
      s.is_default = same(s.sampling, chosen);
      has_default = has_default || s.is_default;
      out.push_back(s);
    }
  if (!has_default) out.push_back({family_name(chosen.sampler), chosen, false, true});
  return out;
}

bool is_precise(const RenderOptions& options) { return options.phase_error_rad < double_precision_below_rad; }

void set_precise(RenderOptions& options, bool precise) { options.phase_error_rad = precise ? 1e-5 : 1e-4; }

}  // namespace fringetwin::study
