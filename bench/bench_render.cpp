// SPDX-License-Identifier: Apache-2.0
// bench_render [fringes [parts]]: sampling schemes (time and error) and the cost of each effect, one camera
// of the paper's rig, 12 patterns. Times are the smallest of three runs after a warm-up; CPU time is that of
// all threads, so on a loaded machine read that. Errors against the double-precision reference. `fringes`:
// what harmonics and waveforms cost, alone; `parts`: and each step of a frame with harmonics and without. Set
// OMP_WAIT_POLICY=passive: threads that wait for work count as CPU time otherwise, half of a small frame's.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <memory>

#include "render/pattern/form_images.hpp"
#include "render/pattern/response_series.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;
using render::Sampling;

struct Timing {
  double wall_ms = 1e30, cpu_ms = 1e30;
  render::RenderedCamera rendered;
};

Timing measure(const Twin& twin, const Sampling& sampling, int runs,
               render::Renderer* renderer = testing::shared_renderer()) {
  Timing best;
  for (int i = 0; i < runs; ++i) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    best.rendered = renderer->render(twin, 0, sampling);
    const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - wall;
    best.wall_ms = std::min(best.wall_ms, elapsed.count());
    best.cpu_ms = std::min(best.cpu_ms, 1e3 * static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  }
  return best;
}

Shape freeform() {
  const auto mesh = std::make_shared<Mesh>(testing::make_bumpy_icosphere(6, 35.0, testing::default_bumps()));
  return MeshShape{{}, "mm", {rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}}, false, mesh};
}

// ---------------------------------------------------------------- sampling schemes

void compare_sampling(const std::string& name, const Twin& twin, int stride) {
  fmt::print("\n{} ({}x{} px, {} images)\n", name, twin.cameras[0].lens.width(),
             twin.cameras[0].lens.height(), expand_sequence(twin.fringes).size());
  fmt::print("{:<22}{:>9}{:>9}{:>10}{:>14}{:>14}{:>14}\n", "scheme", "wall ms", "CPU ms", "Mrays/s",
             "interior rad", "interior DN", "all pixels DN");
  const auto truth = testing::reference_block(render::Reference(twin), 0,
                                              testing::whole_image(twin, 0, stride), {.gauss_n = 24});
  const Sampling chosen = render::choose_sampling(twin);
  Sampling precise = chosen;
  precise.precise = true;
  const std::vector<std::pair<std::string, Sampling>> schemes{
      {"default", chosen},
      {"default, fp64", precise},
      {"gauss 4", {Sampler::gauss, 4}},
      {"gauss 16", {Sampler::gauss, 16}},
      {"multi-jittered 16", {Sampler::multi_jittered, 16}},
      {"multi-jittered 64", {Sampler::multi_jittered, 64}},
      {"sobol 64", {Sampler::sobol, 64}},
      {"multi-jittered 1024", {Sampler::multi_jittered, 1024}}};
  struct Row {
    double cpu_ms, rays, gray;
  };
  std::vector<Row> rows;
  for (const auto& [label, sampling] : schemes) {
    measure(twin, sampling, 1);
    const Timing t = measure(twin, sampling, sampling.samples > 256 ? 1 : 3);
    const auto inside = testing::compare(twin, 0, t.rendered.irradiance, truth, testing::Pixels::interior);
    const auto all = testing::compare(twin, 0, t.rendered.irradiance, truth, testing::Pixels::all);
    const double full_scale = twin.cameras[0].sensor.max_dn();
    fmt::print("{:<22}{:>9.1f}{:>9.1f}{:>10.1f}{:>14.1e}{:>14.4f}{:>14.4f}\n", label, t.wall_ms, t.cpu_ms,
               static_cast<double>(t.rendered.rays) / t.rendered.trace_ms / 1e3, inside.worst_phase_rms_rad(),
               inside.gray_rms * full_scale, all.gray_rms * full_scale);
    rows.push_back({t.cpu_ms, static_cast<double>(t.rendered.rays), all.gray_rms});
  }
  const Row &own = rows.front(), &published = rows.back();
  fmt::print(
      "default against multi-jittered 1024: {:.0f} times fewer rays, {:.0f} times less CPU time, {:.2g} of "
      "its "
      "gray error over all pixels\n",
      published.rays / own.rays, published.cpu_ms / own.cpu_ms, own.gray / published.gray);
  fmt::print("{} pixels compared, interior as docs/CONVENTIONS.md has it\n", truth.size());
}

// ---------------------------------------------------------------- what a user waits for

