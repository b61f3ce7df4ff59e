// SPDX-License-Identifier: Apache-2.0
#include "render/reference/reference.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>

#include "render/base/quadrature.hpp"
#include "render/reference/reference_directions.hpp"
#include "render/reference/reference_exposure.hpp"
#include "render/reference/reference_material.hpp"
#include "render/reference/reference_pattern.hpp"
#include "render/reference/reference_scene.hpp"
#include "render/reference/reference_subsurface.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

using std::numbers::pi;

// Nodes (offset px, weight) along one axis of what a pixel gathers: its square, or with a point spread
// function the square widened by it, cell by cell of one pixel.
std::vector<std::pair<double, double>> footprint(int gauss_n, double fill, double psf_px) {
  const GaussRule& rule = gauss_rule(gauss_n);
  std::vector<std::pair<double, double>> nodes;
  if (psf_px == 0.0) {
    for (std::size_t i = 0; i < rule.nodes.size(); ++i)
      nodes.emplace_back(0.5 * fill * rule.nodes[i], 0.5 * rule.weights[i]);
    return nodes;
  }
  const auto cdf = [psf_px](double t) { return 0.5 * std::erfc(-t / (psf_px * std::numbers::sqrt2)); };
  const int reach = static_cast<int>(std::ceil(0.5 * fill + 5.0 * psf_px));
  for (int cell = -reach; cell <= reach; ++cell)
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double offset = cell + 0.5 * rule.nodes[i];
      nodes.emplace_back(
          offset, 0.5 * rule.weights[i] / fill * (cdf(offset + 0.5 * fill) - cdf(offset - 0.5 * fill)));
    }
  return nodes;
}

// Returns the projector's axis along which a pattern changes.
Eigen::Vector2d unit_vector(Axis axis) {
  return axis == Axis::x ? Eigen::Vector2d::UnitX() : Eigen::Vector2d::UnitY();
}

// Of any ray of a device, from the world origin.
double farthest_start_mm(const Twin& twin) {
  double far = twin.projector ? twin.projector->center_world_mm().norm() : 0.0;
  for (const Camera& c : twin.cameras) far = std::max(far, c.center_world_mm().norm());
  return far;
}

}  // namespace

struct Reference::Impl {
  Twin twin;
  std::vector<Pose> T_world_cam;
  Eigen::Vector3d projector_center = Eigen::Vector3d::Zero();
  ReferenceScene scene;
  std::vector<PatternSpec> sequence;
  std::vector<ReferencePattern> patterns;
  std::vector<PatternSpectrum> spectra;  // of the patterns, where any object lets light in
  bool linear = true;

  explicit Impl(const Twin& t);
  std::optional<Ray> camera_ray(std::size_t camera, const Eigen::Vector2d& q_px,
                                const Eigen::Vector2d& lens_uv) const;
  void light(const Ray& ray, const SceneHit& hit, bool lobe, PixelSample& sample) const;
  void send_below(const Ray& ray, const SceneHit& hit, PixelSample& sample) const;
  double lamp(const SceneHit& hit, const PixelSample& sample) const;
  void gather(const SceneHit& hit, const ReferenceQuadrature& quadrature, PixelSample& sample) const;
  void gather_by_lobe(const Eigen::Vector3d& to_viewer, const SceneHit& hit,
                      const ReferenceQuadrature& quadrature, PixelSample& sample) const;
  void add_from(const Eigen::Vector3d& direction, double share, const ReferenceQuadrature& quadrature,
                PixelSample& sample) const;
  static void add_seen(const PixelSample& at, double share, PixelSample& sample);
  std::optional<SceneHit> look_from(const Eigen::Vector3d& direction, PixelSample& at) const;
  void follow_back(const SceneHit& hit, const PixelSample& from, Eigen::Vector3d to_viewer, double share,
                   const ReferenceQuadrature& quadrature, PixelSample& sample) const;
  void add_light(const IndirectLight& light, ReferencePixel& pixel) const;
  PixelSample trace(const Ray& ray, const ReferenceQuadrature* quadrature = nullptr) const;
  void add(const PixelSample& s, double weight, ReferencePixel& pixel) const;
};

