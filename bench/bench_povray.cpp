// SPDX-License-Identifier: Apache-2.0
// bench_povray: what a user can have from POV-Ray (Debian package povray; used when it is there, never
// installed by us): a sphere before a plane, the fringe as a function of space, a light at the projector.
// Both programs' images against the double-precision reference of the same scene. Pinhole camera and
// projector: POV-Ray has no distorted lenses.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "report/process.hpp"
#include "tests/accuracy/agreement.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/errors.hpp"
#include "twin/image_io.hpp"

namespace {

using namespace fringetwin;
namespace fs = std::filesystem;

constexpr int width = 320, height = 240;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The paper's geometry with pinhole lenses, a window around the sphere, one pitch in four steps.
Twin make_twin() {
  Twin twin = test::only_camera(test::paper_rig(), 0);
  Camera& camera = twin.cameras[0];
  camera.lens = Lens("LENSMODEL_PINHOLE", {2359.5, 2359.5, 0.5 * (width - 1), 0.5 * (height - 1)},
                     {width, height}, "camera");
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
  twin.fringes.amplitude = 0.49;  // a colour map wraps at exactly 1
  Material material;
  material.diffuse = 1.0;
  p.intensity = std::numbers::pi;  // then E = pattern x cosine, as POV-Ray's diffuse 1
  twin = test::with_object(twin, "sphere", test::ideal_sphere(), material);
  return test::with_object(twin, "plane", test::frontal_plane(), material);
}

std::string pov_scene(const Twin& twin, int step) {
  const Projector& p = *twin.projector;
  const auto& R = p.T_proj_world.rotation;
  const auto& t = p.T_proj_world.translation_mm;
  const auto row = [&](int i) {
    return fmt::format("({:.17g}*x+{:.17g}*y+{:.17g}*z+{:.17g})", R(i, 0), R(i, 1), R(i, 2), t[i]);
  };
  const auto& f = p.lens.intrinsics();
  const DirectionFringes& d = twin.fringes.directions[0];
  const double fc = twin.cameras[0].lens.intrinsics()[0];
  const Eigen::Vector3d light = p.center_world_mm();
  const SphereShape s = test::ideal_sphere();
  std::string scene = "#version 3.7;\nglobal_settings { assumed_gamma 1.0 }\n";
  scene += fmt::format(
      "camera {{ perspective location <0,0,0> direction <0,0,1> right <{:.17g},0,0> up <0,{:.17g},0> }}\n",
      width / fc, -height / fc);
  scene += fmt::format("light_source {{ <{:.17g},{:.17g},{:.17g}> color rgb 1 }}\n", light.x(), light.y(),
                       light.z());
  scene += fmt::format(
      "#declare fringe = texture {{ pigment {{ function {{ "
      "{:.17g}+{:.17g}*cos(2*pi*({:.17g}*{}/{}+{:.17g})/{:.17g}"
      "+{:.17g}) }} color_map {{ [0 rgb 0] [1 rgb 1] }} }} finish {{ ambient 0 diffuse 1 specular 0 phong 0 "
      "}} }}\n",
      twin.fringes.mean, twin.fringes.amplitude, f[0], row(0), row(2), f[2], d.pitches_px[0],
      2.0 * std::numbers::pi * step / twin.fringes.steps);
  scene += fmt::format("sphere {{ <{},{},{}>, {} texture {{ fringe }} }}\n", s.center_mm.x(), s.center_mm.y(),
                       s.center_mm.z(), s.radius_mm);
  scene += "plane { <0,0,-1>, -300 texture { fringe } }\n";
  return scene;
}

struct Measured {
  std::vector<ImageF> irradiance;
  double image_s = 0.0;  ///< per image
};

/// `side` x `side` samples per pixel on a regular grid; nullopt where the program cannot be started.
std::optional<Measured> run_povray(const Twin& twin, int side, const fs::path& dir) {
  Measured out;
  for (int step = 0; step < twin.fringes.steps; ++step) {
    const fs::path scene = dir / "scene.pov", image = dir / "image.png";
    write_text_file(scene, pov_scene(twin, step));
    std::vector<std::string> argv{"povray",
                                  "+I" + scene.string(),
                                  "+O" + image.string(),
                                  fmt::format("+W{}", width),
                                  fmt::format("+H{}", height),
                                  "+FN16",
                                  "Grayscale_Output=on",
                                  "File_Gamma=1.0",
                                  "-D",
                                  "-GA",
                                  "+WT2"};
    if (side > 1)
      argv.insert(argv.end(), {"+A0.0", "+AM1", "-J", fmt::format("+R{}", side)});
    else
      argv.push_back("-A");
    const double start = now_s();
    const auto result = report::run_process(argv, "");
    out.image_s += (now_s() - start) / twin.fringes.steps;
    if (!result || result->status == 127) return std::nullopt;
    if (result->status != 0)
      throw UserError(ExitCode::internal, "povray", "failed: " + result->err.substr(0, 500));
    ImageF gray = read_gray(image).image;
    for (float& v : gray.data) v /= 65535.0F;
    out.irradiance.push_back(std::move(gray));
  }
  return out;
}

void print_row(const std::string& name, const Twin& twin, const Measured& m,
               const std::vector<render::ReferenceBlockPixel>& truth) {
  const auto inside = test::compare(twin, 0, m.irradiance, truth, test::Pixels::interior);
  const auto all = test::compare(twin, 0, m.irradiance, truth, test::Pixels::all);
  fmt::print("{:<44}{:>13.1f}{:>15.1e}{:>15.4f}{:>13.4f}\n", name, 1e3 * m.image_s,
             inside.worst_phase_rms_rad(), 255.0 * inside.gray_rms, 255.0 * all.gray_rms);
}

Measured run_own(const Twin& twin, const render::Sampling& sampling) {
  Measured out;
  test::shared_renderer()->render(twin, 0, sampling);  // builds the pipeline
  out.image_s = 1e30;
  for (int i = 0; i < 3; ++i) {
    const double start = now_s();
    out.irradiance = test::shared_renderer()->render(twin, 0, sampling).irradiance;
    out.image_s = std::min(out.image_s, (now_s() - start) / twin.fringes.steps);
  }
  return out;
}

int run() {
  std::string pattern = (fs::temp_directory_path() / "fringetwin-povray-XXXXXX").string();
  FT_CHECK(mkdtemp(pattern.data()) != nullptr, "a scratch folder can be made");
  const fs::path dir = pattern;
  const Twin twin = make_twin();
  const auto truth =
      reference_block(render::Reference(twin), 0, test::whole_image(twin, 0, 4), {.gauss_n = 24});
  fmt::print("\nsphere R 5 mm before a plane, {} x {} px, pinhole lenses, pitch 15 px, {} steps\n", width,
             height, twin.fringes.steps);
  fmt::print("{:<44}{:>13}{:>15}{:>15}{:>13}\n", "", "ms an image", "interior rad", "interior DN", "all DN");
  print_row("fringetwin, default", twin, run_own(twin, render::choose_sampling(twin)), truth);
  print_row("fringetwin, multi-jittered 1024", twin, run_own(twin, {Sampler::multi_jittered, 1024}), truth);
  for (const int side : {1, 4, 8}) {
    const auto m = run_povray(twin, side, dir);
    if (!m) {
      fmt::print("POV-Ray: not on this machine (Debian package povray), so it is not compared\n");
      break;
    }
    print_row(fmt::format("POV-Ray, fringe as a function, {} samples", side * side), twin, *m, truth);
  }
  fs::remove_all(dir);
  return 0;
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    if (!test::shared_renderer()) {
      fmt::print(stderr, "bench_povray: no Vulkan device\n");
      return static_cast<int>(ExitCode::device);
    }
    return run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_povray: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
