// SPDX-License-Identifier: Apache-2.0
#include "twin/base/module_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "twin/base/sha256.hpp"

namespace fringetwin::module_loader_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::string kBuild = sha256_of_text("/home/me/build");

TEST(ModuleLoader, LooksBesideTheProgramAndInItsInstallation) {
  EXPECT_THAT(module_folders("/usr/bin/fringetwin", kBuild),
              ElementsAre("/usr/bin", "/usr/lib/fringetwin/modules"));
  EXPECT_THAT(module_folders("/opt/fringetwin", kBuild), ElementsAre("/opt"));
  EXPECT_THAT(module_folders("", kBuild), IsEmpty());
  EXPECT_THAT(module_folders("/opt/fringetwin", ""), ElementsAre("/opt")) << "not the system's folders";
}

TEST(ModuleLoader, LooksIntoTheBuildTreeOnlyFromWithin) {
  EXPECT_THAT(module_folders("/home/me/build/fringetwin", kBuild), ElementsAre("/home/me/build"));
  EXPECT_THAT(module_folders("/home/me/build/tests/twin_tests", kBuild),
              ElementsAre("/home/me/build/tests", "/home/me/build"));
  EXPECT_THAT(module_folders("/home/me/build-dev/fringetwin", kBuild), ElementsAre("/home/me/build-dev"));
}

TEST(ModuleLoader, KnowsItsBuildTreeOnlyFromWithin) {
  EXPECT_EQ(build_tree_of("/home/me/build/fringetwin", kBuild), "/home/me/build");
  EXPECT_EQ(build_tree_of("/home/me/build/tests/twin_tests", kBuild), "/home/me/build");
  EXPECT_EQ(build_tree_of("/home/me/moved/fringetwin", kBuild), "");
  EXPECT_EQ(build_tree_of("", kBuild), "");
}

TEST(ModuleLoader, SaysWhatIsMissing) {
  try {
    find_in_module("libfringetwin_none.so", "none", {ExitCode::usage, "window", "shows it", "install it"});
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::usage);
    EXPECT_THAT(e.what(), ::testing::StartsWith("window: the module that shows it cannot be loaded (/"));
  }
}

// A module of another version has its function under another name.
TEST(ModuleLoader, AModuleWithoutTheFunctionIsRefused) {
  try {
    find_in_module("libfringetwin_image_codecs.so", "fringetwin_decode_image_0",
                   {ExitCode::device, "images", "reads them", "build it anew"});
    FAIL();
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::device);
    EXPECT_THAT(e.what(), ::testing::StartsWith("images: the module that reads them cannot be loaded (/"));
    EXPECT_THAT(e.what(), ::testing::HasSubstr("undefined symbol: fringetwin_decode_image_0"));
    EXPECT_THAT(e.what(), ::testing::EndsWith("build it anew"));
  }
}

}  // namespace
}  // namespace fringetwin::module_loader_test
