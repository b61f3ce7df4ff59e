// SPDX-License-Identifier: Apache-2.0
// bench_embree: the Vulkan renderer beside what a CPU does best with the same rays. One sample = primary ray,
// shadow ray, projection through the projector's lens, mean and three fringe sums (12 images); 2 x 2 samples
// per pixel, whole frames of the paper's left camera, all rivals in turns. Throughput is 2 x samples / CPU
// time: what two free cores would do, whatever else runs.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <numbers>

#include "bench/rivals.hpp"
#include "render/base/quadrature.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;

double cpu_now_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

std::vector<float> make_rays(const Lens& lens) {
  std::vector<float> rays(static_cast<std::size_t>(6 * lens.width() * lens.height()));
  const auto at = [&lens](double x, double y) -> Eigen::Vector2d {
    const auto d = lens.unproject({x, y});
    FT_CHECK(d.has_value(), "the lens can be inverted");
    return {d->x() / d->z(), d->y() / d->z()};
  };
#pragma omp parallel for
  for (int y = 0; y < lens.height(); ++y)
    for (int x = 0; x < lens.width(); ++x) {
      const Eigen::Vector2d center = at(x, y), along_x = at(x + 0.5, y) - at(x - 0.5, y),
                            along_y = at(x, y + 0.5) - at(x, y - 0.5);
      float* r = &rays[static_cast<std::size_t>(6 * (y * lens.width() + x))];
      for (int i = 0; i < 2; ++i) {
        r[i] = static_cast<float>(center[i]);
        r[2 + i] = static_cast<float>(along_x[i]);
        r[4 + i] = static_cast<float>(along_y[i]);
      }
    }
  return rays;
}

bench::RivalView make_view(const Twin& twin) {
  const Camera& camera = twin.cameras[0];
  const Projector& projector = *twin.projector;
  bench::RivalView v;
  v.width = camera.lens.width();
  v.height = camera.lens.height();
  v.rays = make_rays(camera.lens);
  const auto& nodes = render::gauss_rule(2).nodes;
  for (const double dy : nodes)
    for (const double dx : nodes)
      for (const double d : {dx, dy}) v.offsets_px.push_back(static_cast<float>(0.5 * d));
  const Pose T_proj_cam = projector.T_proj_world * camera.T_cam_world.inverse();
  const Eigen::Vector3d light = T_proj_cam.inverse().translation_mm;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) v.T_proj_cam[4 * i + j] = static_cast<float>(T_proj_cam.rotation(i, j));
    v.T_proj_cam[4 * i + 3] = static_cast<float>(T_proj_cam.translation_mm[i]);
    v.light_mm[i] = static_cast<float>(light[i]);
    v.pitches_px[i] = static_cast<float>(twin.fringes.directions[0].pitches_px[static_cast<std::size_t>(i)]);
  }
  const auto& f = projector.lens.intrinsics();
  const auto& k = projector.lens.opencv_distortion();
  v.fx = static_cast<float>(f[0]);
  v.fy = static_cast<float>(f[1]);
  v.cx = static_cast<float>(f[2]);
  v.cy = static_cast<float>(f[3]);
  v.k1 = static_cast<float>(k[0]);
  v.k2 = static_cast<float>(k[1]);
  v.p1 = static_cast<float>(k[2]);
  v.p2 = static_cast<float>(k[3]);
  v.projector_width = static_cast<float>(projector.lens.width());
  v.projector_height = static_cast<float>(projector.lens.height());
  v.reflectance =
      static_cast<float>(projector.intensity * twin.objects[0].material.diffuse / std::numbers::pi);
  return v;
}

struct Rival {
  std::string name;
  std::function<void()> run;
  std::function<double()> mean;  ///< mean weight of the last run's image: all must agree
  double best_cpu_s = 1e30, best_wall_s = 1e30;
};

