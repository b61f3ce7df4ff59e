// SPDX-License-Identifier: Apache-2.0
// Tells which object of the twin each pixel of a camera shows, from the points that were measured: points go
// in, one label per pixel comes out.
#pragma once
#include <cstddef>
#include <limits>
#include <vector>

#include "measure/fit/object_fits.hpp"
#include "measure/points/points.hpp"
#include "twin/image/image.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// A label is the index of an object in twin.objects, or one of these.
inline constexpr int kUnknownObject = -1;  ///< no point tells
inline constexpr int kNoObject = -2;       ///< a real point that is near no object of the twin

/// Tells which object's nominal surface a point is nearest to. An object's gate is that of its
/// [[measure.fit]], else the widest of them.
class NearestObject {
 public:
  /// Keeps references to the twin's objects.
  explicit NearestObject(const Twin& twin);
  /// False where an object is itself made from the real capture, or was not loaded.
  bool is_known() const { return is_known_; }
  /// Returns the index of the object, kNoObject beyond every gate.
  int operator()(const Eigen::Vector3d& p_world_mm) const;
  /// Returns the smallest gate of all objects; infinity without any.
  double least_gate_mm() const { return least_gate_mm_; }

 private:
  std::vector<measure::SurfaceGate> surfaces_;
  double least_gate_mm_ = std::numeric_limits<double>::infinity();
  bool is_known_ = false;
};

/// Returns, per pixel of the camera, the index of a point of the cloud that it shows, -1 where none: of the
/// first camera its own points, of another one those that project there, the nearest of them.
Image<int> points_of_pixels(const Twin& twin, std::size_t camera, const measure::PointCloud& cloud);

/// What one side knows of a camera's pixels.
struct PixelPoints {
  const ImageU8& measured;  ///< 1 where the pixel has a valid phase
  const measure::PointCloud& cloud;
  const Image<int>& index;  ///< points_of_pixels()
};

/// Returns the label of every pixel of `area`, kUnknownObject elsewhere: of a pixel measured on one side only
/// that of its point, of every fourth one along x and y measured on both that of its simulated point; the
/// others take the label of the nearest labelled one within the area. All unknown where there are no points,
/// or where an object is itself made from the real capture.
Image<int> object_labels(const Twin& twin, const PixelPoints& real, const PixelPoints& simulated,
                         const ImageU8& area);

}  // namespace fringetwin::compare
