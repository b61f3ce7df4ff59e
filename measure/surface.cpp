// SPDX-License-Identifier: Apache-2.0
// Depths are smoothed as inverse depth 1/z over the pixel grid, in which a plane is linear whatever its tilt;
// vertices stay on the rays of their pixels.
#include "measure/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "measure/depth_fit.hpp"
#include "measure/points/coordinate_map.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure {
namespace {

constexpr double kMostSmoothing = 50.0;  ///< px
/// Pixels by which a surface that reaches to the image's border is continued beyond it: without them the
/// pixels there would see half of it.
constexpr int kFrame = 1;

/// Sorts the points into the camera's pixels as depths.
DepthMap make_depth_map(const Camera& camera, const PointCloud& cloud) {
  const int width = camera.lens.width(), height = camera.lens.height();
  DepthMap map{ImageD(width, height, std::nan("")), ImageF(width, height, 0.0f)};
  const Image<int> grid = point_grid(cloud, width, height);
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const int k = grid.data[i];
    if (k < 0) continue;
    const Eigen::Vector3d p_cam_mm = camera.T_cam_world * cloud.p_world_mm[k];
    map.z_mm.data[i] = p_cam_mm.z();
    if (!cloud.sigma_mm.empty())  // along the ray, of which the depth is a part
      map.sigma_mm.data[i] = cloud.sigma_mm[k] * static_cast<float>(p_cam_mm.z() / p_cam_mm.norm());
  }
  map.step = lateral_step(camera.lens);
  return map;
}

/// Adds the triangles of one pixel cell, counter-clockwise for the viewer: the normals face the camera.
/// `anchor_mm`: depth of the measured surface that a pixel belongs to or continues; two surfaces that are
/// both continued into a gap between them are not joined there.
void add_cell(const DepthMap& map, const ImageD& anchor_mm, const Image<int>& vertex, int x, int y,
              std::vector<std::array<int, 3>>& triangles) {
  struct Corner {
    int id, x, y;
  };
  const Corner corners[4] = {{vertex(x, y), x, y},
                             {vertex(x, y + 1), x, y + 1},
                             {vertex(x + 1, y + 1), x + 1, y + 1},
                             {vertex(x + 1, y), x + 1, y}};
  const auto joined = [&](int i, int j) {
    const Corner &a = corners[i], &b = corners[j];
    const double pixels = std::hypot(a.x - b.x, a.y - b.y);
    return map.joined(map.z_mm(a.x, a.y), map.z_mm(b.x, b.y), pixels, 0.0) &&
           map.joined(anchor_mm(a.x, a.y), anchor_mm(b.x, b.y), pixels, 0.0);
  };
  const auto add = [&](int i, int j, int k) {
    if (corners[i].id < 0 || corners[j].id < 0 || corners[k].id < 0) return false;
    if (!joined(i, j) || !joined(j, k) || !joined(k, i)) return false;
    triangles.push_back({corners[i].id, corners[j].id, corners[k].id});
    return true;
  };
  const auto height = [&](int i) { return map.z_mm(corners[i].x, corners[i].y); };
  // the diagonal with the smaller depth difference follows creases; NaN compares false
  const bool diagonal_02 = !(std::abs(height(1) - height(3)) < std::abs(height(0) - height(2)));
  const bool first = diagonal_02 ? add(0, 1, 2) : add(0, 1, 3);
  const bool second = diagonal_02 ? add(0, 2, 3) : add(1, 2, 3);
  if (first || second) return;
  if (diagonal_02)  // three corners may be left along the other diagonal
    add(0, 1, 3) || add(1, 2, 3);
  else
    add(0, 1, 2) || add(0, 2, 3);
}

/// A place of the surface in the camera's frame: on the ray of a pixel (z = 1), with the ray's derivatives
/// along the image's axes.
struct RayOfPixel {
  Eigen::Vector3d ray, along_x, along_y;
};

std::optional<RayOfPixel> ray_of_pixel(const Lens& lens, const Eigen::Vector2d& q_px) {
  const auto ray = lens.unproject(q_px), right = lens.unproject({q_px.x() + 1.0, q_px.y()}),
             below = lens.unproject({q_px.x(), q_px.y() + 1.0});
  if (!ray || !right || !below || !(ray->z() > 0.0) || !(right->z() > 0.0) || !(below->z() > 0.0))
    return std::nullopt;
  const Eigen::Vector3d r = *ray / ray->z();
  return RayOfPixel{r, *right / right->z() - r, *below / below->z() - r};
}

