// SPDX-License-Identifier: Apache-2.0
// Sums up the normal equations of many pixels, of which each has numbers of its own that are projected out.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "compare/causes/sensitivity.hpp"

namespace fringetwin::compare {

/// Which unknowns change the values of each image at all.
using ColumnsOfImages = std::vector<std::vector<Eigen::Index>>;

/// Takes off a pixel's rows what it has of its own, an orthonormal basis.
inline void take_off(const Eigen::MatrixXd& own, Eigen::Ref<Eigen::MatrixXd> rows) {
  if (own.cols() > 0) rows -= own * (own.transpose() * rows);
}

/// Sums up J^T J and J^T r of the rows J = (1 - Q Q^T) W of pixels, Q an orthonormal basis of what a pixel
/// has of its own. As W^T W - (Q^T W)^T (Q^T W), where unknowns that change single images make W so sparse
/// that this takes less than half of the time: what is left of an unknown by rounding alone is 0 then.
class EquationSum {
 public:
  /// `columns`: of each image of a pixel, in the order of its rows.
  EquationSum(Eigen::Index n_unknowns, const ColumnsOfImages& columns);
  /// Where the rows W of the next pixel and the residuals r, from which Q is projected out already, are
  /// written.
  Eigen::Block<Eigen::MatrixXd> rows() { return rows_.middleRows(filled_, n_images_); }
  Eigen::VectorBlock<Eigen::VectorXd> residual() { return residual_.segment(filled_, n_images_); }
  /// Takes what was written, of so many values.
  void take(const Eigen::MatrixXd& own, std::uint64_t n_values);
  /// Returns the sums; of the matrix the lower half.
  const NormalEquations& finish();

 private:
  void add();
  void add_by_images(Eigen::Index n_pixels);

  const ColumnsOfImages& columns_;
  const Eigen::Index n_images_;
  bool by_images_ = false;
  Eigen::MatrixXd rows_, own_rows_;  ///< of several pixels: one product for all
  Eigen::VectorXd residual_;
  std::vector<Eigen::MatrixXd> of_image_;  ///< W^T W of the columns of each image
  Eigen::Index filled_ = 0, own_filled_ = 0;
  NormalEquations sum_;
};

}  // namespace fringetwin::compare
