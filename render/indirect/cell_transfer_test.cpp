// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/cell_transfer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace fringetwin::render {
namespace {

/// A closed cavity of n cells that see each other alike, with reflectivities `rho`.
CellTransfer cavity(const std::vector<float>& rho) {
  CellTransfer transfer;
  for (std::size_t i = 0; i < rho.size(); ++i) {
    std::vector<CellTransfer::Share> row;
    for (int half = 0; half < 2; ++half)  // each cell twice: they are added up
      for (std::size_t k = 0; k < rho.size(); ++k)
        row.push_back({static_cast<std::int32_t>(k), 0.5F * rho[k] / static_cast<float>(rho.size())});
    transfer.add_row(row);
  }
  return transfer;
}

TEST(CellTransfer, OfACavityIsTheGeometricSeries) {
  const CellTransfer transfer = cavity({0.8F, 0.8F, 0.8F});
  // light 1 on one cell: the mean is 1/3; what comes on top is 1/3 (0.8 + 0.64 + ...) everywhere
  const std::vector<float> b{1.0F, 0.0F, 0.0F};
  const double after[] = {0.0, 0.8 / 3, 1.44 / 3, 1.952 / 3};
  for (int times = 0; times < 4; ++times) {
    const std::vector<float> x = transfer.spread(b, 1, times);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(x[i], b[i] + after[times], 1e-6);
  }
  const std::vector<float> all = transfer.spread(b, 1, std::nullopt);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(all[i], b[i] + 4.0 / 3, 2e-5);  // what is cut off: 5e-6/0.2
}

TEST(CellTransfer, SolvesTheLinearSystemOfEachChannel) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  constexpr int kN = 40, kChannels = 3;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(kN, kN);
  CellTransfer transfer;
  for (int i = 0; i < kN; ++i) {
    std::vector<CellTransfer::Share> row;
    for (int k = 0; k < 6; ++k) {
      const CellTransfer::Share s{static_cast<std::int32_t>(random() % kN),
                                  0.14F * std::abs(uniform(random))};
      row.push_back(s);
      T(i, s.cell) += static_cast<double>(s.share);
    }
    transfer.add_row(row);
  }
  std::vector<float> b(kN * kChannels);
  for (float& v : b) v = uniform(random);
  const std::vector<float> x = transfer.spread(b, kChannels, std::nullopt);
  for (int c = 0; c < kChannels; ++c) {
    Eigen::VectorXd right(kN);
    for (int i = 0; i < kN; ++i) right[i] = static_cast<double>(b[i * kChannels + c]);
    const Eigen::VectorXd truth = (Eigen::MatrixXd::Identity(kN, kN) - T).lu().solve(right);
    for (int i = 0; i < kN; ++i) EXPECT_NEAR(x[i * kChannels + c], truth[i], 1e-5);
  }
}

}  // namespace
}  // namespace fringetwin::render
