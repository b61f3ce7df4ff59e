// SPDX-License-Identifier: Apache-2.0
// Models that go through libmrcal, against closed forms, an own B-spline and mrcal's Python side.
// tolerance  unit      origin
// 1e-10      px        closed forms at coordinates up to 4000 px: 100 roundings of 1e-12
// 1e-9       px        the promise of unproject()
// 1e-8 * f   px        gradient against central differences (see lens_test.cpp)
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <random>
#include <utility>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/mrcal_facade.hpp"

namespace fringetwin::lens_mrcal_test {
namespace {

using ::testing::HasSubstr;

struct NamedLens {
  std::string name;
  std::vector<double> intrinsics;
  Eigen::Vector2i size;
  Lens make() const { return {name, intrinsics, size, "test"}; }
};

const std::string spline_name = "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=11_Ny=8_fov_x_deg=60";
constexpr int spline_nx = 11, spline_ny = 8;

/// A lens of 45 degrees whose spline deforms by up to 1 % of the focal length, rough on purpose.
NamedLens splined(double amplitude = 0.01) {
  NamedLens lens{spline_name, {1800, 1805, 731.3, 523.7}, {1440, 1080}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-amplitude, amplitude);
  for (int i = 0; i < 2 * spline_nx * spline_ny; ++i) lens.intrinsics.push_back(uniform(random));
  return lens;
}

std::vector<NamedLens> all_lenses() {
  return {{"LENSMODEL_STEREOGRAPHIC", {900, 905, 640, 470}, {1280, 960}},
          {"LENSMODEL_LONLAT", {700, 700, 640, 470}, {1280, 960}},
          {"LENSMODEL_LATLON", {700, 700, 640, 470}, {1280, 960}},
          {"LENSMODEL_CAHVOR", {1500, 1502, 640, 470, 0.01, -0.02, 0.003, 0.1, -0.05}, {1280, 960}},
          {"LENSMODEL_CAHVORE_linearity=0.34",
           {1200, 1203, 640, 480, 0.01, 0.02, 0.003, 0.01, 0.02, 0.001, 0.002, 0.003},
           {1280, 960}},
          splined()};
}

std::vector<Eigen::Vector2d> grid_of_pixels(const Lens& lens, int n) {
  std::vector<Eigen::Vector2d> pixels;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i)
      pixels.emplace_back(-0.5 + lens.width() * static_cast<double>(i) / n,
                          -0.5 + lens.height() * static_cast<double>(j) / n);
  return pixels;
}

Eigen::Vector2d stereographic(const Eigen::Vector3d& p) {  // 2 tan(theta/2) along (x, y)
  const double theta = std::atan2(p.head<2>().norm(), p.z());
  if (theta == 0.0) return Eigen::Vector2d::Zero();
  return 2.0 * std::tan(0.5 * theta) * p.head<2>().normalized();
}

/// Uniform cubic B-spline on a knot grid over [-half, half].
Eigen::Vector2d spline_deformation(const std::vector<double>& intrinsics, const Eigen::Vector2d& half,
                                   const Eigen::Vector2d& u) {
  const auto basis = [](double t) -> Eigen::Vector4d {
    return Eigen::Vector4d((1 - t) * (1 - t) * (1 - t), 3 * t * t * t - 6 * t * t + 4,
                           -3 * t * t * t + 3 * t * t + 3 * t + 1, t * t * t) /
           6.0;
  };
  const double kx = (u.x() / half.x() + 1) * 0.5 * (spline_nx - 1);
  const double ky = (u.y() / half.y() + 1) * 0.5 * (spline_ny - 1);
  const int ix = std::clamp(static_cast<int>(kx), 1, spline_nx - 3);
  const int iy = std::clamp(static_cast<int>(ky), 1, spline_ny - 3);
  const Eigen::Vector4d bx = basis(kx - ix), by = basis(ky - iy);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 4; ++i) {
      const int at = 4 + 2 * ((iy - 1 + j) * spline_nx + ix - 1 + i);
      sum += bx[i] * by[j] * Eigen::Map<const Eigen::Vector2d>(intrinsics.data() + at);
    }
  }
  return sum;
}