Reference::Impl::Impl(const Twin& t) : twin(t), scene(twin, farthest_start_mm(twin)) {
  for (const Camera& c : twin.cameras) T_world_cam.push_back(c.T_cam_world.inverse());
  if (twin.projector) {
    projector_center = twin.projector->center_world_mm();
    linear =
        twin.projector->response.kind == ProjectorResponse::Kind::linear && !twin.projector->pixel_structure;
    sequence = expand_sequence(twin.fringes);
    for (std::size_t i = 0; i < sequence.size() && !sequence[i].is_image(); ++i)  // images are the last ones
      patterns.emplace_back(twin, sequence[i], twin.projector->image_shift_px(i),
                            twin.fringes.harmonics_of_image(i));
    if (twin.has_subsurface()) spectra = pattern_spectra(twin, patterns);
  }
}

// Thin lens: rays from the lens disk (radius focal length / (2 f-number)) meet where the chief ray
// meets the focus plane.
std::optional<Ray> Reference::Impl::camera_ray(std::size_t camera, const Eigen::Vector2d& q_px,
                                               const Eigen::Vector2d& lens_uv) const {
  const Camera& c = twin.cameras.at(camera);
  const auto direction = c.lens.unproject(q_px);
  if (!direction) return std::nullopt;
  const Pose& T = T_world_cam[camera];
  if (!c.optics) return Ray{T.translation_mm, (T.rotation * *direction).normalized()};
  const double radius = 0.5 * c.optics->focal_length_mm / c.optics->f_number;
  const Eigen::Vector3d start(radius * lens_uv.x(), radius * lens_uv.y(), 0.0);
  const Eigen::Vector3d focus = *direction * (c.optics->focus_distance_mm / direction->z());
  return Ray{T * start, (T.rotation * (focus - start)).normalized()};
}

void Reference::Impl::light(const Ray& ray, const SceneHit& hit, bool lobe, PixelSample& sample) const {
  const Projector& projector = *twin.projector;
  const Eigen::Vector3d to_projector = projector_center - sample.point_world_mm;
  const double distance = to_projector.norm();
  const Eigen::Vector3d L = to_projector / distance;
  if (!(sample.normal_world.dot(L) > 0.0)) return;
  const auto q = projector.lens.project(projector.T_proj_world * sample.point_world_mm);
  if (!q || q->x() < -0.5 || q->y() < -0.5 || q->x() > projector.lens.width() - 0.5 ||
      q->y() > projector.lens.height() - 0.5)
    return;
  const bool outside = hit.normal.dot(sample.normal_world) > 0.0;
  if (twin.render.shadow && scene.in_shadow(hit, outside, {sample.point_world_mm, L}, distance)) return;
  sample.lit = true;
  sample.projector_px = *q;
  const Eigen::Vector3d N = on_side(hit.shading, sample.normal_world);
  const double cosine = N.dot(L);
  if (cosine <= 0.0) return;
  const double falloff =
      projector.inverse_square ? std::pow(projector.reference_distance_mm / distance, 2) : 1.0;
  sample.weight =
      projector.intensity * falloff *
      reference_reflected(twin.objects[hit.object].material, hit.albedo, N, L, -ray.direction, lobe) *
      reference_pixel_gaps(projector, *q) * reference_light_field(projector, *q);
  sample.defocus_px = reference_defocus_px(projector, (projector.T_proj_world * sample.point_world_mm).z());
}

