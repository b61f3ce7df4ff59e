// SPDX-License-Identifier: Apache-2.0
// No tolerances: what was rendered is what is written.
#include "cosim/simulate.hpp"

#include <gtest/gtest.h>

namespace fringetwin::cosim::simulate_test {
namespace {

TEST(RenderNote, SaysEachNumberOfTheRendering) {
  render::RenderedCamera rendered;
  rendered.camera = "left";
  rendered.object = Image<std::int32_t>(8, 4, 0);
  rendered.rays = 80;
  rendered.sampling.sampler = Sampler::adaptive;
  rendered.sampling.samples = 7;
  rendered.sampling.precise = true;
  rendered.estimate.emplace();
  rendered.estimate->phase_rad = 0.125;
  rendered.estimate->gray = 0.5;
  rendered.estimate->gray_inside = 0.25;
  const compare::RenderNote adaptive = note_of(rendered);
  EXPECT_EQ(adaptive.camera, "left");
  EXPECT_EQ(adaptive.sampler, "adaptive");
  EXPECT_EQ(adaptive.samples, std::nullopt) << "it takes as many as it needs";
  EXPECT_TRUE(adaptive.double_precision);
  EXPECT_EQ(adaptive.rays_per_pixel, 2.5);
  EXPECT_EQ(adaptive.phase_error_rad, 0.125);
  EXPECT_EQ(adaptive.gray_error, 0.5);
  EXPECT_EQ(adaptive.gray_inside_error, 0.25);

  rendered.sampling.sampler = Sampler::sobol;
  rendered.sampling.precise = false;
  rendered.estimate.reset();
  const compare::RenderNote fixed = note_of(rendered);
  EXPECT_EQ(fixed.sampler, "sobol");
  EXPECT_EQ(fixed.samples, 7);
  EXPECT_FALSE(fixed.double_precision);
  EXPECT_EQ(fixed.phase_error_rad, std::nullopt);
  EXPECT_EQ(fixed.gray_error, std::nullopt);
  EXPECT_EQ(fixed.gray_inside_error, std::nullopt);
}

// A target that is asked for replaces a scheme that the file fixes; what is asked for besides comes on top.
TEST(RenderOptions, TheRequestReplacesWhatTheTwinSays) {
  Twin twin;
  twin.render.phase_error_rad = 1e-3, twin.render.gray_error = 2e-3;
  twin.render.samples = 16;
  twin.render.sampler = Sampler::gauss;
  const RenderOptions as_written = render_options(twin, {});
  EXPECT_EQ(as_written.samples, 16);
  EXPECT_EQ(as_written.phase_error_rad, 1e-3);
  RenderRequest request;
  request.gray_error = 5e-5;
  const RenderOptions by_target = render_options(twin, request);
  EXPECT_EQ(by_target.phase_error_rad, 1e-3);
  EXPECT_EQ(by_target.gray_error, 5e-5);
  EXPECT_EQ(by_target.samples, std::nullopt);
  EXPECT_EQ(by_target.sampler, std::nullopt);
  request.samples = 64;
  request.sampler = "sobol";
  const RenderOptions both = render_options(twin, request);
  EXPECT_EQ(both.samples, 64);
  EXPECT_EQ(both.sampler, Sampler::sobol);
}

}  // namespace
}  // namespace fringetwin::cosim::simulate_test
