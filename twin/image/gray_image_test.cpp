// SPDX-License-Identifier: Apache-2.0
#include "twin/image/gray_image.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fringetwin {
namespace {

ImageF image_of(const std::vector<float>& values) {
  ImageF image(static_cast<int>(values.size()), 1);
  image.data = values;
  return image;
}

// Whatever they are kept as, the values are the same when they are read in any of the ways.
void expect_same(const GrayImage& packed, const std::vector<float>& values) {
  std::vector<float> room, seen;
  const std::span<const float> all = packed.values(0, values.size(), room);
  packed.for_each([&](float value) { seen.push_back(value); });
  const ImageF floats = packed.floats();
  for (std::size_t i = 0; i < values.size(); ++i) {
    for (const float read : {packed[i], packed(static_cast<int>(i), 0), all[i], seen[i], floats.data[i]})
      EXPECT_TRUE(read == values[i] || (std::isnan(read) && std::isnan(values[i]))) << i;
  }
}

TEST(GrayImage, KeepsWholeNumbersInAsFewBytesAsHoldThem) {
  const std::vector<float> eight{0, 1, 254, 255}, sixteen{0, 256, 65535, 3};
  const GrayImage bytes = GrayImage::packed(image_of(eight)), words = GrayImage::packed(image_of(sixteen));
  EXPECT_EQ(bytes.bytes(), 4U);
  EXPECT_EQ(words.bytes(), 8U);
  expect_same(bytes, eight);
  expect_same(words, sixteen);
}

TEST(GrayImage, KeepsAllOthersAsFloats) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  for (const float other : {0.5F, -1.0F, 65536.0F, 1e20F, -1e20F, nan, inf, -inf, 254.99998F}) {
    std::vector<float> values(5000, 7.0F);  // the last of several stretches
    values.back() = other;
    const GrayImage image = GrayImage::packed(image_of(values));
    EXPECT_EQ(image.bytes(), 4 * values.size()) << other;
    expect_same(image, values);
  }
}

TEST(GrayImage, ReadsAPart) {
  const GrayImage image = GrayImage::packed(image_of({5, 6, 7, 8}));
  std::vector<float> room;
  const std::span<const float> part = image.values(1, 2, room);
  ASSERT_EQ(part.size(), 2U);
  EXPECT_EQ(part[0], 6.0F);
  EXPECT_EQ(part[1], 7.0F);
}

TEST(GrayImage, IsWrittenAsFloats) {
  GrayImage image = GrayImage::packed(image_of({5, 6}));
  image.as_floats()[1] = 6.25F;
  EXPECT_EQ(image[0], 5.0F);
  EXPECT_EQ(image[1], 6.25F);
  EXPECT_EQ(image.bytes(), 8U);
}

// (constant + of_mean mean + of_cosine cosine - of_sine sine + more_constant constant) factor, in single
// precision.
TEST(GrayImage, OfASumIsComputedWhereItIsRead) {
  const std::vector<float> constant{0.5F, 0.25F, 0.0F}, mean{3.0F, 5.5F, 0.0F}, cosine{0.1F, -0.7F, 0.0F},
      sine{-0.3F, 0.9F, 0.0F}, factor{0.75F, 0.3F, 2.0F};
  ImageSum sum{.constant = constant.data(),
               .mean = mean.data(),
               .cosine = cosine.data(),
               .sine = sine.data(),
               .of_mean = 1.5F,
               .of_cosine = 0.7F,
               .of_sine = 0.2F};
  std::vector<float> plain, lit, dimmed;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    plain.push_back(constant[i] + 1.5F * mean[i] + 0.7F * cosine[i] - 0.2F * sine[i]);
    lit.push_back(plain[i] + 0.1F * constant[i]);
    dimmed.push_back(lit[i] * factor[i]);
  }
  expect_same(GrayImage::sum(sum, 3, 1), plain);
  sum.more_constant = 0.1F;
  expect_same(GrayImage::sum(sum, 3, 1), lit);
  sum.factor = factor.data();
  GrayImage image = GrayImage::sum(sum, 3, 1);
  EXPECT_EQ(image.bytes(), 0U);
  expect_same(image, dimmed);
  std::vector<float> room;
  EXPECT_EQ(image.values(1, 1, room)[0], dimmed[1]);
  image.writable(0, 0) = 7.0F;
  EXPECT_EQ(image[0], 7.0F);
  EXPECT_EQ(image[1], dimmed[1]);
}

TEST(GrayImage, OfNothingIsEmpty) {
  EXPECT_TRUE(GrayImage().empty());
  EXPECT_TRUE(GrayImage::packed(ImageF()).empty());
  EXPECT_EQ(GrayImage::packed(ImageF()).floats().size(), 0U);
}

}  // namespace
}  // namespace fringetwin