// Makes of the diffuse light of a lit sample light that has been below the surface.
void Reference::Impl::send_below(const Ray& ray, const SceneHit& hit, PixelSample& sample) const {
  constexpr double kStepMm = 1e-3;
  PixelSample diffuse = {.point_world_mm = sample.point_world_mm, .normal_world = sample.normal_world};
  light(ray, hit, false, diffuse);
  if (diffuse.weight == 0.0) return;
  const Material& material = twin.objects[hit.object].material;
  const Projector& projector = *twin.projector;
  const Eigen::Vector3d& N = sample.normal_world;
  const Eigen::Vector3d L = (projector_center - sample.point_world_mm).normalized();
  const std::array axes{N.unitOrthogonal(), Eigen::Vector3d(N.cross(N.unitOrthogonal()))};
  BelowSurface below{.mean_free_path_mm = material.mean_free_path_mm,
                     .scattered_share = reference_scattered_share(material.diffuse * hit.albedo)};
  for (int k = 0; k < 2; ++k) {
    below.to_light[k] = axes[k].dot(L);
    below.to_viewer[k] = -axes[k].dot(ray.direction);
    const auto at = [&](double side) {
      return projector.lens.project(projector.T_proj_world *
                                    (sample.point_world_mm + side * kStepMm * axes[k]));
    };
    const auto before = at(-1.0), after = at(1.0);
    if (!before || !after) return;
    below.px_per_mm.col(k) = (*after - *before) / (2.0 * kStepMm);
  }
  sample.weight -= diffuse.weight;
  sample.indirect.push_back({diffuse.weight, sample.projector_px, sample.defocus_px, below});
}

// Lambert's law alone, for parallel light.
double Reference::Impl::lamp(const SceneHit& hit, const PixelSample& sample) const {
  if (!twin.room.has_lamp()) return 0.0;
  const Eigen::Vector3d L = twin.room.lamp_world.normalized();
  if (!(sample.normal_world.dot(L) > 0.0)) return 0.0;
  const bool turned = hit.shading.dot(sample.normal_world) < 0.0;
  const double cosine = (turned ? -1.0 : 1.0) * hit.shading.dot(L);
  if (!(cosine > 0.0)) return 0.0;
  const bool outside = hit.normal.dot(sample.normal_world) > 0.0;
  if (twin.render.shadow &&
      scene.in_shadow(hit, outside, {sample.point_world_mm, L}, std::numeric_limits<double>::infinity()))
    return 0.0;
  return twin.room.lamp_world.norm() * twin.objects[hit.object].material.diffuse * hit.albedo * cosine;
}

// Light over one surface, by a product rule over the hemisphere.
void Reference::Impl::gather(const SceneHit& hit, const ReferenceQuadrature& quadrature,
                             PixelSample& sample) const {
  const int bounce_n = quadrature.bounce_n;
  const Hemisphere hemisphere(hit.shading, sample.normal_world);
  const double diffuse = twin.objects[hit.object].material.diffuse * hit.albedo;
  const GaussRule& rule = gauss_rule(bounce_n);
  for (int i = 0; i < bounce_n; ++i)
    for (int k = 0; k < 2 * bounce_n; ++k) {
      const double share = 0.5 * rule.weights[i] / (2.0 * bounce_n) * diffuse;
      add_from(hemisphere.direction(0.5 + 0.5 * rule.nodes[i], pi * (k + 0.5) / bounce_n), share, quadrature,
               sample);
    }
}

