// SPDX-License-Identifier: Apache-2.0
// Truth: the .npy that numpy 1.24 writes for the same numbers, 140 bytes with the CRC-32 0x35ab081c, and the
// records of ZIP (APPNOTE.TXT 6.3). That numpy reads whole files: tests/e2e/python_test.py.
#include "twin/image/npz_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

namespace fringetwin::npz_file_test {
namespace {

class NpzFile : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(file_); }
  std::string written(const std::vector<NpzArray>& arrays) const {
    write_npz(file_, arrays);
    std::ifstream in(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("fringetwin_npz_" + std::to_string(::getpid()) + ".npz");
};

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T number{};
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

constexpr std::size_t kBefore = 30 + 5 + 20;  ///< record before a file: fixed part, "a.npy", 64-bit field
constexpr std::size_t kInList = 46 + 5 + 28;  ///< its record in the list
constexpr std::size_t kEnd = 56 + 20 + 22;    ///< records at the end: 64-bit end, where it is, end

TEST_F(NpzFile, HoldsTheNpyThatNumpyWrites) {
  ImageF image(3, 1);
  image.data = {1.0F, 2.0F, 3.0F};
  const std::string bytes = written({npz_array("a", image)});
  ASSERT_EQ(bytes.size(), kBefore + 140 + kInList + kEnd);
  EXPECT_EQ(bytes.substr(kBefore, 8), std::string("\x93NUMPY\x01\x00", 8));
  EXPECT_EQ(bytes.substr(kBefore + 10, 59), "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3), }");
  EXPECT_EQ(number_at<float>(bytes, kBefore + 128 + 8), 3.0F);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, 14), 0x35ab081cU);
  EXPECT_EQ(number_at<std::uint64_t>(bytes, kBefore - 8), 140U);
}

// A reader begins at the end: there it finds the list, and in the list where each array begins.
TEST_F(NpzFile, ListsEveryArrayByItsPlace) {
  const std::array<double, 2> numbers{0.5, -1.0};
  const std::string bytes =
      written({npz_array<double>("a", {2}, numbers), npz_array<double>("b", {0, 3}, {})});
  ASSERT_GT(bytes.size(), kEnd);
  const std::size_t end64 = bytes.size() - kEnd;
  EXPECT_EQ(number_at<std::uint32_t>(bytes, end64), 0x06064b50U);
  EXPECT_EQ(number_at<std::uint64_t>(bytes, end64 + 32), 2U);  // arrays
  EXPECT_EQ(number_at<std::uint64_t>(bytes, end64 + 56 + 8), end64);
  const auto list = number_at<std::uint64_t>(bytes, end64 + 48);
  EXPECT_EQ(list + number_at<std::uint64_t>(bytes, end64 + 40), end64);
  const auto second = number_at<std::uint64_t>(bytes, list + kInList + kInList - 8);
  EXPECT_EQ(second, kBefore + 128 + sizeof numbers);
  EXPECT_EQ(number_at<std::uint32_t>(bytes, second), 0x04034b50U);
  EXPECT_EQ(bytes.substr(second + 30, 5), "b.npy");
  EXPECT_NE(bytes.find("'shape': (2,)"), std::string::npos);
  EXPECT_NE(bytes.find("'shape': (0, 3)"), std::string::npos);
}

// Neither has a time in it.
TEST_F(NpzFile, EqualArraysMakeEqualFiles) {
  const std::array<unsigned char, 3> flags{0, 1, 4};
  const auto once = written({npz_array<unsigned char>("flags", {3}, flags)});
  EXPECT_EQ(once, written({npz_array<unsigned char>("flags", {3}, flags)}));
  EXPECT_NE(once.find("'|u1'"), std::string::npos);
}

}  // namespace
}  // namespace fringetwin::npz_file_test