// The first time with a new renderer and, by `make`, a new mesh: pipelines, lens tables and BVH are made.
void full_frame(const std::function<Twin()>& make) {
  const Twin twin = make();
  const Sampling sampling = render::choose_sampling(twin);
  const auto renderer = std::make_unique<render::Renderer>();
  const Timing first = measure(twin, sampling, 1, renderer.get());
  const Timing next = measure(twin, sampling, 3, renderer.get());
  fmt::print(
      "\n{}, 1440x1080, 12 images, {:.2g} rays per pixel: first {:.0f} ms wall, {:.0f} ms CPU; again {:.0f} "
      "ms wall, "
      "{:.0f} ms CPU\n",
      twin.objects[0].name,
      static_cast<double>(next.rendered.rays) / static_cast<double>(next.rendered.object.size()),
      first.wall_ms, first.cpu_ms, next.wall_ms, next.cpu_ms);
}

// ---------------------------------------------------------------- effects

struct Effect {
  std::string name;
  std::function<void(Twin&)> switch_on;
};

void compare_effects(const std::string& name, const Twin& base) {
  const std::vector<Effect> effects{
      {"Phong", [](Twin& t) { t.objects[0].material.specular = 0.3; }},
      {"falloff",
       [](Twin& t) { t.projector->inverse_square = true, t.projector->reference_distance_mm = 270.0; }},
      {"ambient", [](Twin& t) { t.projector->ambient = 0.5; }},
      {"projector blur", [](Twin& t) { t.projector->blur_px = 1.0; }},
      {"projector defocus",
       [](Twin& t) {
         t.projector->optics = Optics{2.0, 16.0, 240.0};
       }},
      {"gamma 2.2",
       [](Twin& t) {
         t.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
       }},
      {"pixels, 8 bits",
       [](Twin& t) {
         t.projector->pixel_structure = true;
         t.projector->quantise_bits = 8;
       }},
      {"pixels, gaps, blur",
       [](Twin& t) {
         t.projector->pixel_structure = true;
         t.projector->pixel_fill = 0.9;
         t.projector->blur_px = 0.5;
       }},
      {"GGX",
       [](Twin& t) {
         t.objects[0].material.specular = 0.04;
         t.objects[0].material.specular_model = Material::Specular::ggx;
       }},
      {"vignetting", [](Twin& t) { t.cameras[0].vignetting.kind = Vignetting::Kind::cos4; }},
      {"point spread 0.7 px", [](Twin& t) { t.cameras[0].psf_px = 0.7; }},
      {"plane, one bounce of 16",
       [](Twin& t) {
         t.objects.push_back({"plane", testing::frontal_plane(), {}});
         t.render.bounces = 1;
         t.render.bounce_samples = 16;
       }},
      {"two directions",
       [](Twin& t) {
         t.fringes.directions.push_back(t.fringes.directions[0]);
         t.fringes.directions[1].axis = Axis::y;
       }},
      {"gray code, 6 bits",
       [](Twin& t) {
         t.fringes.directions[0].pitches_px = {20.0};
         t.fringes.directions[0].phase_origin_px = {0.0};
         GrayCode gray;
         gray.bits = 6;
         t.fringes.directions[0].gray = gray;
         t.fringes.unwrap = Unwrap::gray;
       }},
      {"plane behind (shadow)",
       [](Twin& t) {
         t.objects.push_back({"plane", testing::frontal_plane(), {}});
       }},
      {"depth of field f/8", [](Twin& t) {
         t.cameras[0].optics = Optics{8.0, 10.0, 270.0};
       }}};
  fmt::print("\nEffects, {}, default sampling\n{:<24}{:>9}{:>9}{:>8}{:>8}{:>10}\n", name, "effect", "wall ms",
             "CPU ms", "x base", "images", "Mrays");
  const Sampling base_sampling = render::choose_sampling(base);
  measure(base, base_sampling, 1);
  for (const Effect& effect : effects) {
    Twin twin = base;
    effect.switch_on(twin);
    const Sampling sampling = render::choose_sampling(twin);
    measure(twin, sampling, 1);
    double base_cpu = 1e30;
    Timing t;
    for (int round = 0; round < 3; ++round) {  // in turns: the machine's mood changes
      base_cpu = std::min(base_cpu, measure(base, base_sampling, 1).cpu_ms);
      const Timing next = measure(twin, sampling, 1);
      t = {std::min(t.wall_ms, next.wall_ms), std::min(t.cpu_ms, next.cpu_ms), next.rendered};
    }
    fmt::print("{:<24}{:>9.1f}{:>9.1f}{:>8.2f}{:>8}{:>10.2f}\n", effect.name, t.wall_ms, t.cpu_ms,
               t.cpu_ms / base_cpu, t.rendered.irradiance.size(), static_cast<double>(t.rendered.rays) / 1e6);
  }
}