// Light over one surface that the lobe sends to the viewer, by a product rule over the lobe: over GGX's own
// distribution of normals (Walter et al. 2007, eq. 35, 36), or over the power of the cosine.
void Reference::Impl::gather_by_lobe(const Eigen::Vector3d& to_viewer, const SceneHit& hit,
                                     const ReferenceQuadrature& quadrature, PixelSample& sample) const {
  const Material& material = twin.objects[hit.object].material;
  const bool ggx = material.specular_model == Material::Specular::ggx;
  const Eigen::Vector3d N = on_side(hit.shading, sample.normal_world);
  const double cos_v = N.dot(to_viewer), alpha = material.roughness * material.roughness;
  if (ggx && cos_v <= 0.0) return;
  const Eigen::Vector3d axis = ggx ? N : Eigen::Vector3d(2.0 * cos_v * N - to_viewer);
  const Hemisphere around(axis, axis);
  const int bounce_n = quadrature.bounce_n;
  const GaussRule& rule = gauss_rule(bounce_n);
  for (int i = 0; i < bounce_n; ++i)
    for (int k = 0; k < 2 * bounce_n; ++k) {
      const double u = 0.5 + 0.5 * rule.nodes[i], angle = pi * (k + 0.5) / bounce_n,
                   weight = 0.5 * rule.weights[i] / (2.0 * bounce_n);
      const double tan2 = alpha * alpha * u / (1.0 - u);
      const double sine2 = ggx ? tan2 / (1.0 + tan2) : 1.0 - std::pow(u, 2.0 / (material.shininess + 1.0));
      const Eigen::Vector3d H = around.direction(sine2, angle);
      const Eigen::Vector3d L = ggx ? Eigen::Vector3d(2.0 * H.dot(to_viewer) * H - to_viewer) : H;
      const double cos_l = N.dot(L);
      if (cos_l <= 0.0) continue;
      // the density of L is D (N.H)/(4 H.V): what is left of the lobe is without D
      const double D = alpha * alpha / (pi * std::pow(1.0 - sine2, 2) * std::pow(alpha * alpha + tan2, 2));
      const double share = ggx ? reference_ggx(N, L, to_viewer, material.specular, material.roughness) *
                                     cos_l * 4.0 * H.dot(to_viewer) / (D * N.dot(H))
                               : material.specular * 2.0 * pi / (material.shininess + 1.0);
      add_from(L, weight * share, quadrature, sample);
    }
}

// Adds a share of what a place gets along a direction.
void Reference::Impl::add_from(const Eigen::Vector3d& direction, double share,
                               const ReferenceQuadrature& quadrature, PixelSample& sample) const {
  PixelSample at{.point_world_mm = sample.point_world_mm, .normal_world = sample.normal_world};
  const auto other = look_from(direction, at);
  if (!other) return;
  add_seen(at, share, sample);
  if (twin.render.bounces > 1) follow_back(*other, at, -direction, share, quadrature, sample);
}

// Adds a share of what a place sends to the light that reaches a sample over it.
void Reference::Impl::add_seen(const PixelSample& at, double share, PixelSample& sample) {
  if (at.lit && at.weight != 0.0)
    sample.indirect.push_back({share * at.weight, at.projector_px, at.defocus_px});
  for (const IndirectLight& light : at.indirect)
    sample.indirect.push_back({share * light.weight, light.projector_px, light.defocus_px, light.below});
}

// Returns what a place sees along a direction and makes `at` that place with its light.
std::optional<SceneHit> Reference::Impl::look_from(const Eigen::Vector3d& direction, PixelSample& at) const {
  if (direction.dot(at.normal_world) <= 0.0) return std::nullopt;
  const Ray ray{at.point_world_mm + kShadowStartMm * at.normal_world, direction};
  const auto other = scene.nearest(ray);
  if (!other) return std::nullopt;
  at = {.point_world_mm = ray.origin_mm + other->t_mm * direction,
        .normal_world = on_side(other->normal, -direction)};
  light(ray, *other, twin.render.glossy_bounces, at);
  if (twin.objects[other->object].material.mean_free_path_mm > 0.0) send_below(ray, *other, at);
  return other;
}

