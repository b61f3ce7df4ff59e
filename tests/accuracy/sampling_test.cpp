// SPDX-License-Identifier: Apache-2.0
// Samplers: convergence on the ideal sphere (interior), edges, determinism, the automatic choice.
// | tolerance            | unit    | origin                                                       |
// |----------------------|---------|--------------------------------------------------------------|
// | 3e-3, 4e-4, 8e-5     | rad rms | twice the rms measured with 16, 64, 256 samples (multi-jittered|
// |                      |         | and Sobol: 1.5e-3, 1.9e-4, 3e-5)                              |
// | 4e-3                 | rad rms | a prime number of samples fits no grid: about as 16 samples    |
// | 4e-5                 | rad rms | 2x2 ... 4x4 Gauss-Legendre, fp32 floor 1.6e-5                  |
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::testing::sampling_test {
namespace {

using render::Sampling;

Twin window() { return with_object(left_window({0, 0, 250}, 120, 112), "sphere", ideal_sphere()); }

/// The reference of window(), once.
const std::vector<ReferenceBlockPixel>& truth() {
  static const auto block = [] {
    const Twin twin = window();
    return reference_block(render::Reference(twin), 0, whole_image(twin, 0, 3));
  }();
  return block;
}

Agreement with(const Sampling& sampling, std::uint64_t seed = 0) {
  const Twin twin = window();
  const auto rendered = shared_renderer()->render(twin, 0, sampling, seed);
  const Agreement a = compare(twin, 0, rendered.irradiance, truth());
  std::cout << sampling.samples << " samples: " << a.text() << "\n";
  return a;
}

TEST(Sampling, GaussLegendre) {
  REQUIRE_RENDERER();
  for (int n : {2, 3, 4}) EXPECT_LE(with({Sampler::gauss, n * n}).worst_phase_rms_rad(), 4e-5) << n;
  EXPECT_GT(with({Sampler::gauss, 1}).worst_phase_rms_rad(), 1e-4);
}

TEST(Sampling, MultiJitteredAndSobolConverge) {
  REQUIRE_RENDERER();
  for (Sampler sampler : {Sampler::multi_jittered, Sampler::sobol}) {
    const Agreement a16 = with({sampler, 16}), a64 = with({sampler, 64}), a256 = with({sampler, 256});
    EXPECT_LE(a16.worst_phase_rms_rad(), 3e-3);
    EXPECT_LE(a64.worst_phase_rms_rad(), 4e-4);
    EXPECT_LE(a256.worst_phase_rms_rad(), 8e-5);
    EXPECT_GT(a16.worst_phase_rms_rad(), 4 * a64.worst_phase_rms_rad());
    // unbiased: the mean error is within 4.5 standard errors
    for (const PitchAgreement& p : a16.pitches)
      EXPECT_NEAR(p.phase_mean_rad, 0.0, 4.5 * p.phase_rms_rad / std::sqrt(a16.n));
  }
}

TEST(Sampling, APrimeNumberOfSamplesIsFine) {
  REQUIRE_RENDERER();
  EXPECT_LE(with({Sampler::multi_jittered, 61}).worst_phase_rms_rad(), 4e-3);
  EXPECT_LE(with({Sampler::sobol, 61}).worst_phase_rms_rad(), 4e-3);
}

TEST(Sampling, SilhouettesImproveWithSamples) {
  REQUIRE_RENDERER();
  const Twin twin = window();
  const render::Reference reference(twin);
  std::vector<ReferenceBlockPixel> edge;
  for (auto& p : reference_block(reference, 0, whole_image(twin, 0, 2), {.gauss_n = 4})) {
    if (p.interior || p.pixel.mean == 0.0) continue;
    p.pixel = reference.pixel(0, p.x, p.y, {.gauss_n = 64});
    edge.push_back(p);
  }
  const auto error = [&](const Sampling& s) {
    return compare(twin, 0, shared_renderer()->render(twin, 0, s).irradiance, edge, Pixels::all).gray_rms;
  };
  const double coarse = error({Sampler::multi_jittered, 4}), fine = error({Sampler::multi_jittered, 256});
  std::cout << edge.size() << " edge pixels: gray rms " << coarse << " with 4, " << fine
            << " with 256 samples\n";
  EXPECT_GT(edge.size(), 50u);
  EXPECT_LT(fine, 0.15 * coarse);
  EXPECT_LT(fine, 2e-3);
}

TEST(Sampling, SeedsAndRepetition) {
  REQUIRE_RENDERER();
  const Twin twin = window();
  const Sampling sampling{Sampler::multi_jittered, 16};
  const auto a = shared_renderer()->render(twin, 0, sampling, 7),
             b = shared_renderer()->render(twin, 0, sampling, 7);
  const auto c = shared_renderer()->render(twin, 0, sampling, 8);
  for (std::size_t i = 0; i < a.irradiance.size(); ++i) {
    EXPECT_EQ(a.irradiance[i].data, b.irradiance[i].data);
    EXPECT_NE(a.irradiance[i].data, c.irradiance[i].data);
  }
}

// The promise of [render] phase_error_rad: interior rms at the finest pitch.
TEST(Sampling, TheAutomaticChoiceKeepsItsPromise) {
  REQUIRE_RENDERER();
  for (double target : {1e-3, 1e-4, 4e-5, 1e-5}) {
    Twin twin = window();
    twin.render.phase_error_rad = target;
    const Sampling sampling = render::choose_sampling(twin);
    const Agreement a = with(sampling);
    std::cout << "target " << target << " rad: " << sampling.samples << " samples\n";
    EXPECT_LE(a.pitches[0].phase_rms_rad, target);
  }
}

TEST(Sampling, RefusesWhatMakesNoSense) {
  RenderOptions options;
  options.sampler = Sampler::gauss;
  options.samples = 5;
  EXPECT_THROW(render::choose_sampling(window(), options), UserError);
  options.sampler = Sampler::sobol;
  EXPECT_EQ(render::choose_sampling(window(), options).samples, 5);
  for (int samples : {0, -1, 65537}) {
    options.samples = samples;
    EXPECT_THROW(render::choose_sampling(window(), options), UserError);
  }
}

}  // namespace
}  // namespace fringetwin::testing::sampling_test