// Phase steps behind a gamma response: harmonics carried, or each step evaluated.
void compare_pattern_methods(const Twin& base) {
  fmt::print("\nGamma 2.2, {}: CPU ms by harmonics / by direct evaluation (harmonics a pitch)\n",
             "window of 240x200 px, 3 pitches");
  for (const double blur : {0.0, 1.2})
    for (const int steps : {4, 8, 12, 16}) {
      Twin twin = base;
      twin.projector->response = {ProjectorResponse::Kind::gamma, 2.2, {}};
      twin.projector->blur_px = blur;
      twin.fringes.steps = steps;
      const Sampling sampling{Sampler::gauss, 16};
      double cpu[2] = {1e30, 1e30};
      for (int round = 0; round < 4; ++round)
        for (const int way : {0, 1}) {
          testing::shared_renderer()->set_tuning({.pattern_method = way == 0
                                                                        ? render::PatternMethod::harmonics
                                                                        : render::PatternMethod::direct});
          const double ms = measure(twin, sampling, 1).cpu_ms;
          if (round > 0) cpu[way] = std::min(cpu[way], ms);
        }
      testing::shared_renderer()->set_tuning({});
      fmt::print("blur {:.1f} px, {:>2} steps{:>10.1f}{:>10.1f}  ({}), taken: {}\n", blur, steps, cpu[0],
                 cpu[1], render::choose_series(twin, render::PatternMethod::harmonics)[0][0].a.size() - 1,
                 render::choose_series(twin)[0][0].a.empty() ? "direct" : "harmonics");
    }
}

// Median CPU ms of each step of the adaptive trace, of what is around it, and of forming the images.
struct FrameParts {
  std::vector<render::StageCost> stages;
  double trace_ms = 0.0, form_ms = 0.0;
};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Two twins in turns: what each part of a frame costs in the one and in the other.
void compare_parts(const Twin& plain, const Twin& with, int rounds) {
  const auto cpu_ms = [] { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  const Twin* twins[] = {&plain, &with};
  std::vector<FrameParts> runs[2];
  for (int round = 0; round <= rounds; ++round)
    for (const int k : {0, 1}) {
      FrameParts parts;
      const double start = cpu_ms();
      render::Transport t =
          testing::shared_renderer()->trace(*twins[k], 0, render::choose_sampling(*twins[k]));
      const double traced = cpu_ms();
      render::form_camera(*twins[k], 0, t, false);
      parts.form_ms = cpu_ms() - traced;
      parts.trace_ms = traced - start;
      parts.stages = std::move(t.stages);
      if (round > 0) runs[k].push_back(std::move(parts));  // the first makes kernels
    }
  for (const int k : {0, 1}) {
    const auto of = [&](const auto& part) {
      std::vector<double> values;
      for (const FrameParts& r : runs[k]) values.push_back(part(r));
      return median(std::move(values));
    };
    fmt::print("    {}: trace {:.1f}, images {:.1f};", k == 0 ? "plain" : "with ",
               of([](const FrameParts& r) { return r.trace_ms; }),
               of([](const FrameParts& r) { return r.form_ms; }));
    for (std::size_t s = 0; s < runs[k][0].stages.size(); ++s)
      fmt::print(" {} {} px {:.1f}", runs[k][0].stages[s].name, runs[k][0].stages[s].pixels,
                 of([&](const FrameParts& r) { return r.stages[s].cpu_ms; }));
    fmt::print("\n");
  }
}

// One pitch of 60 px, 12 steps; with Gray code as the real sets have it.
Twin twelve_steps(Twin twin, bool gray_code) {
  twin.fringes.steps = 12;
  twin.fringes.unwrap = gray_code ? Unwrap::gray : Unwrap::none;
  twin.fringes.directions[0] = {Axis::x, {60.0}, {30.0}, {}};
  if (gray_code)
    twin.fringes.directions[0].gray = GrayCode{.bits = 5, .complementary = true, .offset_periods = -0.5};
  return twin;
}

// Fringes that are no sinusoids beside those that are, in turns.
void compare_fringes(const std::string& name, const Twin& base, bool parts) {
  const Harmonics five{{0.004, -0.011}, {-0.003, 0.008}, {0.001, 0.005}, {0.002, -0.003}, {-0.001, 0.002}};
  const auto flicker = [](Twin& t) {
    std::vector<double>& factors = t.projector->light_factors;
    factors.assign(expand_sequence(t.fringes).size(), 1.0);
    for (std::size_t k = 0; k < factors.size(); ++k) factors[k] = k % 2 == 0 ? 1.02 : 1.0 / 1.02;
  };
  const std::vector<Effect> fringes{{"harmonics 2 to 6",
                                     [&](Twin& t) {
                                       for (DirectionFringes& d : t.fringes.directions)
                                         d.harmonics.assign(d.pitches_px.size(), five);
                                     }},
                                    {"light of each image", flicker},
                                    {"light and harmonics",
                                     [&](Twin& t) {
                                       flicker(t);
                                       for (DirectionFringes& d : t.fringes.directions)
                                         d.harmonics.assign(d.pitches_px.size(), five);
                                     }},
                                    {"binary, blur 1 px",
                                     [](Twin& t) {
                                       t.projector->blur_px = 1.0;
                                       t.fringes.waveform = {Waveform::Kind::levels, {1.0, 0.0, 0.0, 1.0}};
                                     }},
                                    {"blur field", [](Twin& t) {
                                       t.projector->blur_px = 1.0;
                                       t.projector->blur_field_px2 = {0.1, -0.2, 1.2, 0.3, 0.9};
                                     }}};
  fmt::print("\nFringes that are no sinusoids, {}, 1440x1080, default sampling\n", name);
  fmt::print("{:<44}{:>9}{:>9}{:>8}{:>8}\n", "", "wall ms", "CPU ms", "x plain", "samples");
  for (const auto& [sequence, plain] :
       {std::pair{"3 pitches, 4 steps", base}, std::pair{"1 pitch, 12 steps", twelve_steps(base, false)},
        std::pair{"1 pitch, 12 steps, Gray code", twelve_steps(base, true)}})
    for (const Effect& fringe : fringes) {
      Twin twin = plain;
      fringe.switch_on(twin);
      const Sampling with = render::choose_sampling(twin), without = render::choose_sampling(plain);
      Timing t = measure(twin, with, 1), p = measure(plain, without, 1);
      for (int round = 0; round < 4; ++round) {
        const Timing a = measure(plain, without, 1), b = measure(twin, with, 1);
        p.cpu_ms = round == 0 ? a.cpu_ms : std::min(p.cpu_ms, a.cpu_ms);
        t = {round == 0 ? b.wall_ms : std::min(t.wall_ms, b.wall_ms),
             round == 0 ? b.cpu_ms : std::min(t.cpu_ms, b.cpu_ms), b.rendered};
      }
      fmt::print("{:<44}{:>9.1f}{:>9.1f}{:>8.2f}{:>8}\n", fmt::format("{}, {}", sequence, fringe.name),
                 t.wall_ms, t.cpu_ms, t.cpu_ms / p.cpu_ms, t.rendered.sampling.samples);
      if (parts && fringe.name.starts_with("harm")) compare_parts(plain, twin, 15);
    }
}

}  // namespace