/// The normal of r(x, y)/(1/z): (dr/dx u - r du/dx) x (dr/dy u - r du/dy) over u^3, u = 1/z.
struct NormalOfFit {
  Eigen::Vector3d normal, per_slope_x, per_slope_y;  ///< of any length; towards the camera

  NormalOfFit(const RayOfPixel& at, const DepthFit& fit)
      : per_slope_x(at.ray.cross(at.along_y)), per_slope_y(at.along_x.cross(at.ray)) {
    normal = fit.slope_x * per_slope_x + fit.slope_y * per_slope_y -
             fit.inverse_depth * at.along_x.cross(at.along_y);
  }

  double cosine(const Eigen::Vector3d& to_light) const {
    return normal.dot(to_light) / (normal.norm() * to_light.norm());
  }

  /// Returns the relative variance of the cosine between the normal and a direction, per variance of the
  /// pixel's own inverse depth.
  double shading_variance(const DepthFit& fit, const Eigen::Vector3d& to_light) const {
    const auto relative = [&](const Eigen::Vector3d& d) {
      return d.dot(to_light) / normal.dot(to_light) - d.dot(normal) / normal.squaredNorm();
    };
    const double x = relative(per_slope_x), y = relative(per_slope_y);
    return x * x * static_cast<double>(fit.slope_xx) + 2.0 * x * y * static_cast<double>(fit.slope_xy) +
           y * y * static_cast<double>(fit.slope_yy);
  }
};

/// Returns the variance that a mean over many neighbouring points has, over that of as many whose noise is
/// their own. Where two cameras measure, the second one's map is read between its pixels, which lessens the
/// noise of each point, but not that of a mean; both cameras are taken to have the same.
double variance_shared(const Twin& twin) {
  if (twin.measure.triangulate != Triangulate::stereo) return 1.0;
  return 2.0 / (1.0 + CoordinateMap::mean_noise_gain_sq());
}

/// Of a mesh that goes evenly from vertex to vertex, a pixel each, the mean over a pixel is
/// vertex + kBends (second derivatives): weights of 1/8, 3/4, 1/8 along each axis.
constexpr double kBends = 0.125;

/// Returns the inverse depth of the vertex with which the mean over its pixel is what was fitted.
double vertex_of(const DepthFit& fit) {
  constexpr double kMostBent = 0.1;  // of the depth: what bends more is no surface, but few points
  const double bend = kBends * fit.curvature;
  return fit.inverse_depth - (std::abs(bend) < kMostBent * fit.inverse_depth ? bend : 0.0);
}

/// Collects the vertices of a surface, a pixel each, and what noise they have.
class Vertices {
 public:
  Vertices(const Twin& twin, std::size_t camera, const DepthMap& map)
      : camera_(camera),
        lens_(twin.cameras[camera].lens),
        T_world_cam_(twin.cameras[camera].T_cam_world.inverse()),
        map_(map),
        mesh_(new Mesh) {
    shared_ = std::sqrt(variance_shared(twin));
    for (std::size_t c = 0; c < twin.cameras.size(); ++c) seen_.emplace_back(twin, c, camera);
    if (twin.projector)
      light_mm_ = T_world_cam_.inverse() * twin.projector->T_proj_world.inverse() * Eigen::Vector3d::Zero();
  }

  /// Adds a vertex, of a pixel of the image or of the frame around it, with what another window says of it
  /// (other_fits()). Returns its index, -1 where the lens sees no such pixel.
  int add(int x, int y, const DepthFit& fit, const DepthFit& other) {
    const auto at = ray_of_pixel(lens_, {static_cast<double>(x), static_cast<double>(y)});
    if (!at) return -1;
    const FittedVertex v{fit, *at, {*at, fit}, at->ray / vertex_of(fit)};
    Eigen::Vector3d normal_world = Eigen::Vector3d::Constant(std::nan(""));
    if (std::isfinite(fit.slope_x)) normal_world = T_world_cam_.rotation * v.normal.normal.normalized();
    note_noise(x, y, v, other);
    mesh_->vertices_mm.push_back((T_world_cam_ * v.p_cam_mm).cast<float>());
    normals_.push_back(normal_world.cast<float>());
    return static_cast<int>(mesh_->vertices_mm.size()) - 1;
  }

