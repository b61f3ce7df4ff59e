// SPDX-License-Identifier: Apache-2.0
// Reflection models of the reference renderer, as their papers print them, albedo maps and vignetting.
#pragma once
#include <Eigen/Core>

#include "twin/twin.hpp"

namespace fringetwin::render {

/// BRDF (1/sr) of Walter et al. 2007, eq. 20, with the GGX distribution (eq. 33), its G1 (eq. 34) for
/// either direction and Schlick's Fresnel factor. Unit vectors; 0 where N.V or N.L is not positive.
double reference_ggx(const Eigen::Vector3d& N, const Eigen::Vector3d& L, const Eigen::Vector3d& V,
                     double reflectance, double roughness);

/// What of the radiance that comes along -L a surface of this albedo sends along V, per steradian, the cosine
/// included. `lobe`: with what its lobe reflects.
double reference_reflected(const Material& material, double albedo, const Eigen::Vector3d& N,
                           const Eigen::Vector3d& L, const Eigen::Vector3d& V, bool lobe);

/// The camera lens's loss of light at a point of the image, 1 without vignetting.
double reference_vignetting(const Camera& camera, const Eigen::Vector2d& q_px);

/// The plane's albedo map at a point on it, 1 without a map: weights of the four nearest pixels.
double reference_map_albedo(const PlaneShape& plane, const Eigen::Vector3d& point_world_mm);

}  // namespace fringetwin::render
