// SPDX-License-Identifier: Apache-2.0
// What the fits would differ by with other objects, against fits that were moved by hand.
#include "compare/geometry/moved_fits.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "compare/geometry/fit_rows.hpp"
#include "measure/fit/object_fits.hpp"

namespace fringetwin::compare::moved_fits_test {
namespace {

using Eigen::Vector3d;
using measure::ObjectFit;

constexpr double kSigmaMm = 0.001, kSigmaRad = 1e-5;

Twin twin_of(Shape shape) {
  Twin twin;
  twin.objects = {{"part", std::move(shape), {}}};
  return twin;
}

/// The fit of the twin's object itself, with standard errors.
ObjectFit fit_of(const Twin& twin) {
  ObjectFit fit = measure::nominal_fit(twin.objects[0]).value();
  fit.numbers["radius_sigma_mm"] = fit.numbers["offset_sigma_mm"] = kSigmaMm;
  fit.numbers["axis_shift_sigma_mm_0"] = fit.numbers["axis_shift_sigma_mm_1"] = kSigmaMm;
  for (const char* key : {"tilt_sigma_rad_0", "tilt_sigma_rad_1", "axis_sigma_rad_0", "axis_sigma_rad_1"})
    fit.numbers[key] = kSigmaRad;
  fit.vectors["center_sigma_mm"] = Vector3d::Constant(kSigmaMm);
  for (const char* key : {"normal", "axis"})
    if (fit.vectors.contains(key)) {
      fit.vectors["tilt_direction_0"] = fit.vectors[key].unitOrthogonal();
      fit.vectors["tilt_direction_1"] = fit.vectors[key].cross(fit.vectors["tilt_direction_0"]);
    }
  return fit;
}

/// The largest |z| of the twin's fit against the real object's, with the twin's object as it is or as the
/// real one.
std::pair<double, double> before_and_after(const Shape& in_twin, const Shape& real, bool flip = false) {
  const Twin twin = twin_of(in_twin), truth = twin_of(real);
  ObjectFit simulated = fit_of(twin);
  for (const char* key : {"normal", "axis"})
    if (flip && simulated.vectors.contains(key)) simulated.vectors[key] *= -1.0;
  const std::vector<FitRow> rows{make_fit_row(simulated, fit_of(truth))};
  const auto worst = [](const std::vector<FitRow>& of) {
    double most = 0.0;
    for (const auto& [name, z] : z_by_name(of)) most = std::max(most, std::abs(z));
    return most;
  };
  return {worst(moved_fits(rows, twin, twin)), worst(moved_fits(rows, twin, truth))};
}

TEST(MovedFits, ASphereMovesAndGrows) {
  const auto [before, after] =
      before_and_after(SphereShape{{1, 2, 250}, 20.0}, SphereShape{{1.1, 2, 250}, 20.006});
  EXPECT_NEAR(before, 0.1 / std::hypot(kSigmaMm, kSigmaMm), 1e-9);
  EXPECT_NEAR(after, 0.0, 1e-9);
  const auto [with_radius, with_place] =
      before_and_after(SphereShape{{1, 2, 250}, 20.0}, SphereShape{{1, 2, 250}, 20.006});
  EXPECT_NEAR(with_radius, 0.006 / std::hypot(kSigmaMm, kSigmaMm), 1e-9);
  EXPECT_NEAR(with_place, 0.0, 1e-9);
}

TEST(MovedFits, APlaneMovesAndTurnsWhicheverWayItsNormalPoints) {
  const Vector3d normal = Vector3d(0.1, -0.2, -1).normalized();
  const Vector3d turned = (normal + 1e-4 * normal.unitOrthogonal()).normalized();
  for (const bool flip : {false, true}) {
    const auto [before, after] =
        before_and_after(PlaneShape{{3, 4, 260}, normal, {}, Vector3d::UnitX()},
                         PlaneShape{{8, -4, 260.05}, turned, {}, Vector3d::UnitX()}, flip);
    EXPECT_GT(before, 7.0) << flip;
    EXPECT_LT(after, 1e-3) << flip;
  }
}

TEST(MovedFits, ACylinderMovesTurnsAndGrows) {
  const Vector3d axis = Vector3d(0.1, 1, 0.05).normalized();
  const Vector3d turned = (axis + 1e-4 * axis.unitOrthogonal()).normalized();
  for (const bool flip : {false, true}) {
    const auto [before, after] = before_and_after(CylinderShape{{3, 4, 260}, axis, 10.0, {}},
                                                  CylinderShape{{3.02, 14, 260.7}, turned, 10.01, {}}, flip);
    EXPECT_GT(before, 7.0) << flip;
    EXPECT_LT(after, 0.1) << flip;
  }
}

TEST(MovedFits, MeshesAndObjectsWithoutAFitAreLeftOut) {
  Twin twin = twin_of(SphereShape{{0, 0, 250}, 20.0});
  FitRow row = make_fit_row(fit_of(twin), fit_of(twin));
  EXPECT_EQ(moved_fits({row}, twin, twin).size(), 1u);
  row.real->usable = false;
  EXPECT_TRUE(moved_fits({row}, twin, twin).empty());
  row = make_fit_row(fit_of(twin), fit_of(twin));
  twin.objects[0].shape = MeshShape{};
  EXPECT_TRUE(moved_fits({row}, twin, twin).empty());
}

// A ball that may be nearer and larger: each alone is known to 1, their difference to 0.1. A fit that tells
// the difference is as far off as it looks; one that tells the sum is not.
TEST(MovedFits, ValuesThatAreUncertainTogetherExcuseOnlyWhatTheyMove) {
  Eigen::Matrix2d covariance;
  covariance << 1.0, 0.995, 0.995, 1.0;  // of the difference 0.01, of the sum 3.99
  Eigen::Matrix2d slopes;
  slopes << 1.0, -1.0, 1.0, 1.0;
  const Eigen::VectorXd z = with_uncertain_values(Eigen::Vector2d(5.0, 5.0), slopes, covariance);
  EXPECT_NEAR(z[0], 5.0 / std::sqrt(1.01), 1e-12);
  EXPECT_NEAR(z[1], 5.0 / std::sqrt(4.99), 1e-12);
}

}  // namespace
}  // namespace fringetwin::compare::moved_fits_test