  /// Returns the surface that these triangles make. Vertices whose slopes nothing tells have the normals of
  /// their triangles.
  MeasuredSurface surface(std::vector<std::array<int, 3>> triangles) && {
    mesh_->triangles = std::move(triangles);
    mesh_->vertex_normals = compute_vertex_normals(*mesh_);
    for (std::size_t i = 0; i < normals_.size(); ++i)
      if (std::isfinite(normals_[i].x())) mesh_->vertex_normals[i] = normals_[i];
    SurfaceNoise noise;
    if (n_ > 0) {
      noise.leverage = own_squares_ > 0.0 ? squares_ / own_squares_ : leverage_ / static_cast<double>(n_);
      noise.radius_px = radius_px_ / static_cast<double>(n_);
    }
    for (NoiseInView& seen : seen_) noise.of_camera.push_back(std::move(seen).finish());
    return {std::move(mesh_), std::move(noise)};
  }

 private:
  /// What a vertex was made of.
  struct FittedVertex {
    const DepthFit& fit;
    RayOfPixel at;
    NormalOfFit normal;
    Eigen::Vector3d p_cam_mm;
  };

  void note_noise(int x, int y, const FittedVertex& v, const DepthFit& other) {
    const auto& [fit, at, normal, p_cam_mm] = v;
    const bool is_beyond = x < 0 || y < 0 || x >= map_.z_mm.width || y >= map_.z_mm.height;
    if (is_beyond || !std::isfinite(map_.z_mm(x, y))) return;
    const double own_sigma = static_cast<double>(map_.sigma_mm(x, y)) * fit.inverse_depth * fit.inverse_depth;
    if (std::isfinite(own_sigma)) {
      squares_ += static_cast<double>(fit.leverage) * own_sigma * own_sigma;
      own_squares_ += own_sigma * own_sigma;
    }
    leverage_ += static_cast<double>(fit.leverage);
    radius_px_ += static_cast<double>(fit.radius_px);
    ++n_;
    if (!(own_sigma > 0.0)) return;  // not known: as the median of the others
    VertexNoise vertex{
        .p_mm = T_world_cam_ * p_cam_mm,
        // nothing is known of a window of one pixel: it faces the camera
        .normal =
            T_world_cam_.rotation * (std::isfinite(fit.slope_x) ? normal.normal : Eigen::Vector3d(-p_cam_mm)),
        .depth_mm = shared_ * own_sigma * p_cam_mm.z() * p_cam_mm.z() *
                    std::sqrt(static_cast<double>(fit.leverage) * share_in_pixel(fit.radius_px).depth),
        .shading = light_mm_ ? shared_ * own_sigma * shading_per_sigma(fit, normal, *light_mm_ - p_cam_mm)
                             : DepthFit::kUnknown,
        .radius_px = fit.radius_px};
    if (other.known()) note_smoothing(v, other, shared_ * own_sigma, vertex);
    for (std::size_t c = 0; c < seen_.size(); ++c)
      seen_[c].add(vertex, c == camera_ ? std::optional<Eigen::Vector2d>({x, y}) : std::nullopt);
  }

  /// Writes what smoothing has changed, which is taken to grow as the square of a window's radius: what two
  /// windows tell otherwise, over by how much that square differs. Of nested windows the variance of the
  /// difference is the difference of the variances.
  void note_smoothing(const FittedVertex& v, const DepthFit& other, double own_sigma,
                      VertexNoise& vertex) const {
    const auto& [fit, at, normal, p_cam_mm] = v;
    const double per_difference =
        1.0 / (std::pow(static_cast<double>(other.radius_px / fit.radius_px), 2) - 1.0);
    const auto smoothed = [&](double difference, double variance, double other_variance) {
      return Smoothed{difference, own_sigma * std::sqrt(std::abs(other_variance - variance))}.times(
          per_difference);
    };
    const double z2 = p_cam_mm.z() * p_cam_mm.z();  // of a depth per inverse depth
    vertex.smoothed_depth_mm =
        smoothed(1.0 / other.inverse_depth - 1.0 / fit.inverse_depth,
                 z2 * z2 * static_cast<double>(fit.leverage), z2 * z2 * static_cast<double>(other.leverage));
    if (!light_mm_ || !std::isfinite(vertex.shading)) return;
    const Eigen::Vector3d to_light = *light_mm_ - p_cam_mm;
    const double changed = NormalOfFit(at, other).cosine(to_light) / normal.cosine(to_light) - 1.0;
    if (std::abs(changed) < kMostChanged)
      vertex.smoothed_shading =
          smoothed(changed, normal.shading_variance(fit, to_light), normal.shading_variance(other, to_light));
  }

