// SPDX-License-Identifier: Apache-2.0
#include "twin/base/seal.hpp"

#include <gtest/gtest.h>

namespace fringetwin::testing::seal_test {
namespace {

TEST(Seal, EveryChangeBreaksIt) {
  const std::string sealed = seal("a = 1\nb = 2\n");
  EXPECT_EQ(check_seal(sealed), Seal::intact);
  for (std::size_t i = 0; i < sealed.size(); ++i) {
    std::string changed = sealed;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    EXPECT_NE(check_seal(changed), Seal::intact) << i;
    EXPECT_NE(check_seal(sealed.substr(0, i)), Seal::intact) << i;
  }
  EXPECT_EQ(check_seal("a = 1\n"), Seal::none);
  EXPECT_EQ(check_seal(""), Seal::none);
  EXPECT_EQ(check_seal(seal("")), Seal::intact);
}

TEST(Seal, TheRightLineMends) {
  std::string changed = seal("a = 1\n");
  changed += "b = 3\n";
  EXPECT_EQ(check_seal(changed), Seal::broken);
  EXPECT_EQ(check_seal(right_seal(changed) + "\na = 1\nb = 3\n"), Seal::intact);
  EXPECT_EQ(check_seal(right_seal("a = 1\n") + "\na = 1\n"), Seal::intact);
}

}  // namespace
}  // namespace fringetwin::testing::seal_test
