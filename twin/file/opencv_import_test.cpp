// SPDX-License-Identifier: Apache-2.0
// tolerance  unit  origin
// exact      -     matrices printed by OpenCV with 17 digits
// 4e-15      rad   rotation vector -> matrix -> vector (see pose_test.cpp)
// 1e-11      px    cv::projectPoints against our lens: 22 roundings at coordinates up to 2000 px
#include "twin/file/opencv_import.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "tests/support/twin/child_process.hpp"
#include "twin/base/errors.hpp"
#include "twin/lens/lens.hpp"
#include "twin/lens/pose.hpp"

namespace fringetwin::opencv_import_test {
namespace {

using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;
using testing::ScratchFolder;

const cv::Mat1d camera_matrix = (cv::Mat1d(3, 3) << 1700.15, 0, 627.73, 0, 1701.22, 406.54, 0, 0, 1);
const cv::Vec3d rotation_vector(-0.0099, 0.3754, 0.0276);
const OpenCvDevice device{"M1", "D1", "R", "T"};

cv::Mat1d rotation() {
  cv::Mat1d R;
  cv::Rodrigues(rotation_vector, R);
  return R;
}

cv::Mat1d distortion(int n) {
  cv::Mat1d D(1, n, 0.0);
  const double k[] = {0.1328, -0.3361, -0.0006, -0.0001, 0.01,  0.02,
                      -0.03,  0.004,   0.005,   -0.006,  0.007, 0.008};
  for (int i = 0; i < std::min(n, 12); ++i) D(0, i) = k[i];
  return D;
}

struct Matrices {
  cv::Mat M = camera_matrix.clone(), D = distortion(5), R = rotation(),
          T = (cv::Mat1d(3, 1) << -94.5914, -0.1889, 12.4706);
};

std::filesystem::path save(const ScratchFolder& scratch, const std::string& name, const Matrices& m) {
  cv::FileStorage out((scratch / name).string(), cv::FileStorage::WRITE);
  out << "calibration_time"
      << "today"
      << "M1" << m.M << "D1" << m.D << "R" << m.R << "T" << m.T;
  return scratch / name;
}

std::string refusal(const std::function<void(Matrices&)>& spoil) {
  const ScratchFolder scratch;
  Matrices m;
  spoil(m);
  const auto file = save(scratch, "stereo.yml", m);
  try {
    import_opencv({file}, device);
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr("stereo.yml"));
    return e.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

TEST(OpenCvImport, YamlXmlAndJson) {
  const ScratchFolder scratch;
  for (const std::string name : {"stereo.yml", "stereo.xml", "stereo.json"}) {
    const OpenCvModel model = import_opencv({save(scratch, name, {})}, device);
    EXPECT_EQ(model.lensmodel, "LENSMODEL_OPENCV5");
    EXPECT_THAT(model.intrinsics,
                ElementsAre(1700.15, 1701.22, 627.73, 406.54, 0.1328, -0.3361, -0.0006, -0.0001, 0.01));
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(model.rt_device_ref[static_cast<std::size_t>(i)], rotation_vector[i], 4e-15) << name;
    EXPECT_EQ(model.rt_device_ref[3], -94.5914);
    EXPECT_EQ(model.rt_device_ref[5], 12.4706);
  }
}

TEST(OpenCvImport, FilesOfTheStereoSample) {  // intrinsics.yml and extrinsics.yml, as its authors print them
  const ScratchFolder scratch;
  const auto intrinsics =
      scratch.write("intrinsics.yml",
                    "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                    "   data: [ 5.3e+02, 0., 3.2e+02, 0., 5.3e+02, 2.4e+02, 0., 0., 1. ]\n"
                    "D1: !!opencv-matrix\n   rows: 1\n   cols: 14\n   dt: d\n"
                    "   data: [ -2.6e-01, 1e-01, 0., 0., 0., 1e-02, 2e-02, 3e-02, 0., 0., 0., 0.,\n"
                    "       0., 0. ]\n");
  const auto extrinsics =
      scratch.write("extrinsics.yml",
                    "%YAML:1.0\n---\nR: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: f\n"
                    "   data: [ 0., -1., 0., 1., 0., 0., 0., 0., 1. ]\n"
                    "T: !!opencv-matrix\n   rows: 1\n   cols: 3\n   dt: d\n"
                    "   data: [ -3.5, 0., 1. ]\n");
  const OpenCvModel model = import_opencv({intrinsics, extrinsics}, device);
  EXPECT_EQ(model.lensmodel, "LENSMODEL_OPENCV12");  // the tilt, coefficients 13 and 14, is zero
  EXPECT_EQ(model.intrinsics.size(), 16u);
  EXPECT_NEAR(model.rt_device_ref[2], std::acos(-1.0) / 2, 4e-15);
  EXPECT_EQ(model.rt_device_ref[3], -3.5);
}

/// As OpenCV's sample of a calibration writes it for each camera: the same names in every file.
std::string one_camera(double fx, const std::string& head = "") {
  return "%YAML:1.0\n---\n" + head + "M: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ " +
         std::to_string(fx) + ", 0., 320., 0., 530., 240., 0., 0., 1. ]\n" +
         "D: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ 0.1, 0., 0., 0. ]\n";
}

TEST(OpenCvImport, AMatrixOfSeveralFilesIsAskedFor) {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "b:c");
  const auto left = scratch.write("left.yml", one_camera(501)),
             right = scratch.write("right.yml", one_camera(502)),
             other = scratch.write("b:c/left.yml", one_camera(503));
  const auto fx = [&](const std::string& key) {
    return import_opencv({left, right, other}, {key, "right.yml:D", "", ""}).intrinsics[0];
  };
  const auto sentence = [&](const std::string& key) -> std::string {
    try {
      fx(key);
    } catch (const UserError& e) {
      EXPECT_EQ(e.code(), ExitCode::input);
      return e.what();
    }
    return "accepted";
  };
  EXPECT_THAT(sentence("M"),
              HasSubstr(left.string() + ", " + right.string() + ", " + other.string() +
                        ": each of them has a matrix 'M'; say which is meant: " + left.string() + ":M"));
  EXPECT_THAT(sentence("left.yml:M"),
              HasSubstr(left.string() + ", " + other.string() + ": each of them has"));
  EXPECT_THAT(sentence("ft.yml:M"), HasSubstr("there is no matrix 'ft.yml:M'"));
  EXPECT_THAT(sentence("right.yml:N"), HasSubstr(right.string() + ": there is no matrix 'N'"));
  EXPECT_EQ(fx(left.string() + ":M"), 501);
  EXPECT_EQ(fx("right.yml:M"), 502);
  EXPECT_EQ(fx("b:c/left.yml:M"), 503);
  EXPECT_EQ(import_opencv({left, left}, {"M", "D", "", ""}).intrinsics[0], 501);  // one file named twice
}

TEST(OpenCvImport, NoDistortionIsAPinhole) {
  const ScratchFolder scratch;
  const OpenCvModel model = import_opencv({scratch.write("a.yml", one_camera(501))}, {"M", "none", "", ""});
  EXPECT_EQ(model.lensmodel, "LENSMODEL_PINHOLE");
  EXPECT_THAT(model.intrinsics, ElementsAre(501, 530, 320, 240));
}

TEST(OpenCvImport, TellsTheSizeThatTheFileStates) {
  const ScratchFolder scratch;
  const auto size = [&](const std::filesystem::path& file) {
    return import_opencv({file}, {"M", "D", "", ""}).stated_imagersize_px;
  };
  constexpr std::array<int, 2> right{640, 480};
  EXPECT_EQ(size(scratch.write("a.yml", one_camera(501, "image_width: 640\nimage_height: 480 # px\n"))),
            right);
  EXPECT_EQ(size(scratch.write("b.yml", one_camera(501, "image_width: 640\n"))), std::nullopt);
  for (const char* name : {"c.xml", "c.json"}) {
    {
      cv::FileStorage out((scratch / name).string(), cv::FileStorage::WRITE);
      out << "image_width" << 640 << "image_height" << 480 << "M" << camera_matrix << "D" << distortion(4);
    }
    EXPECT_EQ(size(scratch / name), right) << name;
  }
}

TEST(OpenCvImport, NoExtrinsicsKeysMeanTheReference) {
  const ScratchFolder scratch;
  const OpenCvModel model = import_opencv({save(scratch, "a.yml", {})}, {"M1", "D1", "", ""});
  EXPECT_THAT(model.rt_device_ref, ElementsAre(0, 0, 0, 0, 0, 0));
}

TEST(OpenCvImport, RotationVectorsAndFloatsAreTaken) {
  const ScratchFolder scratch;
  Matrices m;
  m.R = cv::Mat(rotation_vector).clone();
  m.M.convertTo(m.M, CV_32F);
  const OpenCvModel model = import_opencv({save(scratch, "a.yml", m)}, device);
  EXPECT_EQ(model.rt_device_ref[1], rotation_vector[1]);
  EXPECT_EQ(model.intrinsics[0], static_cast<double>(1700.15f));
}

TEST(OpenCvImport, RotationsRoundedToSevenDigitsAreMadeExact) {
  const ScratchFolder scratch;
  Matrices m;
  cv::Mat1d R = rotation();
  for (double& r : R) r = std::round(r * 1e7) * 1e-7;
  m.R = R;
  const OpenCvModel model = import_opencv({save(scratch, "a.yml", m)}, device);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(model.rt_device_ref[static_cast<std::size_t>(i)], rotation_vector[i],
                1e-7);  // the last digit
}

TEST(OpenCvImport, EveryModelProjectsAsOpenCvDoes) {
  const ScratchFolder scratch;
  for (const int n : {4, 5, 8, 12}) {
    Matrices m;
    m.D = distortion(n);
    const OpenCvModel model = import_opencv({save(scratch, "a.yml", m)}, device);
    EXPECT_EQ(model.lensmodel, "LENSMODEL_OPENCV" + std::to_string(n));
    const Lens lens(model.lensmodel, model.intrinsics, {1280, 720}, "test");
    const Pose T = pose_from_rt(Eigen::Map<const RotTrans>(model.rt_device_ref.data()));
    std::vector<cv::Point3d> points;
    for (double x = -20; x <= 60; x += 20)
      for (double y = -30; y <= 30; y += 15) points.emplace_back(x, y, 270 + 0.3 * x);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(points, rotation_vector, m.T, m.M, m.D, pixels);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto q = lens.project(T * Eigen::Vector3d(points[i].x, points[i].y, points[i].z));
      ASSERT_TRUE(q);
      EXPECT_NEAR(q->x(), pixels[i].x, 1e-11);
      EXPECT_NEAR(q->y(), pixels[i].y, 1e-11);
    }
  }
}

TEST(OpenCvImport, ListsTheMatrices) {
  const ScratchFolder scratch;
  EXPECT_THAT(list_opencv_keys(save(scratch, "a.yml", {})),
              ElementsAre("M1 (3x3)", "D1 (1x5)", "R (3x3)", "T (3x1)"));
}

TEST(OpenCvImport, RefusesWhatIsNoCalibration) {
  EXPECT_THAT(refusal([](Matrices& m) { m.M = cv::Mat1d::eye(3, 4); }),
              HasSubstr("M1: a camera matrix is 3x3, this is 3x4"));
  EXPECT_THAT(refusal([](Matrices& m) { m.M = (cv::Mat1d(3, 3) << 1, 0.5, 0, 0, 1, 0, 0, 0, 1); }),
              HasSubstr("skew 0.5"));
  EXPECT_THAT(refusal([](Matrices& m) { m.M = (cv::Mat1d(3, 3) << -1, 0, 0, 0, 1, 0, 0, 0, 1); }),
              HasSubstr("is not a camera matrix"));
  EXPECT_THAT(refusal([](Matrices& m) { m.M = cv::Mat1d::zeros(3, 3); }),
              HasSubstr("is not a camera matrix"));
  EXPECT_THAT(refusal([](Matrices& m) { m.D = distortion(6); }),
              HasSubstr("D1: has 6 distortion coefficients"));
  EXPECT_THAT(refusal([](Matrices& m) { m.D = cv::Mat1d::zeros(2, 2); }), HasSubstr("this is 2x2"));
  EXPECT_THAT(refusal([](Matrices& m) {
                cv::Mat1d D = distortion(14);
                D(0, 13) = 0.01;
                m.D = D;
              }),
              HasSubstr("tilted sensor"));
  EXPECT_THAT(refusal([](Matrices& m) { m.R = -rotation(); }),
              HasSubstr("R: is no rotation: determinant -1"));
  EXPECT_THAT(refusal([](Matrices& m) { m.R = 1.001 * rotation(); }), HasSubstr("is no rotation"));
  EXPECT_THAT(refusal([](Matrices& m) { m.R = cv::Mat1d::zeros(3, 3); }), HasSubstr("is no rotation"));
  EXPECT_THAT(refusal([](Matrices& m) { m.R = cv::Mat1d::eye(2, 2); }), HasSubstr("this is 2x2"));
  EXPECT_THAT(refusal([](Matrices& m) { m.T = cv::Mat1d::zeros(4, 1); }),
              HasSubstr("T: must have 3 elements"));
  EXPECT_THAT(refusal([](Matrices& m) { m.T = (cv::Mat1d(3, 1) << 0, std::nan(""), 0); }),
              HasSubstr("not finite"));
}

TEST(OpenCvImport, NamesAMissingKeyAndWhatIsThere) {
  const ScratchFolder scratch;
  const auto file = save(scratch, "a.yml", {});
  try {
    import_opencv({file}, {"M2", "D1", "R", "T"});
    FAIL();
  } catch (const UserError& e) {
    EXPECT_THAT(e.what(), HasSubstr("a.yml: there is no matrix 'M2'; matrices there: M1 (3x3), D1 (1x5)"));
  }
  EXPECT_THROW(import_opencv({file}, {"calibration_time", "D1", "R", "T"}), UserError);
}

TEST(OpenCvImport, RefusesFilesThatAreNone) {
  const ScratchFolder scratch;
  const auto sentence = [](const std::filesystem::path& file) -> std::string {
    try {
      import_opencv({file}, device);
    } catch (const UserError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(sentence(scratch / "none.yml"), HasSubstr("none.yml: the calibration cannot be read"));
  EXPECT_THAT(sentence(scratch.write("noise.yml", std::string("\x89PNG\r\n\0\0", 8))),
              HasSubstr("noise.yml"));
  EXPECT_THAT(sentence(scratch.write("empty.yml", "")), HasSubstr("empty.yml"));
  EXPECT_THAT(sentence(scratch.write("cut.xml",
                                     "<?xml version=\"1.0\"?>\n<opencv_storage>\n<M1 type_id=\"opencv-ma")),
              HasSubstr("cut.xml"));
  EXPECT_THAT(sentence(scratch.write("cut.yml",
                                     "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                                     "   data: [ 1., 0.")),
              HasSubstr("cut.yml"));
  EXPECT_THAT(sentence(scratch.write("few.yml",
                                     "%YAML:1.0\n---\nM1: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                                     "   data: [ 1., 0. ]\n")),
              HasSubstr("few.yml"));
}

TEST(OpenCvImport, PassesOverWhatLiesAround) {
  const ScratchFolder scratch;
  for (const char* name : {"a.yml", "a.xml", "a.json"}) {
    {
      cv::FileStorage out((scratch / name).string(), cv::FileStorage::WRITE);
      out.writeComment("M1: [ {");
      out << "time"
          << "Thu [ 12:03 \"x\" # {"
          << "n" << 3 << "empty"
          << "";
      out << "views"
          << "["
          << "a ["
          << "[:" << 1 << 2.5 << "]"
          << "{"
          << "M1" << 7 << "}"
          << "]";
      out << "inner"
          << "{"
          << "M1" << cv::Mat1d(2, 2, 0.0) << "rows" << 5 << "}";
      out << "points" << cv::Mat(4, 1, CV_64FC2, cv::Scalar(1.0, 2.0));
      out << "M1" << camera_matrix << "D1" << distortion(5) << "big" << cv::Mat1f(60, 60, 1.0f);
    }
    const OpenCvModel model = import_opencv({scratch / name}, {"M1", "D1", "", ""});
    EXPECT_EQ(model.intrinsics[0], 1700.15) << name;
    EXPECT_EQ(model.intrinsics[8], 0.01) << name;
    EXPECT_THAT(list_opencv_keys(scratch / name),
                ElementsAre("points (4x1)", "M1 (3x3)", "D1 (1x5)", "big (60x60)"))
        << name;
  }
}

TEST(OpenCvImport, ReadsWhatIsWrittenByHand) {
  const ScratchFolder scratch;
  const auto yaml = scratch.write(
      "hand.yml",
      "\xef\xbb\xbf%YAML 1.0\r\n# mine\r\nM1: {rows: 3, cols: 3, dt: \"d\", data: [1e3, 0, 5,\r\n 0,\r\n"
      "+1000., 6, 0, 0, 1]} # flow\r\nlist:\r\n- 1\r\n- [2,\r\n3]\r\nD1: !!opencv-matrix\r\n"
      "  rows: 4 # four\r\n  cols: 1\r\n  dt: d\r\n  data:\r\n    [ .5, 0, # two\r\n      0, 0 ]");
  EXPECT_THAT(import_opencv({yaml}, {"M1", "D1", "", ""}).intrinsics,
              ElementsAre(1000, 1000, 5, 6, 0.5, 0, 0, 0));
}

std::string sentence_on(const std::string& text) {
  const ScratchFolder scratch;
  const auto file = scratch.write("bad.file", text);
  try {
    import_opencv({file}, {"M", "D", "", ""});
  } catch (const UserError& e) {
    EXPECT_EQ(e.code(), ExitCode::input);
    EXPECT_THAT(e.what(), HasSubstr(file.string()));
    EXPECT_LT(std::string(e.what()).size(), 501u);
    return e.what();
  }
  ADD_FAILURE() << "accepted: " << text.substr(0, 100);
  return "";
}

TEST(OpenCvImport, RefusesWhatOpenCvsOwnReadersFallOver) {
  const std::string yaml = "%YAML:1.0\n---\n", xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n";
  const auto repeated = [](const std::string& s, int n) {
    std::string all;
    for (int i = 0; i < n; ++i) all += s;
    return all;
  };
  EXPECT_THAT(sentence_on("<?xml version="), HasSubstr("the file ends within a tag"));
  EXPECT_THAT(sentence_on(yaml + "M: " + std::string(100000, '[')),
              HasSubstr(":3: brackets are nested too deeply"));
  EXPECT_THAT(sentence_on(repeated("{\"M\":", 100000)), HasSubstr("nested too deeply"));
  EXPECT_THAT(sentence_on(xml + repeated("<a>", 100000)), HasSubstr("tags are nested too deeply"));
  std::string block = yaml;
  for (int i = 0; i < 2000; ++i) block += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_THAT(sentence_on(block), HasSubstr("there is no matrix 'M'"));
  EXPECT_THAT(sentence_on(yaml + "- 1\n- 2\n"), HasSubstr("is no line of a calibration"));
  EXPECT_THAT(sentence_on("[1, 2]"), HasSubstr("neither YAML, XML nor JSON"));
  EXPECT_THAT(sentence_on(xml + "<M>&" + std::string(20000, 'a') + ";</M>"), HasSubstr("within a tag"));
  EXPECT_THAT(sentence_on(xml + "<a></b>"), HasSubstr(":3: a closing tag has no opening one"));
  EXPECT_THAT(sentence_on("{\"M\": [1}"), HasSubstr("expected ']', found '}'"));
  EXPECT_THAT(sentence_on("{\"M\" 1}"), HasSubstr("expected a key and ':'"));
  EXPECT_THAT(sentence_on("{\"M\": \"1\\"), HasSubstr("the file ends within a string"));
  EXPECT_THAT(sentence_on(yaml + "\tM: 1\n"), HasSubstr("has a tab"));
}

TEST(OpenCvImport, RefusesMatricesThatAreNone) {
  const auto matrix = [](const std::string& rows, const std::string& dt, const std::string& data) {
    return sentence_on("%YAML:1.0\n---\nM: !!opencv-matrix\n   rows: " + rows + "\n   cols: 3\n   dt: " + dt +
                       "\n   data: " + data + "\n");
  };
  EXPECT_THAT(matrix("100000000", "d", "[ 1. ]"),
              HasSubstr("M: is 100000000x3, which no matrix of a calibration"));
  EXPECT_THAT(matrix("-3", "d", "[ 1. ]"), HasSubstr("two-dimensional matrix"));
  EXPECT_THAT(matrix("3.5", "d", "[ 1. ]"), HasSubstr("two-dimensional matrix"));
  EXPECT_THAT(matrix("3", "2d", "[ 1. ]"), HasSubstr("single-channel"));
  EXPECT_THAT(matrix("1", "d", "[ 1., 1e999, 2. ]"), HasSubstr("\"1e999\" is not a finite number"));
  EXPECT_THAT(matrix("1", "d", "[ 1., -.Inf, 2. ]"), HasSubstr("not finite"));
  EXPECT_THAT(matrix("1", "d", "[ 1., x, 2. ]"), HasSubstr("\"x\" is not a finite number"));
  EXPECT_THAT(matrix("1", "d", "!!binary |\n     ZCAgICAg"), HasSubstr("not base64"));
  EXPECT_THAT(matrix("1", "d", "[ 1., 2., 3., 4. ]"), HasSubstr("has not as many numbers"));
  EXPECT_THAT(matrix("1", "d", "[ 1. ]\nM: 3"), HasSubstr("M: is given twice"));
  // More sizes than OpenCV's reader has room for.
  EXPECT_THAT(
      sentence_on("{\"M\": {\"sizes\": [" + std::string(2000, '1') + "], \"dt\": \"d\", \"data\": [1]}}"),
      HasSubstr("two-dimensional matrix"));
}

}  // namespace
}  // namespace fringetwin::opencv_import_test