  /// Returns the relative error of the light that a pixel catches per error of its own inverse depth; NaN
  /// where it catches hardly any.
  double shading_per_sigma(const DepthFit& fit, const NormalOfFit& normal, const Eigen::Vector3d& to_light) {
    if (!(normal.cosine(to_light) > kLeastCosine)) return DepthFit::kUnknown;
    return std::sqrt(share_in_pixel(fit.radius_px).slope * normal.shading_variance(fit, to_light));
  }

  const PixelShares& share_in_pixel(float radius_px) {
    const auto [it, is_new] = share_in_pixel_.try_emplace(radius_px);
    if (is_new) it->second = shares_in_pixel(static_cast<double>(radius_px));
    return it->second;
  }

  static constexpr double kMostChanged = 0.5;  ///< of a light: beyond, nothing is linear
  static constexpr double kLeastCosine = 0.1;  ///< of the normal and the light: flatter ones have hardly any
  std::size_t camera_;
  const Lens& lens_;
  double shared_ = 1.0;  ///< noise of a window, over that of points whose noise is their own
  Pose T_world_cam_;
  const DepthMap& map_;
  std::shared_ptr<Mesh> mesh_;
  std::vector<NoiseInView> seen_;  ///< a camera each
  std::vector<Eigen::Vector3f> normals_;
  std::optional<Eigen::Vector3d> light_mm_;      ///< in the camera's frame
  std::map<float, PixelShares> share_in_pixel_;  ///< by radius of the window
  double squares_ = 0.0, own_squares_ = 0.0;     // of the noise of vertices, and of their pixels
  double leverage_ = 0.0, radius_px_ = 0.0;      // sums
  std::size_t n_ = 0;
};

/// Returns what the surfaces around a pixel without one say of it (of `fits` with the frame): the nearest of
/// them, continued; unknown where there is none. A pixel on an outline sees a part of the surface and is
/// measured, but has no point of its own (mixed_pixels.hpp). `anchor_mm`: depth of the pixel that the surface
/// is continued from.
DepthFit continued(const DepthMap& map, const Image<DepthFit>& fits, int x, int y, double& anchor_mm) {
  struct Neighbour {
    const DepthFit* fit;
    double dx, dy;
  };
  std::array<Neighbour, 8> around{};
  std::size_t n = 0;
  const DepthFit* nearest = nullptr;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int i = x - dx, j = y - dy;
      if ((dx == 0 && dy == 0) || i < 0 || j < 0 || i >= fits.width || j >= fits.height) continue;
      const DepthFit& fit = fits(i, j);
      if (!fit.known() || !std::isfinite(fit.slope_x)) continue;
      around[n++] = {&fit, static_cast<double>(dx), static_cast<double>(dy)};
      if (!nearest || fit.inverse_depth > nearest->inverse_depth) nearest = &fit;
    }
  DepthFit out;
  if (!nearest) return out;
  double inverse_depth = 0.0, slope_x = 0.0, slope_y = 0.0, curvature = 0.0, joined = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    const auto& [fit, dx, dy] = around[k];
    if (!map.joined(1.0 / nearest->inverse_depth, 1.0 / fit->inverse_depth, 2.0, 0.0)) continue;
    inverse_depth += fit->inverse_depth + fit->slope_x * dx + fit->slope_y * dy;
    slope_x += fit->slope_x;
    slope_y += fit->slope_y;
    curvature += fit->curvature;
    joined += 1.0;
  }
  if (!(inverse_depth > 0.0)) return out;
  if (!map.joined(1.0 / nearest->inverse_depth, joined / inverse_depth, 2.0, 0.0)) return out;
  anchor_mm = 1.0 / nearest->inverse_depth;
  out.inverse_depth = inverse_depth / joined;
  out.slope_x = slope_x / joined;
  out.slope_y = slope_y / joined;
  out.curvature = curvature / joined;
  return out;
}

/// Returns the fits with a frame of pixels around them that are not known.
Image<DepthFit> with_frame(const Image<DepthFit>& fits) {
  Image<DepthFit> out(fits.width + 2 * kFrame, fits.height + 2 * kFrame, DepthFit{});
  for (int y = 0; y < fits.height; ++y)
    for (int x = 0; x < fits.width; ++x) out(x + kFrame, y + kFrame) = fits(x, y);
  return out;
}

}  // namespace

