// SPDX-License-Identifier: Apache-2.0
// bench_compare [RUNS]: what a comparison costs once the images are there, per stage: two cameras of the
// paper's rig, a plane that fills both images, 2 x 24 images of 1440 x 1080 (two fringe directions). Rendered
// once; the real side is an exposure with another seed. Smallest of RUNS (default 3), wall and CPU time of
// all threads.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "compare/comparison.hpp"
#include "compare/page/report_page.hpp"
#include "compare/result/result_json.hpp"
#include "render/sensor/all_cameras.hpp"
#include "render/sensor/sensor.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;

/// Smallest times over the runs of one stage.
struct Stage {
  std::string name;
  double wall_s = 1e30, cpu_s = 1e30;

  void run(const std::function<void()>& what) {
    const auto wall = std::chrono::steady_clock::now();
    const std::clock_t cpu = std::clock();
    what();
    wall_s = std::min(wall_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - wall).count());
    cpu_s = std::min(cpu_s, static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC);
  }
};

Twin filled_rig() {
  Twin twin = testing::with_object(testing::paper_rig(), "wall", testing::frontal_plane());
  for (Camera& camera : twin.cameras) {
    camera.sensor.electrons_per_dn = 40.0;
    camera.sensor.read_noise_dn = 0.5;
  }
  DirectionFringes y = twin.fringes.directions.front();
  y.axis = Axis::y;
  twin.fringes.directions.push_back(y);
  twin.measure.fits.push_back({"wall", 2.0});
  return twin;
}

double share_of_valid(const compare::Side& side) {
  double n = 0.0, all = 0.0;
  for (const auto& camera : side.measurement->cameras) {
    n += static_cast<double>(std::count(camera.flags.data.begin(), camera.flags.data.end(), measure::kValid));
    all += static_cast<double>(camera.flags.size());
  }
  return n / all;
}

double load_average() {
  double load = 0.0;
  std::ifstream("/proc/loadavg") >> load;
  return load;
}

void bench(int runs) {
  const Twin rig = filled_rig();
  const Twin blurred = [&] {
    Twin twin = rig;
    twin.projector->blur_px = 1.0;  // what the search for causes has to find
    return twin;
  }();
  render::Renderer renderer;
  compare::Side real, simulated, wrong;
  real.images = render::expose_all(render::render_all(renderer, rig, 0), rig, 2);
  for (auto [side, twin] : {std::pair{&simulated, &rig}, std::pair{&wrong, &blurred}}) {
    auto rendered = render::render_all(renderer, *twin, 0);
    side->images = render::expose_all(rendered, *twin, 1);
    for (auto& camera : rendered) side->irradiance.push_back(render::as_radiance(std::move(camera)));
  }
  wrong.measurement = measure::measure(blurred, wrong.images);

  compare::CompareOptions with_causes;
  with_causes.renderer = &renderer;
  compare::Comparison plain, searched;
  std::size_t page_bytes = 0;
  const auto dir = std::filesystem::temp_directory_path() / fmt::format("bench_compare_{}", ::getpid());
  Stage measure{"measure both sides"}, compare{"compare, no renderer"}, causes{"compare, search for causes"},
      report{"report"};
  const double load_before = load_average();
  for (int i = 0; i < runs; ++i) {
    measure.run([&] {
      simulated.measurement = measure::measure(rig, simulated.images);
      real.measurement = measure::measure(rig, real.images);
    });
    compare.run([&] { plain = compare::compare(rig, real, simulated, {}); });
    causes.run([&] { searched = compare::compare(blurred, real, wrong, with_causes); });
    report.run([&] { compare::write_report(dir, rig, real, simulated, plain, {}, {}, {}); });
    page_bytes = std::filesystem::file_size(dir / "report.html");
  }
  std::filesystem::remove_all(dir);

  fmt::print(
      "comparison of 2 x {} images of {} x {} px, {:.0f} % of the pixels valid on both sides; {} cores, load "
      "{:.1f} "
      "before and {:.1f} after, best of {} runs\n",
      real.images[0].images.size(), rig.cameras[0].lens.width(), rig.cameras[0].lens.height(),
      100.0 * std::min(share_of_valid(real), share_of_valid(simulated)), ::sysconf(_SC_NPROCESSORS_ONLN),
      load_before, load_average(), runs);
  fmt::print("{:<30}{:>8}{:>8}{:>10}\n", "stage", "wall s", "CPU s", "bound s");
  for (const Stage* s : {&measure, &compare, &causes, &report})
    fmt::print("{:<30}{:>8.2f}{:>8.2f}{:>10}\n", s->name, s->wall_s, s->cpu_s, s == &compare ? "3.0" : "");
  fmt::print("cause named for a projector blur of 1 px that the rig lacks: {}\n",
             searched.causes.named.empty() ? "none" : searched.causes.named);
  fmt::print("page {:.2f} MB (bound 8 MB)\n", static_cast<double>(page_bytes) / 1e6);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    bench(argc > 1 ? std::max(1, std::atoi(argv[1])) : 3);
    return 0;
  } catch (const UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
