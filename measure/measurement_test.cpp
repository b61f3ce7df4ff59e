// SPDX-License-Identifier: Apache-2.0
// The chain decode -> triangulate -> fit on images made per pixel from the projected pattern's definition.
// Tolerances
//   1e-4 mm   float images (issue table): rounding of float32 gray values is 1e-5 rad, 2e-5 px, 3e-6 mm a
//   point
#include "measure/measurement.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>

#include "tests/support/measure/measure_rig.hpp"
#include "tests/support/measure/read_ply.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::measure::measurement_test {
namespace {

using namespace testing;

CameraImages render_ideal(const Twin& twin, std::size_t camera, const RaySurface& scene) {
  MapOptions options;
  options.shadows = true;
  const CameraDecode truth = ideal_decode(twin, camera, scene, options);
  CameraImages images;
  images.camera = twin.cameras[camera].name;
  images.radiance = true;
  for (const PatternSpec& pattern : expand_sequence(twin.fringes)) {
    ImageF image(truth.width(), truth.height(), 0.0f);
    for (std::size_t i = 0; i < image.size(); ++i) {
      const double c = truth.directions[0].coordinate_px.data[i];
      if (std::isfinite(c))
        image.data[i] = static_cast<float>(100.0 * pattern_value(twin.fringes, pattern, c));
    }
    images.images.push_back(std::move(image));
  }
  return images;
}

struct Bench {
  Twin twin = scaled_paper_rig(0.5);
  std::vector<CameraImages> images;