PixelShares shares_in_pixel(double radius_px) {
  constexpr std::array kOfVertices{0.125, 0.75, 0.125};  // in a pixel's mean, along an axis
  const std::vector<WindowOffset> window = window_of(radius_px);
  // Of a quadratic, only what goes as r^2 = dx^2 + dy^2 cannot be told from the value in the middle: with a +
  // b r^2, a has a point's weight fourths - squares r^2 and b, a quarter of the curvature, count r^2 -
  // squares, but for a factor. The slope along x has the weight dx.
  double count = 0.0, squares = 0.0, fourths = 0.0;
  for (const WindowOffset& o : window) {
    const double r2 = o.dx * o.dx + o.dy * o.dy;
    count += 1.0, squares += r2, fourths += r2 * r2;
  }
  const bool is_quadratic = window.size() >= static_cast<std::size_t>(kQuadraticPoints);
  const int r = static_cast<int>(radius_px) + 1, size = 2 * r + 1;
  ImageD depth(size, size, 0.0), slope(size, size, 0.0);  // what each point adds to the pixel's mean
  PixelShares own{0.0, 0.0}, mean{0.0, 0.0};
  for (const WindowOffset& o : window) {
    const double r2 = o.dx * o.dx + o.dy * o.dy, in_slope = o.dx;
    const double in_value = is_quadratic ? fourths - squares * r2 : 1.0,
                 in_depth = is_quadratic ? in_value - kBends * 4.0 * (count * r2 - squares) : 1.0;
    own.depth += in_value * in_value, own.slope += in_slope * in_slope;
    for (int v = -1; v <= 1; ++v)
      for (int u = -1; u <= 1; ++u) {
        const double of_vertex = kOfVertices[u + 1] * kOfVertices[v + 1];
        depth(o.dx + u + r, o.dy + v + r) += of_vertex * in_depth;
        slope(o.dx + u + r, o.dy + v + r) += of_vertex * in_slope;
      }
  }
  for (const double d : depth.data) mean.depth += d * d;
  for (const double s : slope.data) mean.slope += s * s;
  return {mean.depth / own.depth, own.slope > 0.0 ? mean.slope / own.slope : 1.0};
}

MeasuredSurface build_surface(const Twin& twin, std::size_t camera, const PointCloud& cloud,
                              const MeasuredShape& shape) {
  FT_CHECK(camera < twin.cameras.size(), "camera index");
  if (!(shape.smoothing_px >= 0.0) || shape.smoothing_px > kMostSmoothing ||
      shape.most_smoothing_px > kMostSmoothing)
    throw UserError(ExitCode::usage, twin.file.string(), "smoothing_px must lie between 0 and 50");
  const Camera& cam = twin.cameras[camera];
  const DepthMap map = make_depth_map(cam, cloud);
  const Image<DepthFit> measured = fit_depths(map, shape.smoothing_px, shape.most_smoothing_px),
                        others = other_fits(map, shape.smoothing_px, measured);
  Image<DepthFit> fits = with_frame(measured);
  ImageD anchor_mm(fits.width, fits.height, DepthFit::kUnknown);
  std::vector<std::pair<std::size_t, DepthFit>> beyond;  // entered when all have looked at what is measured
  for (int y = 0; y < fits.height; ++y)
    for (int x = 0; x < fits.width; ++x)
      if (fits(x, y).known())
        anchor_mm(x, y) = 1.0 / fits(x, y).inverse_depth;
      else if (const DepthFit fit = continued(map, fits, x, y, anchor_mm(x, y)); fit.known())
        beyond.emplace_back(static_cast<std::size_t>(y) * fits.width + x, fit);
  for (const auto& [pixel, fit] : beyond) fits.data[pixel] = fit;
  Vertices vertices(twin, camera, map);
  const int width = fits.width, height = fits.height;
  Image<int> vertex(width, height, -1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (fits(x, y).known()) {
        const int px = x - kFrame, py = y - kFrame;
        const bool is_beyond = px < 0 || py < 0 || px >= others.width || py >= others.height;
        vertex(x, y) = vertices.add(px, py, fits(x, y), is_beyond ? DepthFit{} : others(px, py));
      }
  DepthMap fitted{ImageD(width, height, DepthFit::kUnknown), {}, map.step};
  for (std::size_t i = 0; i < fits.size(); ++i)
    if (fits.data[i].known()) fitted.z_mm.data[i] = 1.0 / vertex_of(fits.data[i]);
  std::vector<std::array<int, 3>> triangles;
  for (int y = 0; y + 1 < height; ++y)
    for (int x = 0; x + 1 < width; ++x) add_cell(fitted, anchor_mm, vertex, x, y, triangles);
  if (triangles.empty())
    throw UserError(ExitCode::input, twin.file.string(),
                    "the measured depth map has no two neighbouring points",
                    "check that the captures belong to this twin");
  return std::move(vertices).surface(std::move(triangles));
}

}  // namespace fringetwin::measure
