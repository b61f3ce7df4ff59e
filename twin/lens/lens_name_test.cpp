// SPDX-License-Identifier: Apache-2.0
// Names that libmrcal aborts on, misreads or multiplies beyond an int. No tolerances: sentences are compared.
#include "twin/lens/lens_name.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/base/errors.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/mrcal_facade.hpp"

namespace fringetwin::lens_name_test {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::string& name, std::size_t n_intrinsics = 8) {
  EXPECT_FALSE(MrcalModel::from_name(name)) << name;
  std::vector<double> intrinsics(n_intrinsics, 0.0);
  intrinsics[0] = intrinsics[1] = 1000.0;
  try {
    const Lens lens(name, intrinsics, {640, 480}, "a.cameramodel");
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_LT(std::string(e.what()).size(), 501u);
    EXPECT_THAT(e.what(), HasSubstr("a.cameramodel: "));
    return e.what();
  }
  ADD_FAILURE() << "accepted: " << name;
  return "";
}

std::string splined(const std::string& configuration, std::size_t n_intrinsics = 8) {
  return refusal("LENSMODEL_SPLINED_STEREOGRAPHIC" + configuration, n_intrinsics);
}

TEST(LensName, SplinesAreCheckedBeforeLibmrcalSeesThem) {
  EXPECT_THAT(splined("_order=7_Nx=11_Ny=8_fov_x_deg=44", 180), HasSubstr("order must be 2 or 3, is 7"));
  EXPECT_THAT(splined("_order=0_Nx=11_Ny=8_fov_x_deg=44", 180), HasSubstr("order must be 2 or 3, is 0"));
  EXPECT_THAT(splined("_order=3_Nx=3_Ny=8_fov_x_deg=44", 52), HasSubstr("4 to 65535, are 3 and 8"));
  EXPECT_THAT(splined("_order=2_Nx=9_Ny=2_fov_x_deg=44", 40), HasSubstr("3 to 65535, are 9 and 2"));
  EXPECT_THAT(splined("_order=3_Nx=0_Ny=0_fov_x_deg=44", 4), HasSubstr("4 to 65535, are 0 and 0"));
  EXPECT_THAT(splined("_order=3_Nx=11_Ny=8_fov_x_deg=0", 180), HasSubstr("fov_x_deg must be 1 to 359, is 0"));
  EXPECT_THAT(splined("_order=3_Nx=11_Ny=8_fov_x_deg=400", 180), HasSubstr("fov_x_deg must be 1 to 359"));
}

TEST(LensName, NumbersOfKnotsNeitherOverflowNorWrap) {
  EXPECT_THAT(splined("_order=3_Nx=33025_Ny=65026_fov_x_deg=44"),  // 2 Nx Ny + 4 = 8 in 32 bits
              HasSubstr("Nx times Ny must be at most 500000, they are 33025 and 65026"));
  EXPECT_THAT(splined("_order=3_Nx=65540_Ny=4_fov_x_deg=44", 36),
              HasSubstr("are 65540 and 4"));  // 4 in 16 bits
  EXPECT_THAT(splined("_order=3_Nx=-65525_Ny=8_fov_x_deg=44", 180), HasSubstr("are -65525 and 8"));
  EXPECT_THAT(splined("_order=65539_Nx=11_Ny=8_fov_x_deg=44", 180), HasSubstr("order must be 2 or 3"));
  EXPECT_THAT(splined("_order=3_Nx=11_Ny=8_fov_x_deg=65580", 180), HasSubstr("fov_x_deg must be"));
  EXPECT_THAT(splined("_order=3_Nx=99999999999_Ny=8_fov_x_deg=44"), HasSubstr("in whole numbers"));
}

TEST(LensName, OnlyTheFormIsTaken) {
  for (const char* configuration :
       {"_", "_order=3", "_order=3_Nx=11_Ny=8_fov_x_deg=44 ", "_order= 3_Nx=11_Ny=8_fov_x_deg=44",
        "_order=+3_Nx=11_Ny=8_fov_x_deg=44", "_order=3_Nx=11_Ny=8_fov_x_deg=44_", "_order=..._Nx=11"})
    EXPECT_THAT(splined(configuration), HasSubstr("its name must end like")) << configuration;
  EXPECT_THAT(splined(""), HasSubstr("unknown lens model"));
  EXPECT_THAT(refusal("LENSMODEL_SPLINED_STEREOGRAPHICX"), HasSubstr("unknown lens model"));
  EXPECT_THAT(refusal(std::string("LENSMODEL_OPENCV4\0x", 19)), HasSubstr("a byte of zero"));
  EXPECT_THAT(refusal(std::string(1'000'000, 'A')), HasSubstr("AAA..."));
}

TEST(LensName, Cahvore) {
  for (const char* value : {"nan", "inf", "1e300", "-1.5"})
    EXPECT_THAT(refusal(std::string("LENSMODEL_CAHVORE_linearity=") + value, 12),
                HasSubstr("linearity must be -1 to 1"));
  for (const char* value : {"", "0x1p0", " 0.3", "0,3", "0.3_x=1", "1e999"})
    EXPECT_THAT(refusal(std::string("LENSMODEL_CAHVORE_linearity=") + value, 12),
                HasSubstr("its name must end like"))
        << value;
}

TEST(LensName, TheSmallestAndTheLargestSplineAreTaken) {
  const auto count = [](const char* name) { return MrcalModel::from_name(name).value().intrinsics_count(); };
  EXPECT_EQ(count("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=4_Ny=4_fov_x_deg=44"), 36);
  EXPECT_EQ(count("LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=3_Ny=3_fov_x_deg=44"), 22);
  EXPECT_EQ(count("LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=1000_Ny=500_fov_x_deg=359"), 1000004);
  EXPECT_EQ(count("LENSMODEL_CAHVORE_linearity=-1"), 12);
  for (const int order : {2, 3}) {  // projects, with as few knots as there can be
    const int n = order + 1;
    std::vector<double> intrinsics(4 + 2 * n * n, 0.0);
    intrinsics[0] = intrinsics[1] = 1000.0;
    const Lens lens("LENSMODEL_SPLINED_STEREOGRAPHIC_order=" + std::to_string(order) +
                        "_Nx=" + std::to_string(n) + "_Ny=" + std::to_string(n) + "_fov_x_deg=90",
                    intrinsics, {64, 48}, "test");
    EXPECT_TRUE(lens.project({0.01, 0.02, 1.0}));
  }
}

/// libmrcal's own inversion never ends on the second of these pixels.
TEST(LensName, PixelsFarOutsideEndToo) {
  std::vector<double> intrinsics(34, 0.0);
  intrinsics[0] = intrinsics[1] = 1.273;
  intrinsics[2] = 320.0;
  intrinsics[3] = 240.0;
  const Lens lens("LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=3_Ny=5_fov_x_deg=359", intrinsics, {640, 480},
                  "test");
  EXPECT_FALSE(lens.unproject({1e9, -1e9}));
  EXPECT_FALSE(lens.unproject({1e9, 0.002}));
}

}  // namespace
}  // namespace fringetwin::lens_name_test
