// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program/rig_indirect.hpp"

#include <algorithm>
#include <cmath>

#include "render/reference/reference.hpp"

namespace fringetwin::testing {
namespace {

constexpr int kStride = 4;

class Indirect {
 public:
  Indirect(const Twin& dark, const Twin& lit, std::size_t camera) : dark_(dark), lit_(lit), camera_(camera) {}

  std::vector<ImageF> images() {
    find_objects();
    const int width = objects_.width, height = objects_.height;
    images_.assign(expand_sequence(dark_.twin().fringes).size(), ImageF(width, height));
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (!between_nodes(x, y) || is_node(x, y)) compute(x, y);
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (between_nodes(x, y) && !is_node(x, y)) interpolate(x, y);
    return std::move(images_);
  }

 private:
  static bool is_node(int x, int y) { return x % kStride == 0 && y % kStride == 0; }
  /// A pixel that sees one plane alone.
  bool between_nodes(int x, int y) const { return objects_(x, y) >= 0; }

  /// Index of the plane that fills the pixel, else -1.
  void find_objects() {
    const Lens& lens = dark_.twin().cameras[camera_].lens;
    objects_ = Image<int>(lens.width(), lens.height(), -1);
#pragma omp parallel for schedule(dynamic)
    for (int y = 0; y < objects_.height; ++y)
      for (int x = 0; x < objects_.width; ++x) {
        const int object = dark_.sample(camera_, Eigen::Vector2d(x, y)).object;
        if (object >= 0 && seen_alone(x, y, object) &&
            std::holds_alternative<PlaneShape>(dark_.twin().objects[static_cast<std::size_t>(object)].shape))
          objects_(x, y) = object;
      }
  }

  bool seen_alone(int x, int y, int object) const {
    for (const double dx : {-0.5, 0.5})
      for (const double dy : {-0.5, 0.5})
        if (dark_.sample(camera_, Eigen::Vector2d(x + dx, y + dy)).object != object) return false;
    return true;
  }

  void compute(int x, int y) {
    const int centre = dark_.sample(camera_, Eigen::Vector2d(x, y)).object;
    const render::ReferenceQuadrature quadrature =
        between_nodes(x, y) ? render::ReferenceQuadrature{.gauss_n = 1, .bounce_n = 96, .paths = 2}
        : centre >= 0 && seen_alone(x, y, centre) ? render::ReferenceQuadrature{.gauss_n = 1, .bounce_n = 40}
                                                  : render::ReferenceQuadrature{.gauss_n = 4, .bounce_n = 16};
    const auto all = lit_.pixel(camera_, x, y, quadrature), direct = dark_.pixel(camera_, x, y, quadrature);
    for (std::size_t k = 0; k < images_.size(); ++k)
      images_[k](x, y) = static_cast<float>(all.irradiance[k] - direct.irradiance[k]);
  }

  /// From the nodes on the same plane around the pixel.
  void interpolate(int x, int y) {
    std::vector<double> sum(images_.size(), 0.0);
    double weights = 0.0;
    for (int j = y / kStride - 1; j <= y / kStride + 2; ++j)
      for (int i = x / kStride - 1; i <= x / kStride + 2; ++i) {
        const int u = i * kStride, v = j * kStride;
        if (u < 0 || v < 0 || u >= objects_.width || v >= objects_.height || objects_(u, v) != objects_(x, y))
          continue;
        const auto tent = [](int distance) {
          return std::max(0.0, 1.0 - std::abs(distance) / double{kStride});
        };
        const double w = tent(x - u) * tent(y - v) + 1e-6;  // farther nodes where no near one sees the plane
        weights += w;
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += w * static_cast<double>(images_[k](u, v));
      }
    if (weights == 0.0) return compute(x, y);
    for (std::size_t k = 0; k < sum.size(); ++k) images_[k](x, y) = static_cast<float>(sum[k] / weights);
  }

  render::Reference dark_, lit_;
  std::size_t camera_;
  Image<int> objects_;
  std::vector<ImageF> images_;
};

}  // namespace

std::vector<ImageF> indirect_irradiance(Twin twin, std::size_t camera) {
  Twin dark = twin;
  dark.render.bounces = 0;
  twin.render.bounces = kAllBounces;
  return Indirect(dark, twin, camera).images();
}

}  // namespace fringetwin::testing
