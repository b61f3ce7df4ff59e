// SPDX-License-Identifier: Apache-2.0
// bench_povray: what a user can have from POV-Ray (Debian package povray): a sphere before a plane, the
// fringe as a function of space, a light at the projector. Both programs' images against the double-precision
// reference of the same scene. Pinhole lenses: POV-Ray's cameras have no distortion.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "tests/support/povray.hpp"
#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;
namespace fs = std::filesystem;

constexpr int kWidth = 320, kHeight = 240;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The paper's geometry with pinhole lenses, a window around the sphere, one pitch in four steps.
Twin make_twin() {
  Twin twin = testing::only_camera(testing::paper_rig(), 0);
  Camera& camera = twin.cameras[0];
  camera.lens = Lens("LENSMODEL_PINHOLE", {2359.5, 2359.5, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1)},
                     {kWidth, kHeight}, "camera");
  camera.sensor = {};
  camera.sensor.gain_dn = 255.0;
  Projector& p = *twin.projector;
  const auto& f = p.lens.intrinsics();
  p.lens =
      Lens("LENSMODEL_PINHOLE", {f[0], f[1], f[2], f[3]}, {p.lens.width(), p.lens.height()}, "projector");
  DirectionFringes& d = twin.fringes.directions[0];
  d.pitches_px = {15.0};
  d.phase_origin_px = {0.0};
  twin.fringes.unwrap = Unwrap::none;
  twin.fringes.mean = 0.5;
  twin.fringes.amplitude = 0.49;
  Material material;
  material.diffuse = 1.0;
  p.intensity = std::numbers::pi;  // then E = pattern x cosine
  twin = testing::with_object(twin, "sphere", testing::ideal_sphere(), material);
  return testing::with_object(twin, "plane", testing::frontal_plane(), material);
}

struct Measured {
  std::vector<ImageF> irradiance;
  double image_s = 0.0;  ///< per image
};

std::optional<Measured> run_povray(const Twin& twin, const testing::PovraySampling& sampling,
                                   const fs::path& dir) {
  const double start = now_s();
  auto irradiance = testing::povray_irradiance(twin, 0, sampling, dir);
  if (!irradiance) return std::nullopt;
  return Measured{std::move(*irradiance), (now_s() - start) / twin.fringes.steps};
}

void print_row(const std::string& name, const Twin& twin, const Measured& m,
               const std::vector<testing::ReferenceBlockPixel>& truth) {
  const auto inside = testing::compare(twin, 0, m.irradiance, truth, testing::Pixels::interior);
  const auto all = testing::compare(twin, 0, m.irradiance, truth, testing::Pixels::all);
  fmt::print("{:<44}{:>13.1f}{:>15.1e}{:>15.4f}{:>13.4f}\n", name, 1e3 * m.image_s,
             inside.worst_phase_rms_rad(), 255.0 * inside.gray_rms, 255.0 * all.gray_rms);
}

Measured run_own(const Twin& twin, const render::Sampling& sampling) {
  Measured out;
  testing::shared_renderer()->render(twin, 0, sampling);  // builds the pipeline
  out.image_s = 1e30;
  for (int i = 0; i < 3; ++i) {
    const double start = now_s();
    out.irradiance = testing::shared_renderer()->render(twin, 0, sampling).irradiance;
    out.image_s = std::min(out.image_s, (now_s() - start) / twin.fringes.steps);
  }
  return out;
}

int run() {
  const testing::ScratchFolder dir;
  const Twin twin = make_twin();
  const auto truth =
      testing::reference_block(render::Reference(twin), 0, testing::whole_image(twin, 0, 4), {.gauss_n = 24});
  fmt::print("\nsphere R 5 mm before a plane, {} x {} px, pinhole lenses, pitch 15 px, {} steps\n", kWidth,
             kHeight, twin.fringes.steps);
  fmt::print("{:<44}{:>13}{:>15}{:>15}{:>13}\n", "", "ms an image", "interior rad", "interior DN", "all DN");
  print_row("fringetwin, default", twin, run_own(twin, render::choose_sampling(twin)), truth);
  print_row("fringetwin, multi-jittered 1024", twin, run_own(twin, {Sampler::multi_jittered, 1024}), truth);
  const auto povray_row = [&](const std::string& name, const testing::PovraySampling& sampling) {
    if (const auto m = run_povray(twin, sampling, dir.path()))
      print_row(name, twin, *m, truth);
    else
      fmt::print("{}: cannot be started\n", name);
  };
  for (const int side : {1, 4, 8})
    povray_row(fmt::format("POV-Ray, fringe as a function, {} samples", side * side),
               {.own_supersampling = side, .processes = 1, .threads = 2});
  povray_row("POV-Ray, 64 Gauss samples averaged by us", {.cells = 4});
  return 0;
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    if (!testing::shared_renderer()) {
      fmt::print(stderr, "bench_povray: no Vulkan device\n");
      return static_cast<int>(ExitCode::device);
    }
    return run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_povray: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