// Light that came over more surfaces, by paths at random from a place of the one before: the mean over paths
// is that of all light. Nothing of the renderer's cells. The first directions lie in rings of equal share.
void Reference::Impl::follow_back(const SceneHit& hit, const PixelSample& from, Eigen::Vector3d to_viewer,
                                  double share, const ReferenceQuadrature& quadrature,
                                  PixelSample& sample) const {
  constexpr double kNothingLeft = 1e-6;
  const int paths = quadrature.paths;
  const Eigen::Vector3d first_viewer = to_viewer;
  std::array<std::uint64_t, 3> place{};
  std::memcpy(place.data(), from.point_world_mm.data(), sizeof(place));
  std::mt19937_64 random(place[0] ^ (place[1] * 31) ^ (place[2] * 1009));
  std::uniform_real_distribution<double> uniform;
  for (int path = 0; path < paths; ++path) {
    SceneHit last = hit;
    PixelSample at{.point_world_mm = from.point_world_mm, .normal_world = from.normal_world};
    double left = 1.0;
    to_viewer = first_viewer;
    for (int k = 1; k < twin.render.bounces; ++k) {
      const Hemisphere hemisphere(last.shading, at.normal_world);
      const double sine2 = k == 1 ? (path + uniform(random)) / paths : uniform(random),
                   angle = 2.0 * pi * uniform(random);
      const Eigen::Vector3d direction = hemisphere.direction(sine2, angle);
      const Eigen::Vector3d N = on_side(last.shading, at.normal_world);
      left *= pi / N.dot(direction) *
              reference_reflected(twin.objects[last.object].material, last.albedo, N, direction, to_viewer,
                                  quadrature.middle_lobes);
      if (!(left > kNothingLeft)) break;
      const auto next = look_from(direction, at);
      if (!next) break;
      add_seen(at, share / paths * left, sample);
      last = *next;
      to_viewer = -direction;
    }
  }
}

PixelSample Reference::Impl::trace(const Ray& ray, const ReferenceQuadrature* quadrature) const {
  PixelSample sample;
  const auto hit = scene.nearest(ray);
  if (!hit) return sample;
  sample.object = hit->object;
  sample.triangle = hit->triangle;
  sample.t_mm = hit->t_mm;
  sample.point_world_mm = ray.origin_mm + hit->t_mm * ray.direction;
  sample.normal_world = on_side(hit->normal, -ray.direction);
  if (twin.projector) light(ray, *hit, true, sample);
  sample.lamp = lamp(*hit, sample);
  if (!twin.projector || !quadrature) return sample;
  if (twin.objects[hit->object].material.mean_free_path_mm > 0.0) send_below(ray, *hit, sample);
  if (twin.render.bounces > 0) gather(*hit, *quadrature, sample);
  if (twin.render.bounces > 0 && twin.render.glossy_bounces &&
      twin.objects[hit->object].material.specular > 0.0)
    gather_by_lobe(-ray.direction, *hit, *quadrature, sample);
  return sample;
}

void Reference::Impl::add(const PixelSample& s, double weight, ReferencePixel& pixel) const {
  if (s.object < 0 || !twin.projector) return;
  const double ambient = weight * (twin.projector->ambient + s.lamp);
  pixel.ambient += ambient;
  for (std::size_t i = 0; i < pixel.irradiance.size(); ++i) {
    const std::vector<double>& room = twin.projector->ambient_factors;
    pixel.irradiance[i] += room.empty() ? ambient : ambient * room.at(i);
  }
  for (const IndirectLight& l : s.indirect)
    add_light({weight * l.weight, l.projector_px, l.defocus_px, l.below}, pixel);
  if (s.lit) add_light({weight * s.weight, s.projector_px, s.defocus_px}, pixel);
}

