// SPDX-License-Identifier: Apache-2.0
// tolerance  unit  origin
// 4e-15      -     entries of a rotation and angles up to pi: about 20 roundings of 2.2e-16
// 1e-11      mm    the 4e-15 above times coordinates up to 1000 mm and sqrt(3)
// 1e-13      -     against Eigen's matrix exponential (Pade with squaring, rounding about 1e-14)
#include "twin/lens/pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "tests/support/twin/random_values.hpp"

namespace fringetwin::pose_test {
namespace {

using testing::any_vector;
using testing::uniform;

constexpr double pi = std::numbers::pi;
constexpr double mm = 1e-11;

Eigen::Vector3d any_direction() {
  Eigen::Vector3d v = any_vector(1.0);
  if (v.norm() < 1e-3) v.z() += 1.0;
  return v.normalized();
}

Pose any_pose() {
  const Eigen::Vector3d r = any_direction() * *uniform(0.0, pi);
  return {rotation_from_vector(r), any_vector(1000.0)};
}

double distance(const Pose& a, const Pose& b) {
  return std::max((a.rotation - b.rotation).cwiseAbs().maxCoeff() * 1000.0,
                  (a.translation_mm - b.translation_mm).cwiseAbs().maxCoeff());
}

/// Independent truth: exp([r]x) by Eigen's Pade approximation.
Eigen::Matrix3d exponential(const Eigen::Vector3d& r) {
  Eigen::Matrix3d K;
  K << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  return K.exp();
}

TEST(Pose, QuarterTurnAboutZMapsXToY) {
  const Pose T = pose_from_rt((RotTrans() << 0, 0, pi / 2, 10, 20, 30).finished());
  const Eigen::Vector3d expected(10, 21, 30);
  EXPECT_LT((T * Eigen::Vector3d(1, 0, 0) - expected).norm(), 1e-14);
}

TEST(Pose, MapsAPointAsTheConventionSays) {  // x_a = R x_b + t
  const Pose T =
      pose_from_rt((RotTrans() << -0.0086, 0.7078, 0.0058, -189.5009, -1.1664, 66.0589).finished());
  const Eigen::Vector3d p(6.567, -5.497, 270.634);
  EXPECT_LT((T * p - (T.rotation * p + T.translation_mm)).norm(), 1e-12);
}

TEST(Pose, AtExactlyZeroAndTinyAngles) {
  EXPECT_EQ(rotation_from_vector(Eigen::Vector3d::Zero()), Eigen::Matrix3d::Identity());
  EXPECT_EQ(vector_from_rotation(Eigen::Matrix3d::Identity()), Eigen::Vector3d::Zero());
  for (int exponent = -320; exponent <= -1; ++exponent) {
    const double a = std::pow(10.0, exponent);
    const Eigen::Vector3d r = a * Eigen::Vector3d(0.6, 0.0, -0.8);
    const Eigen::Vector3d back = vector_from_rotation(rotation_from_vector(r));
    // relative: an angle of 1e-300 survives; only the last subnormal bits round
    EXPECT_LE((back - r).lpNorm<Eigen::Infinity>(), 4e-15 * a + 5e-324) << "angle " << a;
  }
}

TEST(Pose, AtAndNearAHalfTurn) {
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1),
        Eigen::Vector3d(0.6, 0.0, 0.8), Eigen::Vector3d(1, 1, 1).normalized(),
        Eigen::Vector3d(-1e-9, 1, 1e-5).normalized()}) {
    for (const double below : {0.0, 1e-16, 1e-12, 1e-9, 1e-6, 1e-3}) {
      const Eigen::Vector3d r = axis * (pi - below);
      const Eigen::Matrix3d R = rotation_from_vector(r);
      const Eigen::Vector3d back = vector_from_rotation(R);
      EXPECT_LE(back.norm(), pi * (1 + 1e-15));
      EXPECT_LT((rotation_from_vector(back) - R).cwiseAbs().maxCoeff(), 4e-15);
      // at exactly pi both signs of the axis are the same rotation
      const double error = std::min((back - r).norm(), (back + r).norm() + (below > 1e-12 ? 1.0 : 0.0));
      EXPECT_LT(error, 4e-15) << axis.transpose() << " pi - " << below;
    }
  }
}

TEST(Pose, AnglesBeyondPiComeBackAsTheShortWay) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.5).normalized();
  const Eigen::Vector3d back = vector_from_rotation(rotation_from_vector(axis * 4.0));
  EXPECT_LT((back - axis * (4.0 - 2 * pi)).norm(), 4e-15);
}

RC_GTEST_PROP(PoseProperty, RotationIsTheMatrixExponential, ()) {
  const Eigen::Vector3d r = any_direction() * *uniform(0.0, 3.0 * pi);
  RC_ASSERT((rotation_from_vector(r) - exponential(r)).cwiseAbs().maxCoeff() < 1e-13);
}

RC_GTEST_PROP(PoseProperty, RotationIsOrthogonalWithDeterminantOne, ()) {
  const Eigen::Matrix3d R = rotation_from_vector(any_direction() * *uniform(0.0, 3.0 * pi));
  RC_ASSERT((R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 4e-15);
  RC_ASSERT(std::abs(R.determinant() - 1.0) < 4e-15);
}

RC_GTEST_PROP(PoseProperty, VectorAndMatrixRoundTrip, ()) {
  const Eigen::Vector3d r = any_direction() * *uniform(0.0, pi - 1e-6);
  RC_ASSERT((vector_from_rotation(rotation_from_vector(r)) - r).norm() < 4e-15);
}

RC_GTEST_PROP(PoseProperty, InverseUndoes, ()) {
  const Pose T = any_pose();
  RC_ASSERT(distance(T * T.inverse(), Pose{}) < mm);
  RC_ASSERT(distance(T.inverse() * T, Pose{}) < mm);
  const Eigen::Vector3d p = any_vector(1000.0);
  RC_ASSERT((T.inverse() * (T * p) - p).norm() < mm);
}

RC_GTEST_PROP(PoseProperty, CompositionIsAssociativeAndActsInOrder, ()) {
  const Pose T_a_b = any_pose(), T_b_c = any_pose(), T_c_d = any_pose();
  RC_ASSERT(distance((T_a_b * T_b_c) * T_c_d, T_a_b * (T_b_c * T_c_d)) < mm);
  const Eigen::Vector3d p_c = any_vector(1000.0);
  RC_ASSERT(((T_a_b * T_b_c) * p_c - T_a_b * (T_b_c * p_c)).norm() < mm);
}

RC_GTEST_PROP(PoseProperty, RtRoundTrips, ()) {
  RotTrans rt;
  rt << any_direction() * *uniform(0.0, pi - 1e-6), any_vector(1000.0);
  RC_ASSERT((rt_from_pose(pose_from_rt(rt)) - rt).cwiseAbs().maxCoeff() < 4e-15);
}

}  // namespace
}  // namespace fringetwin::pose_test
