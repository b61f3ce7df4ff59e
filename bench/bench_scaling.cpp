// SPDX-License-Identifier: Apache-2.0
// bench_scaling [PLOT.svg]: what one camera's frame costs as the scene grows, one thing at a time: triangles,
// pixels, images. CPU time of all threads (on a loaded machine read that); the first frame of a mesh also
// builds its hierarchy and its pipelines.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/renderer.hpp"
#include "render/scene/bvh_cache.hpp"
#include "report/plot/plot.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"
#include "twin/fringes.hpp"

namespace {

using namespace fringetwin;

double cpu_now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

double resident_mib() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmRSS:")) return std::atof(line.c_str() + 6) / 1024.0;
  return 0.0;
}

struct Cost {
  double first_s = 0.0, next_s = 0.0, resident_mib = 0.0, rays_per_px = 0.0;
};

Cost measure(const Twin& twin) {
  const double before_mib = resident_mib();
  render::Renderer renderer;
  const render::Sampling sampling = render::choose_sampling(twin);
  Cost cost;
  for (int i = 0; i < 3; ++i) {
    const double start = cpu_now_s();
    const auto frame = renderer.render(twin, 0, sampling);
    const double s = cpu_now_s() - start;
    (i == 0 ? cost.first_s : cost.next_s) = i == 2 ? std::min(cost.next_s, s) : s;
    cost.rays_per_px = static_cast<double>(frame.rays) / static_cast<double>(frame.object.size());
    cost.resident_mib = resident_mib() - before_mib;
  }
  return cost;
}

Twin mesh_twin(int subdivisions) {
  const auto mesh =
      std::make_shared<Mesh>(testing::make_bumpy_icosphere(subdivisions, 35.0, testing::default_bumps()));
  const MeshShape part{{}, "mm", {rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}}, false, mesh};
  return testing::with_object(testing::only_camera(testing::paper_rig(), 0), "part", part);
}

// The same view in k x k times the pixels; the projector stays.
Twin scaled_image(double k) {
  Twin twin =
      testing::with_object(testing::only_camera(testing::paper_rig(), 0), "ball", testing::physical_sphere());
  Camera& camera = twin.cameras[0];
  std::vector<double> intrinsics = camera.lens.intrinsics();
  for (int i = 0; i < 4; ++i) intrinsics[static_cast<std::size_t>(i)] *= k;
  for (int i = 2; i < 4; ++i) intrinsics[static_cast<std::size_t>(i)] += 0.5 * (k - 1.0);
  camera.lens = Lens(camera.lens.model(), intrinsics,
                     {static_cast<int>(std::lround(k * camera.lens.width())),
                      static_cast<int>(std::lround(k * camera.lens.height()))},
                     "scaled camera");
  return twin;
}

Twin images_twin(int steps) {
  Twin twin =
      testing::with_object(testing::only_camera(testing::paper_rig(), 0), "ball", testing::physical_sphere());
  twin.fringes.steps = steps;
  return twin;
}

struct Curve {
  std::string title, color;
  report::Series first, next;
};

Curve curve(const std::string& title, const std::string& color) {
  Curve c;
  c.title = title;
  for (report::Series* s : {&c.first, &c.next}) {
    s->color = color;
    s->style = s == &c.first ? report::Series::Style::dashed : report::Series::Style::line;
    s->title = title + (s == &c.first ? ", first frame" : "");
  }
  return c;
}

void add(Curve& curve, const std::string& what, double size, const Twin& twin) {
  const Cost cost = measure(twin);
  fmt::print("{:<26}{:>12.3f}{:>12.3f}{:>12.0f}{:>12.2f}\n", what, cost.first_s, cost.next_s,
             cost.resident_mib, cost.rays_per_px);
  std::fflush(stdout);
  curve.first.x.push_back(size);
  curve.first.y.push_back(cost.first_s);
  curve.next.x.push_back(size);
  curve.next.y.push_back(cost.next_s);
}

// What a second run saves for a large mesh: its hierarchy is read back from the user's cache.
void compare_cache(int subdivisions) {
  const Mesh mesh = testing::make_bumpy_icosphere(subdivisions, 35.0, testing::default_bumps());
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("fringetwin_bench_scaling_{}", ::getpid());
  const auto timed = [&](const std::optional<std::filesystem::path>& cache) {
    const auto start = std::chrono::steady_clock::now();
    render::cached_bvh(mesh.vertices_mm, mesh.triangles, 32, cache);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  double built = HUGE_VAL, read = HUGE_VAL;
  const double first = timed(folder);
  for (int i = 0; i < 3; ++i) {  // in turns
    built = std::min(built, timed({}));
    read = std::min(read, timed(folder));
  }
  std::filesystem::remove_all(folder);
  fmt::print("{:<26}{:>12.3f}{:>12.3f}{:>12.3f}{:>11.1f}x\n",
             fmt::format("{} triangles", mesh.triangles.size()), built, first, read, built / read);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    ::setenv("FRINGETWIN_CACHE", "", 1);  // first frames are to be first ones
    fmt::print("{:<26}{:>12}{:>12}{:>12}{:>12}\n", "one frame, default sampling", "first CPU s", "next CPU s",
               "MiB", "rays/px");
    Curve triangles = curve("triangles / 82k (1440 x 1080, 12 images)", report::color::kReal);
    for (int n = 3; n <= 9; ++n) {
      const double count = 20.0 * std::pow(4.0, n);
      add(triangles, fmt::format("{:.0f} triangles", count), count / 81920.0, mesh_twin(n));
    }
    Curve pixels = curve("pixels / 1.6 M (sphere, 12 images)", report::color::kSimulated);
    for (const double k : {0.45, 1.0, 2.0, 3.6}) {
      const Twin twin = scaled_image(k);
      add(pixels,
          fmt::format("{:.1f} Mpx", 1e-6 * twin.cameras[0].lens.width() * twin.cameras[0].lens.height()),
          k * k, twin);
    }
    Curve images = curve("images / 12 (sphere, 1440 x 1080)", report::color::kThird);
    for (const int steps : {3, 4, 8, 16, 32}) {
      const Twin twin = images_twin(steps);
      const double n = static_cast<double>(expand_sequence(twin.fringes).size());
      add(images, fmt::format("{:.0f} images", n), n / 12.0, twin);
    }
    fmt::print("{:<26}{:>12}{:>12}{:>12}{:>12}\n", "hierarchy, wall s", "built", "and kept", "read", "gain");
    for (int n = 7; n <= 9; ++n) compare_cache(n);
    if (argc > 1) {
      report::Plot plot;
      plot.x_label = "size, relative to the published scene's";
      plot.y_label = "CPU time of one frame [s]";
      plot.log_x = plot.log_y = true;
      plot.height_px = 420;
      for (const Curve& c : {triangles, pixels, images}) {
        plot.series.push_back(c.next);
        plot.series.push_back(c.first);
      }
      std::ofstream(argv[1]) << report::plot_svg(plot, "scaling");
    }
    return 0;
  } catch (const UserError& e) {
    fmt::print(stderr, "bench_scaling: {}\n", e.what());
    return 1;
  }
}