void compare(const std::string& scene, const Twin& twin, std::vector<Rival> rivals) {
  const Lens& lens = twin.cameras[0].lens;
  const double samples = 4.0 * lens.width() * lens.height();
  render::Transport transport;
  const auto mean = [](const ImageF& image) {
    double sum = 0.0;
    for (const float w : image.data) sum += static_cast<double>(w);
    return sum / static_cast<double>(image.size());
  };
  rivals.insert(rivals.begin(),
                {fmt::format("fringetwin on {}", testing::shared_renderer()->device().name),
                 [&] {
                   transport = testing::shared_renderer()->trace(twin, 0, {Sampler::gauss, 4});
                 },
                 [&] { return mean(transport.mean); }});
  for (Rival& r : rivals) r.run();  // pipelines, page faults
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round)
    for (Rival& r : rivals) {
      const double cpu = cpu_now_s();
      const auto wall = std::chrono::steady_clock::now();
      r.run();
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - wall;
      r.best_cpu_s = std::min(r.best_cpu_s, cpu_now_s() - cpu);
      r.best_wall_s = std::min(r.best_wall_s, elapsed.count());
    }
  fmt::print("\n{}, {} x {} px, 2 x 2 samples, best of {} rounds in turns\n", scene, lens.width(),
             lens.height(), kRounds);
  fmt::print("{:<52}{:>12}{:>10}{:>10}{:>12}{:>14}\n", "", "Msamples/s", "CPU ms", "wall ms", "fringetwin",
             "mean weight");
  for (const Rival& r : rivals)
    fmt::print("{:<52}{:>12.1f}{:>10.1f}{:>10.1f}{:>11.2f}x{:>14.6f}\n", r.name,
               2e-6 * samples / r.best_cpu_s, 1e3 * r.best_cpu_s, 1e3 * r.best_wall_s,
               r.best_cpu_s / rivals[0].best_cpu_s, r.mean());
  const double own = rivals[0].mean();
  for (const Rival& r : rivals)
    if (std::abs(r.mean() / own - 1.0) > 1e-4) {
      fmt::print("the images of \"{}\" differ: this comparison is void\n", r.name);
      std::exit(static_cast<int>(ExitCode::internal));
    }
}

double mean_weight(const bench::RivalImage& image) {
  double sum = 0.0;
  for (std::size_t i = 0; i < image.size(); i += bench::kSums) sum += static_cast<double>(image[i]);
  return sum * bench::kSums / static_cast<double>(image.size());
}

void sphere_scene(const Twin& rig) {
  Twin twin = testing::with_object(rig, "sphere", testing::ideal_sphere());
  twin.objects.push_back({"plane", testing::frontal_plane(), {}});
  const bench::RivalView view = make_view(twin);
  const SphereShape s = testing::ideal_sphere();
  const bench::RivalSphere sphere{{static_cast<float>(s.center_mm.x()), static_cast<float>(s.center_mm.y()),
                                   static_cast<float>(s.center_mm.z())},
                                  static_cast<float>(s.radius_mm),
                                  300.0F};
  bench::RivalImage image;
  compare("sphere R 5 mm before a plane", twin,
          {{"C++ loop, vectorised by the compiler", [&] { bench::trace_analytic(view, sphere, image); },
            [&] { return mean_weight(image); }}});
}

// Mesh and plane as one Embree scene, in the camera frame (the left camera is the world).
void mesh_scene(const Twin& rig) {
  const auto mesh = std::make_shared<Mesh>(testing::make_bumpy_icosphere(6, 35.0, testing::default_bumps()));
  const Pose T_world_object{rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}};
  Twin twin = testing::with_object(rig, "mesh", MeshShape{{}, "mm", T_world_object, false, mesh});
  twin.objects.push_back({"plane", testing::frontal_plane(), {}});
  std::vector<float> vertices;
  std::vector<std::uint32_t> triangles;
  for (const auto& v : mesh->vertices_mm) {
    const Eigen::Vector3d p = T_world_object * v.cast<double>();
    for (int i = 0; i < 3; ++i) vertices.push_back(static_cast<float>(p[i]));
  }
  for (const auto& t : mesh->triangles)
    for (const int i : t) triangles.push_back(static_cast<std::uint32_t>(i));
  const auto first = static_cast<std::uint32_t>(vertices.size() / 3);
  for (const float x : {-1000.0F, 1000.0F})
    for (const float y : {-1000.0F, 1000.0F}) vertices.insert(vertices.end(), {x, y, 300.0F});
  for (const std::uint32_t i : {0U, 1U, 2U, 2U, 1U, 3U}) triangles.push_back(first + i);

  const bench::RivalView view = make_view(twin);
  const bench::RivalMesh rival(vertices, triangles);
  bench::RivalImage single, packets;
  compare(fmt::format("free-form mesh of {} triangles before a plane", mesh->triangles.size()), twin,
          {{"Embree, rtcIntersect1 + rtcOccluded1", [&] { rival.trace_single(view, single); },
            [&] { return mean_weight(single); }},
           {"Embree, rtcIntersect8 + rtcOccluded8", [&] { rival.trace_packets(view, packets); },
            [&] { return mean_weight(packets); }}});
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    if (!testing::shared_renderer()) {
      fmt::print(stderr, "bench_embree: no Vulkan device\n");
      return static_cast<int>(ExitCode::device);
    }
    const Twin rig = testing::only_camera(testing::paper_rig(), 0);
    sphere_scene(rig);
    mesh_scene(rig);
    fmt::print("\nratio \"fringetwin\": our throughput / theirs (1 = equal, 0.5 = half as fast)\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_embree: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