int main(int n_arguments, char** arguments) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // rows appear as they are measured
  try {
    if (!testing::shared_renderer()) {
      fmt::print(stderr, "bench_render: no Vulkan device\n");
      return static_cast<int>(ExitCode::device);
    }
    const auto& device = testing::shared_renderer()->device();
    fmt::print("device {} ({}, Vulkan {})\n", device.name, device.driver, device.api_version);

    const Twin left = testing::only_camera(testing::paper_rig(), 0);
    if (n_arguments > 1 && std::string(arguments[1]) == "fringes") {
      const bool parts = n_arguments > 2;
      compare_fringes("sphere R 19 mm", testing::with_object(left, "ball", testing::physical_sphere()),
                      parts);
      compare_fringes("mesh of 81,920 triangles", testing::with_object(left, "mesh", freeform()), parts);
      return 0;
    }
    compare_sampling("sphere R 5 mm, window",
                     testing::with_object(testing::crop_around(left, {0, 0, 250}, 128, 112), "sphere",
                                          testing::ideal_sphere()),
                     2);
    const Shape mesh = freeform();
    compare_sampling("mesh of 81,920 triangles, window",
                     testing::with_object(testing::crop_around(left, {0, 0, 240}, 96, 96), "mesh", mesh), 3);
    full_frame([&] { return testing::with_object(left, "sphere R 19 mm", testing::physical_sphere()); });
    full_frame([&] { return testing::with_object(left, "mesh of 81,920 triangles", freeform()); });
    compare_effects(
        "sphere R 19 mm, window of 240x200 px",
        testing::with_object(testing::crop_around(left, testing::physical_sphere().center_mm, 240, 200),
                             "sphere", testing::physical_sphere()));
    compare_pattern_methods(
        testing::with_object(testing::crop_around(left, testing::physical_sphere().center_mm, 240, 200),
                             "sphere", testing::physical_sphere()));
    compare_effects("mesh of 81,920 triangles, window of 120x100 px",
                    testing::with_object(testing::crop_around(left, {0, 0, 240}, 120, 100), "mesh", mesh));
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_render: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