  Bench() {
    twin.objects = {{"ball", SphereShape{{0, 0, 250}, 15}, {}}};
    twin.measure.fits = {{"ball", 2.0}};
    for (std::size_t c = 0; c < 2; ++c)
      images.push_back(render_ideal(twin, c, sphere_surface({0, 0, 250}, 15)));
  }
};

TEST(Measurement, StereoAndProjectorFromFloatImages) {
  Bench bench;
  for (const Triangulate how : {Triangulate::stereo, Triangulate::projector}) {
    bench.twin.measure.triangulate = how;
    const Measurement m = measure(bench.twin, bench.images);
    ASSERT_EQ(m.cameras.size(), 2u);
    ASSERT_EQ(m.fits.size(), 1u);
    ASSERT_TRUE(m.fits[0].usable) << m.fits[0].warning;
    std::printf("%s: n %zu of %zu points, rms %.2e mm, radius off %.2e mm\n",
                how == Triangulate::stereo ? "stereo" : "projector", m.fits[0].n, m.cloud.size(),
                m.fits[0].numbers.at("rms_mm"), m.fits[0].numbers.at("radius_mm") - 15);
    EXPECT_GT(m.cloud.size(), 8000u);
    EXPECT_LT(m.fits[0].numbers.at("rms_mm"), 1e-4);
    EXPECT_NEAR(m.fits[0].numbers.at("radius_mm"), 15.0, 1e-4);
    EXPECT_LT((m.fits[0].vectors.at("center_mm") - Eigen::Vector3d(0, 0, 250)).norm(), 1e-4);
    EXPECT_GE(m.fits[0].numbers.at("rms_all_mm"), m.fits[0].numbers.at("rms_mm"));
    EXPECT_GE(m.fits[0].numbers.at("n_gated"), static_cast<double>(m.fits[0].n));
    for (const char* key : {"decode", "match", "triangulate", "fit"}) EXPECT_TRUE(m.timing_s.contains(key));
    EXPECT_EQ(m.cloud.normal_world.size(), m.cloud.size());
  }
}

/// Gray values instead of irradiance: the known noise of the twin's sensor counts.
Bench gray_bench(const Sensor& sensor) {
  Bench bench;
  for (Camera& camera : bench.twin.cameras) camera.sensor = sensor;
  for (CameraImages& images : bench.images) images.radiance = false;
  return bench;
}

TEST(Measurement, KnownNoiseHoldsTheRoundingOnce) {
  Sensor sensor;
  sensor.read_noise_dn = 0.3;
  Bench bench = gray_bench(sensor);
  const Measurement m = measure(bench.twin, bench.images);
  const DirectionDecode& d = m.cameras[0].directions[0];
  EXPECT_EQ(d.noise_source, NoiseSource::known);
  EXPECT_NEAR(d.noise_dn, std::sqrt(0.09 + 1.0 / 12.0), 1e-6);
}

// A pose moves points and fits, and no decode: the finished one gives them bit for bit.
TEST(Measurement, AFinishedDecodeServesAMovedRig) {
  Sensor sensor;
  sensor.read_noise_dn = 0.3;
  const Bench bench = gray_bench(sensor);
  Twin moved = bench.twin;
  moved.cameras[1].T_cam_world.translation_mm.x() += 0.05;
  ASSERT_TRUE(decodes_alike(bench.twin, moved, bench.images));
  const Measurement anew = measure(moved, bench.images),
                    again = measure_decoded(moved, measure(bench.twin, bench.images).cameras);
  ASSERT_TRUE(anew.fits[0].usable && again.fits[0].usable);
  EXPECT_EQ(again.fits[0].numbers, anew.fits[0].numbers);
  EXPECT_EQ(again.fits[0].vectors, anew.fits[0].vectors);
  EXPECT_EQ(again.warnings, anew.warnings);
  EXPECT_NE(again.fits[0].vectors, measure(bench.twin, bench.images).fits[0].vectors) << "the rig moved";

  Twin noisier = bench.twin, dimmer = bench.twin;
  noisier.cameras[1].sensor.read_noise_dn = 0.4;
  dimmer.fringes.amplitude = 0.4;
  EXPECT_FALSE(decodes_alike(bench.twin, noisier, bench.images));
  EXPECT_FALSE(decodes_alike(bench.twin, dimmer, bench.images));
}

TEST(Measurement, ABlackLevelAboveTheImagesIsSaidAndLeavesASigma) {
  Sensor sensor;
  sensor.black_level_dn = 200.0;  // the images reach 100
  sensor.electrons_per_dn = 10.0;
  sensor.read_noise_dn = 0.4;
  Bench bench = gray_bench(sensor);
  const Measurement m = measure(bench.twin, bench.images);
  const DirectionDecode& d = m.cameras[0].directions[0];
  EXPECT_NEAR(d.noise_dn, std::sqrt(0.16 + 1.0 / 12.0), 1e-6);
  ASSERT_GT(m.cloud.size(), 1000u);
  for (std::size_t i = 0; i < m.cloud.size(); i += 100) EXPECT_GT(m.cloud.sigma_mm[i], 0.0f);
  ASSERT_FALSE(m.warnings.empty());
  EXPECT_NE(m.warnings[0].find("black_level_dn"), std::string::npos) << m.warnings[0];
  bench.twin.cameras[0].sensor.black_level_dn = bench.twin.cameras[1].sensor.black_level_dn = 5.0;
  EXPECT_TRUE(measure(bench.twin, bench.images).warnings.empty());
}

// A camera turned about its axis: most matches are accidents. What is said counts them as the summary does.
TEST(Measurement, ManyRejectedPixelsAreSaidWithTheirCounts) {
  Bench bench;
  Pose& pose = bench.twin.cameras[1].T_cam_world;
  pose.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()).toRotationMatrix() * pose.rotation;
  const Measurement m = measure(bench.twin, bench.images);
  const TriangulationSummary& t = m.triangulation;
  ASSERT_TRUE(mostly_rejected(t)) << t.n_rejected << " of " << matched_pixels(t);
  ASSERT_GT(t.n_points, 0u);
  EXPECT_EQ(t.n_points + t.n_rejected, matched_pixels(t));
  EXPECT_EQ(t.n_too_uncertain, 0u);
  const std::string counts = std::to_string(t.n_rejected) + " of the " +
                             std::to_string(t.n_points + t.n_rejected) + " pixels with a match (";
  EXPECT_TRUE(std::ranges::any_of(m.warnings, [&](const std::string& w) {
    return w.starts_with(counts) &&
           w.find("points left: " + std::to_string(t.n_points) + ". ") != std::string::npos;
  })) << counts;
  const Measurement right = measure(Bench().twin, bench.images);
  EXPECT_EQ(right.triangulation.n_points + right.triangulation.n_rejected,
            matched_pixels(right.triangulation));
  EXPECT_TRUE(right.warnings.empty()) << right.warnings.front();
}