void Reference::Impl::add_light(const IndirectLight& s, ReferencePixel& pixel) const {
  const double w = s.weight;
  pixel.mean += w;
  for (std::size_t d = 0; d < pixel.cosine.size(); ++d) {
    const DirectionFringes& fringes = twin.fringes.directions[d];
    const Eigen::Vector2d axis = unit_vector(fringes.axis);
    const double x = s.projector_px.dot(axis);
    for (std::size_t p = 0; p < pixel.cosine[d].size(); ++p) {
      const double theta = 2.0 * pi * (x - fringes.phase_origin_px[p]) / fringes.pitches_px[p];
      const double u =
          pi * std::sqrt(twin.projector->blur_variance_px2(s.projector_px)) / fringes.pitches_px[p];
      const double r = fringes.axis == Axis::x ? s.defocus_px.x() : s.defocus_px.y();
      const double v = 2.0 * pi * r / fringes.pitches_px[p];
      const double contrast = std::exp(-2.0 * u * u) * (v == 0.0 ? 1.0 : 2.0 * std::cyl_bessel_j(1.0, v) / v);
      const std::complex<double> kept =
          s.below ? reference_kept_below(*s.below, 2.0 * pi / fringes.pitches_px[p] * axis) : 1.0;
      const std::complex<double> light = w * contrast * std::polar(1.0, theta) * kept;
      pixel.cosine[d][p] += light.real();
      pixel.sine[d][p] += light.imag();
    }
  }
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    const std::vector<double>& lamp = twin.projector->light_factors;
    const double now = lamp.empty() ? w : w * lamp.at(i);
    if (sequence[i].is_image()) {
      const auto k = static_cast<std::size_t>(sequence[i].image);
      pixel.irradiance[i] +=
          now * reference_shown_level(*twin.projector, *twin.fringes.images.at(k).levels, s.projector_px);
      continue;
    }
    if (!s.below) {
      pixel.irradiance[i] += now * patterns[i](s.projector_px, s.defocus_px);
      continue;
    }
    const Eigen::Vector2d axis = unit_vector(twin.fringes.directions[sequence[i].direction].axis);
    pixel.irradiance[i] += now * spectra[i].value(s.projector_px.dot(axis), axis, *s.below);
  }
}

Reference::Reference(const Twin& twin) : impl_(std::make_unique<Impl>(twin)) {}
Reference::~Reference() = default;
const Twin& Reference::twin() const { return impl_->twin; }

PixelSample Reference::sample(std::size_t camera, const Eigen::Vector2d& q_px,
                              const Eigen::Vector2d& lens_uv) const {
  const auto ray = impl_->camera_ray(camera, q_px, lens_uv);
  return ray ? impl_->trace(*ray) : PixelSample{};
}

// With depth of field the rim of the lens counts, too.
bool Reference::is_whole(std::size_t camera, int x, int y) const {
  const GaussRule& rule = gauss_rule(4);
  const double half = 0.5 * impl_->twin.sampled_side_px(impl_->twin.cameras.at(camera));
  std::vector<Eigen::Vector2d> lens{Eigen::Vector2d::Zero()};
  if (impl_->twin.cameras.at(camera).optics)
    for (int k = 0; k < 8; ++k) lens.emplace_back(std::cos(0.25 * pi * k), std::sin(0.25 * pi * k));
  std::optional<PixelSample> first;
  for (std::size_t j : {0, 3, 1, 2})  // the corners tell most
    for (std::size_t i : {0, 3, 1, 2})
      for (const Eigen::Vector2d& uv : lens) {
        const PixelSample s = sample(camera, {x + half * rule.nodes[i], y + half * rule.nodes[j]}, uv);
        if (!first) first = s;
        const bool same = s.object == first->object && s.triangle == first->triangle &&
                          (s.lamp > 0.0) == (first->lamp > 0.0);
        if (!s.lit || !same) return false;
      }
  return true;
}

ReferencePixel Reference::without_texture(std::size_t camera, int x, int y,
                                          const ReferenceQuadrature& quadrature) const {
  const Twin& twin = impl_->twin;
  ReferencePixel out{.interior = is_whole(camera, x, y), .object = sample(camera, {x, y}).object};
  out.irradiance.assign(impl_->sequence.size(), 0.0);
  if (impl_->linear && twin.fringes.steps > 0)
    for (const DirectionFringes& d : twin.fringes.directions) {
      out.cosine.emplace_back(d.pitches_px.size(), 0.0);
      out.sine.emplace_back(d.pitches_px.size(), 0.0);
    }

  std::vector<std::tuple<Eigen::Vector2d, double>> lens{{Eigen::Vector2d::Zero(), 1.0}};
  if (twin.cameras.at(camera).optics) {
    lens.clear();
    const GaussRule& rings = gauss_rule(quadrature.lens_rings);
    for (int r = 0; r < quadrature.lens_rings; ++r) {
      const double radius = std::sqrt(0.5 + 0.5 * rings.nodes[r]);
      for (int k = 0; k < quadrature.lens_spokes; ++k) {
        const double angle = 2.0 * pi * (k + 0.5 * (r % 2)) / quadrature.lens_spokes;
        lens.emplace_back(Eigen::Vector2d(radius * std::cos(angle), radius * std::sin(angle)),
                          0.5 * rings.weights[r] / quadrature.lens_spokes);
      }
    }
  }
  const Camera& device = twin.cameras[camera];
  const double px = device.pixel_side_px();  // of the sensor, in px of the image
  const auto nodes = footprint(quadrature.gauss_n, twin.render.pixel_fill, device.psf_px);
  for (const auto& [dx, wx] : nodes)
    for (const auto& [dy, wy] : nodes)
      for (const auto& [uv, lens_weight] : lens) {
        const Eigen::Vector2d q(x + px * dx, y + px * dy);
        if (const auto ray = impl_->camera_ray(camera, q, uv))
          impl_->add(impl_->trace(*ray, &quadrature), wx * wy * lens_weight * reference_vignetting(device, q),
                     out);
      }
  out.irradiance = reference_exposed(device, y, out.irradiance);
  const std::vector<double>& exposures = device.exposure_factors;
  for (std::size_t i = 0; i < exposures.size(); ++i) out.irradiance.at(i) *= exposures[i];
  return out;
}

