// SPDX-License-Identifier: Apache-2.0
// bench_mesh: where the time of a triangle mesh goes. The steps of the adaptive trace on the free-form part
// (one camera of the paper's rig, whole frame), then what the size of the mesh does to building and tracing.
// bench_mesh TWIN.toml: the steps of the adaptive trace of every camera of that twin.
// CPU seconds of all threads; the smallest of a few rounds.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>

#include "tests/support/agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;

double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

Twin freeform(int subdivisions) {
  const auto mesh =
      std::make_shared<Mesh>(testing::make_bumpy_icosphere(subdivisions, 35.0, testing::default_bumps()));
  return testing::with_object(testing::only_camera(testing::paper_rig(), 0), "mesh",
                              MeshShape{{}, "mm", {Eigen::Matrix3d::Identity(), {0, 0, 270}}, false, mesh});
}

void stages(const Twin& twin, int camera, int rounds) {
  RenderOptions options = twin.render;
  options.sampler = Sampler::adaptive;
  const render::Sampling sampling = render::choose_sampling(twin, options);
  render::Transport best;
  double best_ms = 1e30;
  for (int i = 0; i < rounds + 1; ++i) {
    const double start = cpu_ms();
    render::Transport t = testing::shared_renderer()->trace(twin, camera, sampling);
    const double ms = cpu_ms() - start;
    if (i == 0 || ms >= best_ms) continue;  // the first makes pipelines
    best_ms = ms;
    best = std::move(t);
  }
  fmt::print(
      "\nadaptive, {} x {} px: {:.0f} ms CPU, {:.2f} M rays; estimate {:.1e} rad, {:.1e} of full scale\n",
      best.mean.width, best.mean.height, best_ms, static_cast<double>(best.rays) / 1e6,
      best.estimate->phase_rad, best.estimate->gray);
  fmt::print("{:<10}{:>10}{:>12}{:>10}{:>10}\n", "step", "pixels", "M rays", "CPU ms", "Mrays/s");
  for (const render::StageCost& s : best.stages)
    fmt::print("{:<10}{:>10}{:>12.3f}{:>10.1f}{:>10.2f}\n", s.name, s.pixels,
               static_cast<double>(s.rays) / 1e6, s.cpu_ms, static_cast<double>(s.rays) / s.cpu_ms / 1e3);
}

void gauss(const Twin& twin, int rounds) {
  double best = 1e30;
  std::uint64_t rays = 0;
  for (int i = 0; i < rounds + 1; ++i) {
    const double start = cpu_ms();
    rays = testing::shared_renderer()->trace(twin, 0, {Sampler::gauss, 4}).rays;
    best = std::min(best, cpu_ms() - start);
  }
  fmt::print("gauss 2 x 2: {:.0f} ms CPU, {:.2f} M rays\n", best, static_cast<double>(rays) / 1e6);
}

void sizes(int most) {
  fmt::print("\n{:>10}{:>12}{:>14}{:>12}{:>14}\n", "triangles", "build ms", "peak RSS MiB", "gauss ms",
             "adaptive ms");
  for (int n = 3; n <= most; ++n) {
    const Twin twin = freeform(n);
    RenderOptions options;
    options.sampler = Sampler::adaptive;
    const render::Sampling adaptive = render::choose_sampling(twin, options);
    double first = 0.0, g = 1e30, a = 1e30;
    for (int i = 0; i < 3; ++i) {
      double start = cpu_ms();
      testing::shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
      if (i == 0) first = cpu_ms() - start;
      g = std::min(g, cpu_ms() - start);
      start = cpu_ms();
      testing::shared_renderer()->trace(twin, 0, adaptive);
      a = std::min(a, cpu_ms() - start);
    }
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    fmt::print("{:>10}{:>12.0f}{:>14.0f}{:>12.0f}{:>14.0f}\n", 20ULL << (2 * n), first - g,
               static_cast<double>(usage.ru_maxrss) / 1024.0, g, a);
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    if (!testing::shared_renderer()) {
      fmt::print(stderr, "bench_mesh: no Vulkan device\n");
      return static_cast<int>(ExitCode::device);
    }
    if (argc > 1 && std::string(argv[1]).ends_with(".toml")) {
      Twin twin = load_twin(argv[1]);
      load_meshes(twin);
      for (int c = 0; c < static_cast<int>(twin.cameras.size()); ++c) stages(twin, c, 2);
      return 0;
    }
    const Twin twin = freeform(6);
    fmt::print("free-form part of 81,920 triangles\n");
    for (const bool search : {true, false}) {
      fmt::print("\n{}\n", search ? "every ray through the BVH" : "as it is");
      testing::shared_renderer()->set_tuning({.search_always = search});
      gauss(twin, 2);
      stages(twin, 0, 2);
    }
    if (argc > 1) sizes(std::atoi(argv[1]));
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_mesh: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
