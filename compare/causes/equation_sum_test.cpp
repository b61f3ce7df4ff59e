// SPDX-License-Identifier: Apache-2.0
// Sums of normal equations, by whole rows and image by image, against the products written out.
//
// | check | tolerance | origin                                                                      |
// |-------|-----------|-----------------------------------------------------------------------------|
// | sums  | 1e-12     | of what is summed up, 200 pixels of numbers within 1, in double precision   |
// | own   | 0         | what is a pixel's own is taken off to rounding, and that is none            |
#include "compare/causes/equation_sum.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

namespace fringetwin::compare::equation_sum_test {
namespace {

constexpr Eigen::Index kImages = 6;

/// Unknowns that change single images behind some that change all of them.
ColumnsOfImages columns_of(Eigen::Index in_all, Eigen::Index in_each) {
  ColumnsOfImages columns(kImages);
  for (Eigen::Index j = 0; j < kImages; ++j) {
    std::vector<Eigen::Index>& of_image = columns[static_cast<std::size_t>(j)];
    for (Eigen::Index k = 0; k < in_all; ++k) of_image.push_back(k);
    for (Eigen::Index k = 0; k < in_each; ++k) of_image.push_back(in_all + j * in_each + k);
  }
  return columns;
}

/// Sums up random pixels, of which each has none, one or two numbers of its own; the last unknown of all
/// images is such a number.
void expect_right(Eigen::Index in_all, Eigen::Index in_each, int n_pixels) {
  const ColumnsOfImages columns = columns_of(in_all, in_each);
  const Eigen::Index size = in_all + kImages * in_each;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto draw = [&](Eigen::Index rows, Eigen::Index cols) {
    return Eigen::MatrixXd(Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return number(random); }));
  };
  EquationSum sum(size, columns);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  double chi2 = 0.0;
  for (int p = 0; p < n_pixels; ++p) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(kImages, size);
    for (Eigen::Index j = 0; j < kImages; ++j)
      for (const Eigen::Index k : columns[static_cast<std::size_t>(j)]) rows(j, k) = number(random);
    const Eigen::Index n_own = p % 3 == 0 && in_all == 0 ? 0 : 1 + p % 2;
    Eigen::MatrixXd own = draw(kImages, n_own);
    if (in_all > 0) rows.col(in_all - 1) = own.col(0);
    if (n_own > 0)
      own = Eigen::HouseholderQR<Eigen::MatrixXd>(own).householderQ() *
            Eigen::MatrixXd::Identity(kImages, n_own);
    Eigen::VectorXd residual = draw(kImages, 1);
    residual -= own * (own.transpose() * residual);
    sum.rows() = rows, sum.residual() = residual;
    sum.take(own, 6 - static_cast<std::uint64_t>(n_own));
    const Eigen::MatrixXd left = rows - own * (own.transpose() * rows);
    normal += left.transpose() * left;
    right += left.transpose() * residual;
    chi2 += residual.squaredNorm();
  }
  const NormalEquations& found = sum.finish();
  for (Eigen::Index i = 0; i < size; ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) EXPECT_NEAR(found.normal(i, j), normal(i, j), 1e-12 * 6 * n_pixels);
    EXPECT_NEAR(found.right[i], right[i], 1e-12 * 6 * n_pixels);
  }
  EXPECT_NEAR(found.chi2, chi2, 1e-12 * 6 * n_pixels);
  if (in_all > 0 && in_each > 0) {
    EXPECT_EQ(found.normal(in_all - 1, in_all - 1), 0.0);
    EXPECT_EQ(found.right[in_all - 1], 0.0);
    EXPECT_GT(found.normal(size - 1, size - 1), 1.0);
  }
}

TEST(EquationSum, IsTheProductOfWhatIsLeft) {
  expect_right(5, 0, 100);  // by whole rows
  expect_right(0, 9, 100);  // image by image
  expect_right(7, 9, 200);
  expect_right(7, 9, 32);  // as many as one product holds
}

TEST(EquationSum, OfNothingIsNothing) {
  const ColumnsOfImages columns = columns_of(3, 9);
  EquationSum none(3 + kImages * 9, columns);
  EXPECT_EQ(none.finish().normal.norm(), 0.0);
  const ColumnsOfImages empty(kImages);
  EquationSum no_unknowns(0, empty);
  no_unknowns.residual().setConstant(2.0);
  no_unknowns.take(Eigen::MatrixXd(kImages, 0), 6);
  EXPECT_EQ(no_unknowns.finish().chi2, 4.0 * kImages);
  EXPECT_EQ(no_unknowns.finish().n, 6u);
}

}  // namespace
}  // namespace fringetwin::compare::equation_sum_test