TEST(LensMrcal, IsNotPerspective) {
  const Lens lens = splined().make();
  EXPECT_FALSE(lens.is_perspective());
  EXPECT_THROW(lens.opencv_distortion(), std::logic_error);
  EXPECT_THROW(lens.max_invertible_radius_sq(), std::logic_error);
}

TEST(LensMrcal, RoundTripsOverTheWholeImage) {
  for (const NamedLens& named : all_lenses()) {
    const Lens lens = named.make();
    double worst_px = 0.0;
    for (const Eigen::Vector2d& q : grid_of_pixels(lens, 41)) {
      const auto v = lens.unproject(q);
      ASSERT_TRUE(v) << named.name << " " << q.transpose();
      EXPECT_NEAR(v->norm(), 1.0, 4e-16);
      const auto back = lens.project(*v * 270.0);
      ASSERT_TRUE(back) << named.name;
      worst_px = std::max(worst_px, (*back - q).norm());
    }
    EXPECT_LT(worst_px, 1e-9) << named.name;
  }
}

TEST(LensMrcal, GradientEqualsCentralDifferences) {
  for (const NamedLens& named : all_lenses()) {
    const Lens lens = named.make();
    for (const Eigen::Vector2d& q : grid_of_pixels(lens, 9)) {
      const Eigen::Vector3d p = *lens.unproject(q);
      Eigen::Matrix<double, 2, 3> J;
      ASSERT_TRUE(lens.project(p, &J));
      constexpr double h = 1e-6;
      for (int axis = 0; axis < 3; ++axis) {
        const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
        const auto ahead = lens.project(p + step), behind = lens.project(p - step);
        if (!ahead || !behind) continue;
        EXPECT_LT((J.col(axis) - (*ahead - *behind) / (2 * h)).norm(), 1e-8 * named.intrinsics[0])
            << named.name;
      }
    }
  }
}

TEST(LensMrcal, StereographicAndLonLatInClosedForm) {
  const std::vector<NamedLens> lenses = all_lenses();
  for (int i = 0; i < 3; ++i) {
    const NamedLens& named = lenses[static_cast<std::size_t>(i)];
    const Lens lens = named.make();
    const Eigen::Vector2d f(named.intrinsics[0], named.intrinsics[1]),
        c(named.intrinsics[2], named.intrinsics[3]);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(-0.4, 0.3, 0.5),
                                     Eigen::Vector3d(30, -20, 250), Eigen::Vector3d(0.5, -0.5, -0.1)}) {
      const double n = p.norm();
      const Eigen::Vector2d u = i == 0   ? stereographic(p)
                                : i == 1 ? Eigen::Vector2d(std::atan2(p.x(), p.z()), std::asin(p.y() / n))
                                         : Eigen::Vector2d(std::asin(p.x() / n), std::atan2(p.y(), p.z()));
      const auto q = lens.project(p);
      ASSERT_TRUE(q) << named.name;  // these see behind the camera, too
      EXPECT_LT((*q - (f.cwiseProduct(u) + c)).norm(), 1e-10) << named.name;
    }
  }
}

TEST(LensMrcal, SplinedEqualsOwnBSpline) {
  const NamedLens named = splined();
  const Lens lens = named.make();
  const Eigen::Vector2d half = *MrcalModel::from_name(spline_name)->spline_half_size();
  const Eigen::Vector2d f(named.intrinsics[0], named.intrinsics[1]),
      c(named.intrinsics[2], named.intrinsics[3]);
  for (const Eigen::Vector2d& pixel : grid_of_pixels(lens, 37)) {
    const Eigen::Vector3d v = *lens.unproject(pixel);
    const Eigen::Vector2d u = stereographic(v);
    const Eigen::Vector2d q = f.cwiseProduct(u + spline_deformation(named.intrinsics, half, u)) + c;
    EXPECT_LT((q - pixel).norm(), 1e-9);
  }
}