void Reference::add_within_pixel(const Camera& camera, std::size_t index, int x, int y,
                                 const ReferenceQuadrature& quadrature,
                                 std::vector<double>& irradiance) const {
  const PixelTexture& texture = *camera.texture;
  const int width = camera.lens.width(), height = camera.lens.height();
  const std::vector<double> middle = irradiance;
  for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
    // by distance from the pixel: what its neighbours have, empty beyond the border and without a factor
    std::array<std::vector<double>, 5> light;
    std::array<double, 5> factor{};
    for (int side = -2; side <= 2; ++side) {
      const int u = x + side * dx, v = y + side * dy;
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      factor[side + 2] = texture.factor_at(static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                           static_cast<std::size_t>(u));
      if (factor[side + 2] > 0.0)
        light[side + 2] = side == 0 ? middle : without_texture(index, u, v, quadrature).irradiance;
    }
    for (std::size_t k = 0; k < irradiance.size(); ++k) {
      const auto tells = [&](int at) { return !light[at].empty() && light[at][k] > 0.0; };
      if (!tells(1) || !tells(2) || !tells(3)) continue;
      const bool wide = tells(0) && tells(4);
      const double of_factor = wide ? (factor[0] - 8.0 * factor[1] + 8.0 * factor[3] - factor[4]) / 12.0
                                    : (factor[3] - factor[1]) / 2.0;
      const double of_light = wide
                                  ? (light[0][k] - 8.0 * light[1][k] + 8.0 * light[3][k] - light[4][k]) / 12.0
                                  : (light[3][k] - light[1][k]) / 2.0;
      irradiance[k] += std::pow(camera.texture_spread_px, 2) * of_factor * of_light / factor[2];
    }
  }
  for (std::size_t k = 0; k < irradiance.size(); ++k)
    irradiance[k] = std::max(std::min(0.0, middle[k]), irradiance[k]);
}

ReferencePixel Reference::pixel(std::size_t camera, int x, int y,
                                const ReferenceQuadrature& quadrature) const {
  ReferencePixel out = without_texture(camera, x, y, quadrature);
  const Camera& device = impl_->twin.cameras[camera];
  const PixelTexture* texture = device.texture.get();
  if (!texture) return out;
  if (device.texture_spread_px > 0.0 && !texture->factor.empty())
    add_within_pixel(device, camera, x, y, quadrature, out.irradiance);
  const std::vector<double>& exposures = device.exposure_factors;
  const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(device.lens.width()) +
                  static_cast<std::size_t>(x);
  for (std::size_t i = 0; i < out.irradiance.size(); ++i)
    out.irradiance[i] = out.irradiance[i] * texture->factor_at(at) +
                        (exposures.empty() ? 1.0 : exposures[i]) * texture->offset_at(at);
  return out;
}

}  // namespace fringetwin::render
