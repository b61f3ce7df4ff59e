// SPDX-License-Identifier: Apache-2.0
// tolerance  unit  origin
// exact      bits  shortest round-trip decimals: every double comes back as it was
#include "twin/file/cameramodel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "tests/support/twin/child_process.hpp"
#include "tests/support/twin/random_values.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::cameramodel_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::ScratchFolder;

std::vector<std::uint64_t> bits(const CameraModelFile& model) {
  std::vector<std::uint64_t> all;
  for (const double x : model.intrinsics) all.push_back(std::bit_cast<std::uint64_t>(x));
  for (const double x : model.rt_cam_ref) all.push_back(std::bit_cast<std::uint64_t>(x));
  return all;
}

CameraModelFile paper_projector() {
  CameraModelFile model;
  model.lensmodel = "LENSMODEL_OPENCV4";
  model.intrinsics = {1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001};
  model.rt_cam_ref = {-0.0099, 0.3754, 0.0276, -0.0945914, -0.0001889, 0.0124706};
  model.imagersize = {1280, 720};
  return model;
}

/// Values no decimal of 6 or 10 digits can hold.
CameraModelFile awkward_model() {
  CameraModelFile model = paper_projector();
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& x : model.intrinsics) x *= 1.0 + 1e-3 * uniform(random);
  for (double& x : model.rt_cam_ref) x *= 1.0 + 1e-3 * uniform(random);
  model.intrinsics[2] = 1700.0;  // a whole number must stay a float for Python
  model.rt_cam_ref[5] = 1.0 / 3.0;
  return model;
}

std::string refusal(const std::string& text) {
  const ScratchFolder scratch;
  const auto file = scratch.write("bad.cameramodel", text);
  try {
    read_cameramodel(file);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr(file.string()));
    return e.what();
  }
  ADD_FAILURE() << "accepted: " << text;
  return "";
}

const std::string good_body =
    "'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [1,2,3,4], 'extrinsics': [0,0,0,0,0,0], "
    "'imagersize': [640,480]";

TEST(CameraModel, ReadsWhatMrcalWrites) {
  const ScratchFolder scratch;
  const auto file =
      scratch.write("camera.cameramodel",
                    "# generated on 2026-01-01 with mrcal-calibrate-cameras\n"
                    "#  second line\n"
                    "\n"
                    "{\n"
                    "    'lensmodel':  'LENSMODEL_OPENCV4',\n"
                    "\n"
                    "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n"
                    "    'intrinsics': [ 1700.0125993332135, 1701., .5e3, +406.54, # here, too\n"
                    "                    0.1328, -3.361e-1, -0.0006, -1E-4,],\n"
                    "    \"valid_intrinsics_region\": [\n"
                    "      [ 0, 0 ], # a contour\n"
                    "      (10, 20),\n"
                    "    ],\n"
                    "    'extrinsics': ( -0.0099, 0.3754, 0.0276, -0.0945914, 0, 0.0124706,),\n"
                    "    'imagersize': [ 1280, 720,],\n"
                    "    'icam_intrinsics': 2,\n"
                    "    'optimization_inputs': b'P)h>@6aWAK2mk;8{}#[',\n"
                    "}\n");
  const CameraModelFile model = read_cameramodel(file);
  EXPECT_EQ(model.lensmodel, "LENSMODEL_OPENCV4");
  EXPECT_THAT(model.intrinsics,
              ElementsAre(1700.0125993332135, 1701.0, 500.0, 406.54, 0.1328, -0.3361, -0.0006, -0.0001));
  EXPECT_THAT(model.rt_cam_ref, ElementsAre(-0.0099, 0.3754, 0.0276, -0.0945914, 0.0, 0.0124706));
  EXPECT_THAT(model.imagersize, ElementsAre(1280, 720));
  EXPECT_THAT(model.comments,
              ElementsAre(" generated on 2026-01-01 with mrcal-calibrate-cameras", "  second line"));
  EXPECT_EQ(model.extra,
            "'valid_intrinsics_region': [\n      [ 0, 0 ], # a contour\n      (10, 20),\n    ],\n"
            "'icam_intrinsics': 2,\n"
            "'optimization_inputs': b'P)h>@6aWAK2mk;8{}#[',\n");
}

