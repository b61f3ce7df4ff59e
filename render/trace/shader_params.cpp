// SPDX-License-Identifier: Apache-2.0
#include "render/trace/shader_params.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "render/scene/pack_scene.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::render {
namespace {

using Eigen::Vector3d;

// Shadow rays start this far above the surface, relative to the distance from the camera: twice the
// sum of the single-precision roundings of a hit point and its change of frame, 0.25 um at 250 mm.
constexpr double kShadowOffset = 1e-6;

// The nearest depth whose defocus counts, as a share of the focus distance: bounding spheres may reach behind
// the camera.
constexpr double kNearestDepth = 0.1;

Double4 row(const Pose& T, int i) {
  return {T.rotation(i, 0), T.rotation(i, 1), T.rotation(i, 2), T.translation_mm[i]};
}

std::uint32_t fold_seed(std::uint64_t seed) {
  // The mixing function of splitmix64.
  std::uint64_t z = seed + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
}

// Returns the phase by which a fringe at the finest pitch swings between the centre and the rim of the lens,
// at the worst depth in view.
double lens_swing_rad(const Twin& twin, const Camera& camera, const PackedScene& scene) {
  const double finest = twin.fringes.finest_pitch_px();
  const double focus = camera.optics->focus_distance_mm;
  const double f_px = setup_projector(*twin.projector).fx;
  if (!(scene.z_min_mm <= scene.z_max_mm)) return 0.0;
  // Monotonic in 1/z: the ends of the range are the worst. 2: a tilted surface moves the hit further than
  // a frontal one.
  const auto swing = [&](double z) {
    return 2.0 * 2.0 * std::numbers::pi / finest * f_px * lens_radius_mm(camera.optics) *
           std::abs(1.0 / z - 1.0 / focus);
  };
  return std::max(swing(std::max(scene.z_min_mm, kNearestDepth * focus)), swing(scene.z_max_mm));
}

// Sets the projector's place, lens and intensity.
void set_projector(const Projector& p, const Camera& camera, const ProjectorSetup& setup,
                   ParamsBlock* block) {
  using P = gpu::Params;
  ParamsBlock& g = *block;
  const Pose T_proj_cam = p.T_proj_world * camera.T_cam_world.inverse();
  const Vector3d center = T_proj_cam.inverse().translation_mm;
  g.set(&P::projector_r0, row(T_proj_cam, 0));
  g.set(&P::projector_r1, row(T_proj_cam, 1));
  g.set(&P::projector_r2, row(T_proj_cam, 2));
  double max_radius_sq = std::numeric_limits<float>::max();
  if (p.lens.is_perspective()) {
    max_radius_sq = std::min(max_radius_sq, p.lens.max_invertible_radius_sq());
    const auto& k = p.lens.opencv_distortion();
    g.set(&P::projector_k0, {k[0], k[1], k[2], k[3]});
    g.set(&P::projector_k1, {k[4], k[5], k[6], k[7]});
    g.set(&P::projector_k2, {k[8], k[9], k[10], k[11]});
  }
  g.set(&P::projector_f, {setup.fx, setup.fy, max_radius_sq, 0.0});
  g.set(&P::projector_edge, {-0.5 - setup.cx, p.lens.width() - 0.5 - setup.cx, -0.5 - setup.cy,
                             p.lens.height() - 0.5 - setup.cy});
  g.values.projector_grid = setup.table.grid;
  g.values.projector_grid_n = setup.table.grid_n;
  g.set(&P::projector_center, {center.x(), center.y(), center.z(), p.intensity});
}

int pixel_gaps(const Projector& p, const PassPlan& pass) {
  if (!p.pixel_structure || p.pixel_fill >= 1.0) return 0;
  return pass.gaps.empty() ? PIXEL_GAPS_SHARP : PIXEL_GAPS_BLURRED;
}

double gap_samples(const PassPlan& pass) {
  return pass.gaps.empty() ? 0.0 : static_cast<double>(pass.gaps.size() - 2);
}

// Returns where in its pixel the raster of the projector's image has the principal point.
double raster_phase(double c_px) { return c_px + 0.5 - std::floor(c_px + 0.5); }

double per_focus_mm(const std::optional<Optics>& optics) {
  return optics ? 1.0 / optics->focus_distance_mm : 0.0;
}

// Returns a way to the room's lamp that leads beyond all objects of a rig, in the camera's frame.
Vector3d lamp_way_mm(const TraceJob& job) {
  constexpr double kBeyondAllMm = 1e5;
  const Vector3d& lamp_world = job.twin.room.lamp_world;
  return job.twin.room.has_lamp()
             ? Vector3d(job.camera.T_cam_world.rotation * lamp_world.normalized() * kBeyondAllMm)
             : Vector3d::UnitZ();
}

Vector3d cell_middle_mm(const TraceJob& job) {
  return job.cells ? Vector3d(job.cells->middle_mm.cast<double>()) : Vector3d::Zero();
}
double cells_per_mm(const TraceJob& job) { return job.cells ? job.cells->per_mm : 0.0; }
double cell_table_mask(const TraceJob& job) { return job.cells ? job.cells->table_mask : 0.0; }

template <class... Number>
Double4 as_doubles(Number... number) {
  return {static_cast<double>(number)...};
}

}  // namespace