TEST(Measurement, SmoothingComesFromTheTwin) {
  Sensor sensor;
  sensor.read_noise_dn = 1.0;
  Bench bench = gray_bench(sensor);
  const auto median_sigma = [&] {
    std::vector<float> sigma = measure(bench.twin, bench.images).cloud.sigma_mm;
    std::nth_element(sigma.begin(), sigma.begin() + static_cast<std::ptrdiff_t>(sigma.size() / 2),
                     sigma.end());
    return static_cast<double>(sigma[sigma.size() / 2]);
  };
  const double raw = median_sigma();
  bench.twin.measure.smoothing_px = 2.0;
  EXPECT_LT(median_sigma(), 0.8 * raw);
}

TEST(Measurement, DecodeOnlyWhereTheRigCannotTriangulate) {
  Bench bench;
  bench.twin.projector.reset();
  bench.twin.cameras.pop_back();
  bench.images.pop_back();
  const Measurement m = measure(bench.twin, bench.images);
  EXPECT_EQ(m.cloud.size(), 0u);
  EXPECT_EQ(m.cameras.size(), 1u);
  EXPECT_FALSE(m.warnings.empty());
  Bench wrong;
  wrong.images.pop_back();
  EXPECT_THROW(measure(wrong.twin, wrong.images), UserError);
}

TEST(Measurement, FilesAreWritten) {
  Bench bench;
  const Measurement m = measure(bench.twin, bench.images);
  const auto dir =
      std::filesystem::temp_directory_path() / ("fringetwin_measurement_" + std::to_string(::getpid()));
  write_measurement(dir / "nested", m);
  write_measurement(dir / "nested", m);  // the folder may exist
  EXPECT_TRUE(std::filesystem::exists(dir / "nested/phase_left.exr"));
  EXPECT_TRUE(std::filesystem::exists(dir / "nested/phase_right.exr"));
  const testing::PlyPoints ply = testing::read_ply_points(dir / "nested/points.ply");
  // What docs/formats/results.md says of the file; CloudCompare shows what begins with scalar_.
  EXPECT_EQ(ply.names,
            (std::vector<std::string>{"x", "y", "z", "nx", "ny", "nz", "scalar_sigma_mm", "scalar_pixel_x",
                                      "scalar_pixel_y", "scalar_column_px", "scalar_amplitude_dn",
                                      "scalar_mean_dn", "scalar_sigma_rad"}));
  EXPECT_EQ(ply.type.at("z"), "double");
  EXPECT_EQ(ply.type.at("scalar_column_px"), "float");
  ASSERT_EQ(ply.n, m.cloud.size());
  EXPECT_TRUE(ply.complete);
  const DirectionDecode& decode = m.cameras[0].directions[0];
  for (const std::size_t k : {std::size_t{0}, m.cloud.size() / 2, m.cloud.size() - 1}) {
    const auto at = [&](const char* name) { return ply.values.at(name)[k]; };
    EXPECT_EQ(Eigen::Vector3d(at("x"), at("y"), at("z")), m.cloud.p_world_mm[k]);
    EXPECT_EQ(at("nz"), m.cloud.normal_world[k].z());
    EXPECT_EQ(at("scalar_sigma_mm"), m.cloud.sigma_mm[k]);
    EXPECT_EQ(at("scalar_pixel_x"), m.cloud.q_cam_px[k].x());
    EXPECT_EQ(at("scalar_pixel_y"), m.cloud.q_cam_px[k].y());
    const int u = static_cast<int>(at("scalar_pixel_x")), v = static_cast<int>(at("scalar_pixel_y"));
    EXPECT_EQ(at("scalar_column_px"), static_cast<float>(decode.coordinate_px(u, v)));
    EXPECT_EQ(at("scalar_amplitude_dn"), decode.amplitude_dn[decode.finest](u, v));
    EXPECT_EQ(at("scalar_sigma_rad"), decode.sigma_rad(u, v));
  }
  for (const auto& entry : std::filesystem::directory_iterator(dir / "nested"))
    EXPECT_TRUE(entry.path().extension() == ".exr" || entry.path().extension() == ".ply") << entry.path();
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace fringetwin::measure::measurement_test