TEST(CameraModel, KeepsCommentsAndUnknownKeysOnRewrite) {
  const ScratchFolder scratch;
  CameraModelFile model = awkward_model();
  model.comments = {" first", "", "\tthird"};
  model.extra = "'icam_intrinsics': 2,\n'optimization_inputs': b'a\"b{c\\'d',\n'none': None,\n";
  write_cameramodel(scratch / "a.cameramodel", model);
  const CameraModelFile back = read_cameramodel(scratch / "a.cameramodel");
  EXPECT_EQ(back.comments, model.comments);
  EXPECT_EQ(back.extra, model.extra);
  write_cameramodel(scratch / "b.cameramodel", back);
  EXPECT_EQ(testing::read_file(scratch / "a.cameramodel"), testing::read_file(scratch / "b.cameramodel"));
}

TEST(CameraModel, ExtremeNumbersKeepTheirBits) {
  using limits = std::numeric_limits<double>;
  const ScratchFolder scratch;
  CameraModelFile model = paper_projector();
  model.intrinsics = {limits::max(), limits::min(), limits::denorm_min(), -0.0, 1e22, 1e23,
                      0.1,           -1.0 / 3.0,    123456789012345680.0, 5.0};
  write_cameramodel(scratch / "m.cameramodel", model);
  EXPECT_EQ(bits(read_cameramodel(scratch / "m.cameramodel")), bits(model));
}

RC_GTEST_PROP(CameraModelProperty, AnyFiniteDoubleKeepsItsBits, ()) {
  static const ScratchFolder scratch;
  CameraModelFile model = paper_projector();
  for (double& x : model.intrinsics) {
    x = std::bit_cast<double>(*rc::gen::resize(100, rc::gen::arbitrary<std::uint64_t>()));
    if (!std::isfinite(x)) x = 1.0;
  }
  write_cameramodel(scratch / "m.cameramodel", model);
  RC_ASSERT(bits(read_cameramodel(scratch / "m.cameramodel")) == bits(model));
}

TEST(CameraModel, ReadsTheNewNameOfTheExtrinsics) {
  const ScratchFolder scratch;
  const std::string start =
      "{'lensmodel': 'LENSMODEL_PINHOLE', 'intrinsics': [1,2,3,4], 'imagersize': [640,480], ";
  const auto both =
      scratch.write("both", start + "'rt_cam_ref': [1,2,3,4,5,6], 'extrinsics': [1,2,3,4,5,6]}");
  EXPECT_EQ(read_cameramodel(both).rt_cam_ref[5], 6.0);
  EXPECT_EQ(read_cameramodel(both).extra, "");
  const auto only = scratch.write("only", start + "'rt_cam_ref': [1,2,3,4,5,6]}");
  EXPECT_EQ(read_cameramodel(only).rt_cam_ref[0], 1.0);
  EXPECT_THAT(refusal(start + "'rt_cam_ref': [1,2,3,4,5,6], 'extrinsics': [1,2,3,4,5,7]}"),
              HasSubstr("differ"));
}

TEST(CameraModel, RefusesBadFilesWithTheLine) {
  EXPECT_THAT(refusal(""), HasSubstr(":1: the file ends"));
  EXPECT_THAT(refusal("# only a comment\n"), HasSubstr("the file ends"));
  EXPECT_THAT(refusal("%YAML:1.0\n---\n"), HasSubstr(":1: expected '{', found '%'"));
  EXPECT_THAT(refusal("{" + good_body), HasSubstr("the file ends where ',' is due"));
  EXPECT_THAT(refusal("{" + good_body + "}\nx"), HasSubstr(":2: unexpected text after the closing '}'"));
  EXPECT_THAT(refusal("{\n'lensmodel': 'LENSMODEL_PINHOLE'\n'intrinsics': [1]}"),
              HasSubstr(":3: expected ',', found '''"));
  EXPECT_THAT(refusal("{\n'lensmodel': 'LENSMODEL_PINHO"), HasSubstr(":2: a string does not end"));
  EXPECT_THAT(refusal("{'lensmodel': 'LENSMODEL_PINHOLE'}"), HasSubstr("lacks the key 'intrinsics'"));
  EXPECT_THAT(refusal("{" + good_body + ",\n'imagersize': [1,2]}"),
              HasSubstr(":2: the key 'imagersize' is given twice"));
  EXPECT_THAT(refusal("{'x': " + std::string(100000, '[')), HasSubstr("nested too deeply"));
}