TEST(LensMrcal, OutsideTheKnotsThereIsNoPixel) {
  const Lens lens = splined().make();
  const Eigen::Vector2d half = *MrcalModel::from_name(spline_name)->spline_half_size();
  const auto direction = [](const Eigen::Vector2d& u) {  // inverse stereographic projection
    return Eigen::Vector3d(u.x(), u.y(), 1.0 - 0.25 * u.squaredNorm());
  };
  EXPECT_TRUE(lens.project(direction(half * 0.95)));
  EXPECT_FALSE(lens.project(direction({half.x() * 1.01, 0})));
  EXPECT_FALSE(lens.project(direction({0, -half.y() * 1.01})));
  EXPECT_FALSE(lens.project({0, 0, -1}));
}

TEST(LensMrcal, CahvorSeesNothingBehind) {
  const Lens lens = all_lenses()[3].make();
  EXPECT_TRUE(lens.project({0.1, 0, 1}));
  EXPECT_FALSE(lens.project({0.1, 0, -1}));
}

std::string refusal(const NamedLens& named) {
  try {
    named.make();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    return e.what();
  }
  return "";
}

TEST(LensMrcal, RefusesASplineSmallerThanTheImage) {
  NamedLens named = splined();
  named.intrinsics[0] = named.intrinsics[1] = 900;  // 77 degrees of image, 60 of spline
  EXPECT_THAT(refusal(named), HasSubstr("fov_x_deg"));
}

TEST(LensMrcal, RefusesASplineThatFolds) {
  EXPECT_EQ(refusal(splined(0.02)), "");
  EXPECT_THAT(refusal(splined(0.5)), HasSubstr("cannot be inverted at image point"));
}

TEST(LensMrcal, RefusesTheWrongNumberOfKnots) {
  NamedLens named = splined();
  named.intrinsics.pop_back();
  EXPECT_THAT(refusal(named), HasSubstr("takes 180 intrinsics, 179 given"));
}

TEST(LensMrcal, AgreesWithMrcalsPython) {
  if (!testing::has_mrcal_python()) GTEST_SKIP() << "SKIPPED: no mrcal module for /usr/bin/python3";
  const testing::ScratchFolder scratch;
  const auto program = scratch.write("project.py",
                                     "import sys, mrcal, numpy as np\n"
                                     "lines = open(sys.argv[1]).read().splitlines()\n"
                                     "for name, i, p in zip(lines[0::3], lines[1::3], lines[2::3]):\n"
                                     "    numbers = lambda text: np.array([float(x) for x in text.split()])\n"
                                     "    q = mrcal.project(numbers(p).reshape(-1, 3), name, numbers(i))\n"
                                     "    print(' '.join(repr(float(x)) for x in q.ravel()))\n");
  std::ostringstream input;
  input << std::setprecision(17);
  std::vector<std::pair<Lens, Eigen::Vector3d>> points;
  for (const NamedLens& named : all_lenses()) {
    const Lens lens = named.make();
    input << named.name << "\n";
    for (const double x : named.intrinsics) input << x << " ";
    input << "\n";
    for (const Eigen::Vector2d& q : grid_of_pixels(lens, 5)) {
      const Eigen::Vector3d p = *lens.unproject(q) * 270.0;
      input << p.x() << " " << p.y() << " " << p.z() << " ";
      points.emplace_back(lens, p);
    }
    input << "\n";
  }
  const auto file = scratch.write("input.txt", input.str());
  const auto result = testing::run("/usr/bin/python3 " + program.string() + " " + file.string() + " 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  std::istringstream numbers(result.output);
  for (const auto& [lens, p] : points) {
    Eigen::Vector2d q;
    ASSERT_TRUE(numbers >> q.x() >> q.y());
    EXPECT_LT((*lens.project(p) - q).norm(), 1e-11) << lens.model();
  }
}

}  // namespace
}  // namespace fringetwin::lens_mrcal_test
