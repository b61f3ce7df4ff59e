// SPDX-License-Identifier: Apache-2.0
// OpenCV's radial, rational, tangential and thin-prism distortion (the formula of mrcal's
// LENSMODEL_OPENCV4/5/8/12 and of cv::projectPoints), its Jacobian, its domain of invertibility.
#pragma once
#include <Eigen/Core>

namespace fringetwin {

/// k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, zero-padded.
using OpenCvDistortion = Eigen::Matrix<double, 12, 1>;

/// Returns the distorted place of an undistorted (x/z, y/z); optionally the Jacobian d distorted / d
/// undistorted.
Eigen::Vector2d distort(const OpenCvDistortion& k, const Eigen::Vector2d& undistorted,
                        Eigen::Matrix2d* jacobian = nullptr);

/// Returns the largest undistorted radius r such that the map is one-to-one on the disk |x| < r; +inf when
/// there is no limit below 1e6.
/// The radial part f(r) has Jacobian eigenvalues f'(r) and f(r)/r; the tangential and thin-prism
/// parts change them by at most 6|p|r + 2|(s1,s3)|r + 4|(s2,s4)|r^3. As long as both stay positive
/// after that, the symmetric part of the Jacobian is positive definite, its determinant positive,
/// and the map one-to-one on the (convex) disk. Without tangential terms the bound is exact.
double max_invertible_radius(const OpenCvDistortion& k);

}  // namespace fringetwin