TEST(CameraModel, WhatIsRewrittenCanBeReadAgain) {
  const ScratchFolder scratch;
  const auto file = scratch.write("a.cameramodel", "{" + good_body + ", \"it's\": 1, 'it\\'s not': 2}");
  CameraModelFile model = read_cameramodel(file);
  EXPECT_EQ(model.extra, "\"it's\": 1,\n\"it\\'s not\": 2,\n");
  model.comments = {" imported from a\n{.cameramodel"};
  write_cameramodel(file, model);
  EXPECT_EQ(read_cameramodel(file).extra, model.extra);
}

TEST(CameraModel, RefusesFloodsQuickly) {
  std::string keys;
  for (int i = 0; i < 100000; ++i) keys += "'k" + std::to_string(i) + "': 0,\n";
  EXPECT_THAT(refusal("{" + keys + good_body + "}"), HasSubstr(":1001: the dict has more than 1000 keys"));
  std::string comments;
  for (int i = 0; i < 20000; ++i) comments += "#\n";
  EXPECT_THAT(refusal(comments + "{" + good_body + "}"), HasSubstr("more than 10000 lines of comment"));
  const std::string long_key(100000, 'k');
  EXPECT_LT(refusal("{'" + long_key + "': 1, '" + long_key + "': 2}").size(), 500u);
  EXPECT_LT(refusal("{'intrinsics': [" + long_key + "], 'lensmodel': ''}").size(), 500u);
}

TEST(CameraModel, RefusesBadValues) {
  const auto with = [](const std::string& key, const std::string& value) {
    std::string text = "{";
    for (const auto& [k, v] :
         std::initializer_list<std::pair<std::string, std::string>>{{"lensmodel", "'LENSMODEL_PINHOLE'"},
                                                                    {"intrinsics", "[1,2,3,4]"},
                                                                    {"extrinsics", "[0,0,0,0,0,0]"},
                                                                    {"imagersize", "[640,480]"}})
      text += "\n'" + k + "': " + (k == key ? value : v) + ",";
    return refusal(text + "}");
  };
  EXPECT_THAT(with("lensmodel", "5"), HasSubstr(":2: 'lensmodel' must be a plain quoted string"));
  EXPECT_THAT(with("intrinsics", "[1,2,nan,4]"),
              HasSubstr(":3: 'intrinsics' must be a list of finite numbers, 'nan'"));
  EXPECT_THAT(with("intrinsics", "[1,2,1e999,4]"), HasSubstr("'1e999' is none"));
  EXPECT_THAT(with("intrinsics", "[1,2,3.4.5,4]"), HasSubstr("'3.4.5' is none"));
  EXPECT_THAT(with("intrinsics", "[1,2,[3],4]"), HasSubstr("'[3]' is none"));
  EXPECT_THAT(with("intrinsics", "[1,,2]"), HasSubstr("unexpected ','"));
  EXPECT_THAT(with("intrinsics", "[1 2]"), HasSubstr("expected ',', found '2'"));
  EXPECT_THAT(with("extrinsics", "[0,0,0,0,0]"), HasSubstr(":4: 'extrinsics' takes 6 numbers, 5 given"));
  EXPECT_THAT(with("imagersize", "[640]"), HasSubstr(":5: 'imagersize' takes two positive whole numbers"));
  EXPECT_THAT(with("imagersize", "[640.5, 480]"), HasSubstr("two positive whole numbers"));
  EXPECT_THAT(with("imagersize", "[-640, 480]"), HasSubstr("two positive whole numbers"));
}

TEST(CameraModel, NamesAMissingFile) {
  try {
    read_cameramodel("/nonexistent/left.cameramodel");
    FAIL();
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr("/nonexistent/left.cameramodel: the camera model cannot be read"));
  }
  EXPECT_THROW(read_cameramodel("/tmp"), UserError);
  EXPECT_THROW(read_cameramodel("/dev/zero"), UserError);
}

// ------------------------------------------------------------ mrcal's own tools

/// The numbers of a file as mrcal's Python reads them, in C's exact hexadecimal form.
std::string numbers_by_mrcal(const std::filesystem::path& file) {
  const auto result = testing::run(
      "/usr/bin/python3 -c \"import mrcal,sys; m = mrcal.cameramodel(sys.argv[1]); "
      "name, i = m.intrinsics(); print(name, *[float(x).hex() for x in i], "
      "*[float(x).hex() for x in m.extrinsics_rt_fromref()], *[int(x) for x in m.imagersize()])\" " +
      file.string() + " 2>&1");
  EXPECT_EQ(result.status, 0) << result.output;
  return result.output;
}

