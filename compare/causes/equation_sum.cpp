// SPDX-License-Identifier: Apache-2.0
#include "compare/causes/equation_sum.hpp"

namespace fringetwin::compare {
namespace {

constexpr Eigen::Index kPixelsAtOnce = 32, kMostOwn = 2;
constexpr double kRounding = 1e-12;  ///< of a sum of squares of which nearly all is taken off

using Lower = Eigen::SelfAdjointView<Eigen::MatrixXd, Eigen::Lower>;

/// Returns whether the sums by images take less than half of the products that whole rows do.
bool is_sparse(Eigen::Index n_unknowns, const ColumnsOfImages& columns) {
  const auto n = static_cast<double>(n_unknowns);
  double products = static_cast<double>(kMostOwn) * n * n;
  for (const auto& of_image : columns) products += static_cast<double>(of_image.size() * of_image.size());
  return 2.0 * products < static_cast<double>(columns.size()) * n * n;
}

}  // namespace

EquationSum::EquationSum(Eigen::Index n_unknowns, const ColumnsOfImages& columns)
    : columns_(columns),
      n_images_(static_cast<Eigen::Index>(columns.size())),
      by_images_(is_sparse(n_unknowns, columns)),
      rows_(kPixelsAtOnce * n_images_, n_unknowns),
      residual_(kPixelsAtOnce * n_images_),
      sum_{Eigen::MatrixXd::Zero(n_unknowns, n_unknowns), Eigen::VectorXd::Zero(n_unknowns), 0.0, 0, 0} {
  if (!by_images_) return;
  own_rows_.resize(kPixelsAtOnce * kMostOwn, n_unknowns);
  for (const auto& of_image : columns) {
    const auto n = static_cast<Eigen::Index>(of_image.size());
    of_image_.push_back(Eigen::MatrixXd::Zero(n, n));
  }
}

void EquationSum::take(const Eigen::MatrixXd& own, std::uint64_t n_values) {
  if (!by_images_) {
    take_off(own, rows());
  } else if (own.cols() > 0) {
    own_rows_.middleRows(own_filled_, own.cols()).noalias() = own.transpose() * rows();
    own_filled_ += own.cols();
  }
  sum_.n += n_values;
  filled_ += n_images_;
  if (filled_ == rows_.rows()) add();
}

void EquationSum::add() {
  if (filled_ == 0) return;  // Eigen divides by the length of a product
  const auto some = rows_.topRows(filled_).transpose();
  if (rows_.cols() > 0) {
    sum_.right += some * residual_.head(filled_);
    if (by_images_)
      add_by_images(filled_ / n_images_);
    else
      sum_.normal.selfadjointView<Eigen::Lower>().rankUpdate(some);
  }
  sum_.chi2 += residual_.head(filled_).squaredNorm();
  filled_ = own_filled_ = 0;
}

void EquationSum::add_by_images(Eigen::Index n_pixels) {
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const std::vector<Eigen::Index>& at = columns_[j];
    if (at.empty()) continue;
    const auto of_image = Eigen::seqN(static_cast<Eigen::Index>(j), n_pixels, n_images_);
    const Eigen::MatrixXd picked = rows_(of_image, at);
    of_image_[j].selfadjointView<Eigen::Lower>().rankUpdate(picked.transpose());
  }
  if (own_filled_ > 0)
    sum_.normal.selfadjointView<Eigen::Lower>().rankUpdate(own_rows_.topRows(own_filled_).transpose(), -1.0);
}

const NormalEquations& EquationSum::finish() {
  add();
  if (!by_images_) return sum_;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(sum_.right.size());  // of W
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    const std::vector<Eigen::Index>& at = columns_[j];  // in rising order
    for (std::size_t a = 0; a < at.size(); ++a) {
      const auto row = static_cast<Eigen::Index>(a);
      squares[at[a]] += of_image_[j](row, row);
      for (std::size_t b = 0; b <= a; ++b)
        sum_.normal(at[a], at[b]) += of_image_[j](row, static_cast<Eigen::Index>(b));
    }
    of_image_[j].setZero();
  }
  for (Eigen::Index i = 0; i < squares.size(); ++i) {
    if (!(sum_.normal(i, i) <= kRounding * squares[i])) continue;  // also what is no number
    sum_.normal.row(i).setZero(), sum_.normal.col(i).setZero();
    sum_.right[i] = 0.0;
  }
  return sum_;
}

}  // namespace fringetwin::compare