ProjectorSetup setup_projector(const Projector& projector) {
  ProjectorSetup s;
  const Lens& lens = projector.lens;
  if (!lens.is_perspective()) {
    s.kind = PROJECTOR_GRID;
    s.table = make_projector_table(lens);
    s.fx = s.table.fx;
    s.fy = s.table.fy;
    s.cx = s.table.cx;
    s.cy = s.table.cy;
    return s;
  }
  s.fx = lens.intrinsics()[0];
  s.fy = lens.intrinsics()[1];
  s.cx = lens.intrinsics()[2];
  s.cy = lens.intrinsics()[3];
  const auto& k = lens.opencv_distortion();
  s.kind = k.isZero(0.0)             ? PROJECTOR_PINHOLE
           : k.tail<7>().isZero(0.0) ? PROJECTOR_OPENCV5
                                     : PROJECTOR_OPENCV12;
  return s;
}

SampleSetup setup_samples(const Twin& twin, const Camera& camera, const PackedScene& scene,
                          const Sampling& sampling) {
  SampleSetup s;
  const double fill = twin.sampled_side_px(camera);
  s.n = static_cast<std::uint32_t>(sampling.samples);
  switch (sampling.sampler) {
    case Sampler::gauss: {
      std::vector<DiskPoint> disk;
      if (camera.optics) {
        const double swing = lens_swing_rad(twin, camera, scene);
        disk = disk_rule_for_swing(swing);
        if (swing > kLargestDiskSwingRad)
          warn(fmt::format(
              "camera \"{}\": out of focus by up to {:.0f} rad of the finest fringes from the middle of "
              "its lens to the rim; the lens is sampled for {:.0f} rad",
              camera.name, swing, kLargestDiskSwingRad));
      }
      s.table = gauss_samples(sampling.samples, fill, disk, lens_radius_mm(camera.optics));
      s.n *= static_cast<std::uint32_t>(std::max<std::size_t>(disk.size(), 1));
      break;
    }
    case Sampler::multi_jittered:
      s.factors = multi_jitter_factors(s.n);
      s.kind =
          s.factors.columns * s.factors.rows == s.n ? SAMPLER_MULTI_JITTERED : SAMPLER_MULTI_JITTERED_ANY;
      break;
    case Sampler::sobol:
      s.kind = SAMPLER_SOBOL;
      s.sobol = sobol_points(s.n);
      break;
    case Sampler::adaptive:
      FT_CHECK(false, "the adaptive trace sets up its own samples");
  }
  return s;
}

ParamsBlock make_params(const TraceJob& job, const SampleSetup& samples, const PassPlan& pass) {
  const auto& [twin, camera, scene, lens, setup, blocks, shortcuts, tuning, seed, out, harmonics, look_px,
               cells, mirrors] = job;
  FT_CHECK(scene.primitives.size() == scene.materials.size(), "one material per primitive");
  using P = gpu::Params;
  const Projector& projector = *twin.projector;
  ParamsBlock g;
  g.set(&P::camera, lens.camera);
  g.values.lens_grid = lens.grid;
  g.values.lens_grid_n = lens.grid_n;
  set_projector(projector, camera, setup, &g);
  const double focus = camera.optics ? camera.optics->focus_distance_mm : 1.0;
  g.set(&P::sampling,
        {twin.sampled_side_px(camera), 1.0 / samples.n, lens_radius_mm(camera.optics), 1.0 / focus});
  g.values.sampling_n = {samples.n, samples.factors.columns, samples.factors.rows, fold_seed(seed)};
#define SET_NUMBERS(member, ...) g.set(&P::member, as_doubles(__VA_ARGS__));
  NUMBERS_OF_EFFECTS(SET_NUMBERS)
#undef SET_NUMBERS
  for (std::size_t i = 0; i < pass.pitches.size(); ++i) {
    g.values.pitch[i] = rounded(pass.pitches[i].values);
    g.rest.pitch[i] = rest_of(pass.pitches[i].values);
  }
  for (std::size_t i = 0; i < MAX_PITCHES; i += 4) {
    const auto share = [&](std::size_t k) { return k < pass.pitches.size() ? pass.pitches[k].share : 0.0; };
    g.values.pitch_share[i / 4] = rounded({share(i), share(i + 1), share(i + 2), share(i + 3)});
  }
  for (std::size_t i = 0; i < pass.direct.size(); ++i) {
    g.values.direct[i] = rounded(pass.direct[i].a);
    g.rest.direct[i] = rest_of(pass.direct[i].a);
    g.values.direct_b[i] = rounded(pass.direct[i].b);
  }
  return g;
}

void set_adaptive(const TraceJob& job, const AdaptiveTargets& targets, ParamsBlock* block) {
  block->set(&gpu::Params::adaptive, {targets.phase_rad, targets.irradiance, job.twin.projector->ambient,
                                      static_cast<double>(targets.gauss_order)});
  block->values.image = {static_cast<gpu::uint>(job.camera.lens.width()),
                         static_cast<gpu::uint>(job.camera.lens.height()), targets.panels, targets.stretches};
}

SpecConstants make_constants(const TraceJob& job, const SampleSetup& samples, const PassPlan& pass) {
  const auto& [twin, camera, scene, lens, setup, blocks, shortcuts, tuning, seed, out, harmonics, look_px,
               cells, mirrors] = job;
  const int links = shortcuts.kinds;
  const Projector& projector = *twin.projector;
  SpecConstants c{};
#define SET_COUNT(number, KIND, kind, first) \
  c[SPEC_N_##KIND] = static_cast<std::uint32_t>(scene.count[KIND_##KIND]);
#define SET_VALUE(number, name, otherwise, value) c[SPEC_##name] = static_cast<std::uint32_t>(value);
  ANALYTIC_KINDS(SET_COUNT)
  SPECIALISATION_CONSTANTS(SET_VALUE)
#undef SET_COUNT
#undef SET_VALUE
  return c;
}

}  // namespace fringetwin::render