std::string numbers_by_us(const CameraModelFile& model) {
  std::string text = model.lensmodel;
  const auto append = [&](double x) {
    // Python prints 0x1.8p+3 where C's %a prints the same for normal numbers, with 13 digits
    const int exponent = std::ilogb(x);
    char buffer[64];
    const auto mantissa = std::bit_cast<std::uint64_t>(x) & 0xfffffffffffffULL;
    std::snprintf(buffer, sizeof buffer, " %s0x1.%013llxp%+d", x < 0 ? "-" : "",
                  static_cast<unsigned long long>(mantissa), exponent);
    text += buffer;
  };
  for (const double x : model.intrinsics) append(x);
  for (const double x : model.rt_cam_ref) append(x);
  return text + " " + std::to_string(model.imagersize[0]) + " " + std::to_string(model.imagersize[1]) + "\n";
}

TEST(CameraModelInterop, MrcalReadsOurFilesBitExactly) {
  if (!testing::has_mrcal_python()) GTEST_SKIP() << "SKIPPED: no mrcal module for /usr/bin/python3";
  const ScratchFolder scratch;
  write_cameramodel(scratch / "m.cameramodel", awkward_model());
  EXPECT_EQ(numbers_by_mrcal(scratch / "m.cameramodel"), numbers_by_us(awkward_model()));
}

TEST(CameraModelInterop, WeReadMrcalsFilesAsMrcalDoes) {
  if (!testing::has_mrcal_python()) GTEST_SKIP() << "SKIPPED: no mrcal module for /usr/bin/python3";
  const ScratchFolder scratch;
  write_cameramodel(scratch / "ours.cameramodel", awkward_model());
  const auto rewritten = scratch / "mrcals.cameramodel";
  const auto result = testing::run(
      "/usr/bin/python3 -c \"import mrcal,sys; mrcal.cameramodel(sys.argv[1]).write(sys.argv[2], note='by "
      "mrcal')\" " +
      (scratch / "ours.cameramodel").string() + " " + rewritten.string() + " 2>&1");
  ASSERT_EQ(result.status, 0) << result.output;
  const CameraModelFile model = read_cameramodel(rewritten);
  EXPECT_EQ(numbers_by_us(model), numbers_by_mrcal(rewritten));
  EXPECT_FALSE(model.comments.empty());
}

TEST(CameraModelInterop, MrcalToCahvorTakesOurFiles) {
  if (testing::run("command -v mrcal-to-cahvor").status != 0) GTEST_SKIP() << "SKIPPED: no mrcal-to-cahvor";
  if (!testing::has_mrcal_python()) GTEST_SKIP() << "SKIPPED: no mrcal module for /usr/bin/python3";
  const ScratchFolder scratch;
  CameraModelFile model = awkward_model();
  model.comments = {" a comment"};
  model.extra = "'icam_intrinsics': 2,\n";
  write_cameramodel(scratch / "m.cameramodel", model);
  const auto result = testing::run("mrcal-to-cahvor < " + (scratch / "m.cameramodel").string() + " 2>&1");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("Dimensions = 1280 720"));
}

// ------------------------------------------------------------ locale

/// Sets LC_ALL to a locale that prints 0,5; made with localedef where the system has none.
class CommaLocale {
 public:
  CommaLocale() {
    active_ = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
    if (active_) return;
    const auto made =
        testing::run("localedef -i de_DE -f UTF-8 " + (scratch_ / "de_DE.UTF-8").string() + " 2>&1");
    if (made.status != 0) return;
    setenv("LOCPATH", (scratch_ / "").c_str(), 1);
    active_ = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
  }
  ~CommaLocale() {
    std::setlocale(LC_ALL, "C");
    unsetenv("LOCPATH");
  }
  bool active() const { return active_ && std::string(std::localeconv()->decimal_point) == ","; }

 private:
  ScratchFolder scratch_;
  bool active_ = false;
};

TEST(CameraModelLocale, CommaLocaleChangesNothing) {
  const ScratchFolder scratch;
  write_cameramodel(scratch / "c.cameramodel", awkward_model());
  const CommaLocale locale;
  if (!locale.active()) GTEST_SKIP() << "SKIPPED: no de_DE.UTF-8 locale and no localedef to make one";
  write_cameramodel(scratch / "de.cameramodel", awkward_model());
  EXPECT_EQ(testing::read_file(scratch / "c.cameramodel"), testing::read_file(scratch / "de.cameramodel"));
  EXPECT_EQ(bits(read_cameramodel(scratch / "de.cameramodel")), bits(awkward_model()));
}

}  // namespace
}  // namespace fringetwin::cameramodel_test
