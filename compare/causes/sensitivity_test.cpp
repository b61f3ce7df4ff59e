// SPDX-License-Identifier: Apache-2.0
// Derivatives and least squares through the renderer, against closed forms and planted changes.
//
// | check                            | tolerance | origin                                             |
// |----------------------------------|-----------|----------------------------------------------------|
// | derivatives, E u and E/diffuse   | 5e-5 E    | 2 float roundings (6e-8 E) over a step of 0.01, x 4 |
// | a thinned view, of the brightest | 1e-4      | phase in single precision: 5e-5 rad, both views    |
// | planted change                   | 1 % of it | steps of 0.3 %: curvature 0.15 %, rounding 0.4 %   |
// | slope of the loss                | 0.5 %     | third derivative 0.1 %, values that cross the scale |
// | the same, offset of each pixel   | 5 %       | its weights are chosen once: 3.5 % here            |
// | regional chi2, a kind            | 0.12      | 3 sqrt(2/n), n = 1,280 squares                     |
// | pixels left out, from the edge   | 3 px      | it slants: its own, one beside it, one of rounding |
#include "compare/causes/sensitivity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <numeric>
#include <random>

#include "compare/causes/cause_regions.hpp"
#include "compare/parameters/parameters.hpp"
#include "tests/support/agreement.hpp"
#include "tests/support/paper_rig.hpp"

namespace fringetwin::compare::sensitivity_test {
namespace {

constexpr int kWidth = 96, kHeight = 80;
constexpr double kGain = 20.0, kBlack = 7.0;

/// The paper's rig, cropped to a window that the sphere fills.
Twin window_on_the_sphere() {
  const SphereShape ball = testing::physical_sphere();
  Twin twin = testing::with_object(testing::paper_rig(), "ball", ball, {});
  twin = testing::crop_around(twin, ball.center_mm, kWidth, kHeight);
  for (Camera& camera : twin.cameras) {
    camera.sensor.gain_dn = kGain;
    camera.vignetting = {Vignetting::Kind::polynomial, {-0.05, 0.0, 0.0}, {0.02, -0.03}};
  }
  return twin;
}

render::Renderer& renderer() { return testing::needed_renderer(); }

/// Samples of all pixels of a grid; real gray values = kGain E + kBlack of `truth`, no noise.
GridSamples samples_of(const Twin& truth, std::size_t camera, const GridView& grid) {
  GridSamples s;
  s.camera = camera;
  s.grid = grid;
  const std::vector<ImageF> images = render_grid(renderer(), truth, camera, grid, 9);
  for (int k = 0; k < static_cast<int>(images.size()); ++k) s.images.push_back(k);
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    s.cell.push_back(i);
    for (const ImageF& image : images) {
      s.real_dn.push_back(static_cast<float>(kGain * static_cast<double>(image.data[i]) + kBlack));
      s.weight.push_back(1.0F);
    }
  }
  s.gain_dn = kGain;
  s.black_level_dn = kBlack;
  return s;
}

GridView whole() { return {1, 0, 0, kWidth, kHeight}; }

Parameter parameter(const Twin& twin, const std::string& group, const std::string& name) {
  for (Parameter& p : parameters_of(twin, group))
    if (p.name == name) return p;
  ADD_FAILURE() << name;
  return {};
}

/// dE/dp of one value: with weight on it alone, normal(p, black) = gain dE/dp.
double derivative_of(const Twin& twin, const Parameter& p, GridSamples samples, std::size_t value,
                     Sensitivity::Derivative how = Sensitivity::Derivative::quick) {
  std::fill(samples.weight.begin(), samples.weight.end(), 0.0F);
  samples.weight[value] = 1.0F;
  Sensitivity sensitivity(renderer(), {std::move(samples)});
  const NormalEquations e = sensitivity.equations(twin, {p}, start_values({p}), false, how);
  EXPECT_EQ(e.n, 1u);
  return e.normal(0, static_cast<Eigen::Index>(e.black_at(0))) / kGain;
}

struct Place {
  int x, y, image;
  std::size_t value(std::size_t images) const {
    return static_cast<std::size_t>(y * kWidth + x) * images + static_cast<std::size_t>(image);
  }
};
constexpr Place kPlaces[] = {{3, 5, 0}, {90, 11, 5}, {48, 40, 2}, {20, 77, 7}, {70, 60, 11}};

TEST(Sensitivity, VignettingTiltChangesTheLightByItsPlace) {
  const Twin twin = window_on_the_sphere();
  const GridSamples samples = samples_of(twin, 1, whole());
  const double corner = 0.5 * std::hypot(kWidth, kHeight);
  for (const Place& at : kPlaces) {
    const std::size_t value = at.value(samples.images.size());
    const double e = (static_cast<double>(samples.real_dn[value]) - kBlack) / kGain;
    const double u = (at.x - 0.5 * (kWidth - 1)) / corner, v = (at.y - 0.5 * (kHeight - 1)) / corner;
    const double now = 1.0 + 0.02 * u - 0.03 * v - 0.05 * (u * u + v * v);
    const Parameter tilt = parameter(twin, "vignetting", "right.vignetting_tilt.x");
    for (const auto how : {Sensitivity::Derivative::quick, Sensitivity::Derivative::exact})
      EXPECT_NEAR(derivative_of(twin, tilt, samples, value, how), e * u / now, 5e-5 * e)
          << at.x << ' ' << at.y;
  }
}

TEST(Sensitivity, LightGrowsWithTheReflectivity) {
  const Twin twin = window_on_the_sphere();
  const GridSamples samples = samples_of(twin, 0, whole());
  const Parameter diffuse = parameter(twin, "albedo", "ball.diffuse");
  for (const Place& at : kPlaces) {
    const std::size_t value = at.value(samples.images.size());
    const double e = (static_cast<double>(samples.real_dn[value]) - kBlack) / kGain;
    EXPECT_NEAR(derivative_of(twin, diffuse, samples, value), e / diffuse.start, 5e-5 * e);
  }
}

// Of values beyond the robust scale a step makes Huber's loss least: the square with its robust weight falls
// half as fast, and a fit that went by it turned good steps down.
TEST(Sensitivity, TheLossFallsAsTheEquationsSay) {
  const Twin twin = window_on_the_sphere();
  const std::vector<Parameter> p{parameter(twin, "vignetting", "left.vignetting_tilt.x")};
  for (const FreePerPixel free : {FreePerPixel::nothing, FreePerPixel::offset}) {
    GridSamples samples = samples_of(twin, 0, whole());
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0.0F, 1.0F);
    for (std::size_t i = 0; i < samples.real_dn.size(); ++i) {
      samples.real_dn[i] += noise(random);
      // values far out, of every third pixel on one side, which pull the tilt
      const bool is_right = static_cast<int>(i / samples.images.size()) % kWidth > kWidth / 2;
      if (is_right && i % (3 * samples.images.size()) == 0) samples.real_dn[i] += 12.0F;
    }
    Sensitivity sensitivity(renderer(), {std::move(samples)});
    const Sensitivity::Values base = sensitivity.predicted(twin, p, start_values(p));
    const Sensitivity::Columns columns =
        sensitivity.columns(twin, p, start_values(p), Sensitivity::Derivative::exact);
    sensitivity.choose_scale(base, free);
    const NormalEquations here = sensitivity.equations_at(base, columns, free);
    const double step = 1e-3;
    Eigen::Vector2d loss;
    for (const int side : {0, 1}) {
      const NormalEquations there = sensitivity.equations_at(
          sensitivity.predicted(twin, p, Eigen::VectorXd::Constant(1, p[0].start + (2 * side - 1) * step)),
          columns, free);
      loss[side] = there.chi2 + there.beyond;
    }
    const double wanted = -2.0 * here.right[0];
    EXPECT_NEAR((loss[1] - loss[0]) / (2.0 * step), wanted,
                (free == FreePerPixel::nothing ? 0.005 : 0.05) * std::abs(wanted));
  }
}

TEST(Sensitivity, GainAndReflectivityCannotBeToldApart) {
  const Twin twin = window_on_the_sphere();
  const std::vector<Parameter> p{parameter(twin, "albedo", "ball.diffuse")};
  Sensitivity sensitivity(renderer(), {samples_of(twin, 0, whole())});
  const NormalEquations e = sensitivity.equations(twin, p, start_values(p));
  const auto gain = static_cast<Eigen::Index>(e.gain_at(0));
  const double correlation = e.normal(0, gain) / std::sqrt(e.normal(0, 0) * e.normal(gain, gain));
  EXPECT_NEAR(correlation, 1.0, 1e-8);
}

// y = g_k E + black, with a gain of its own for each image lit apart, in two cameras that have different
// ones.
TEST(Sensitivity, ImagesLitApartHaveGainsOfTheirOwn) {
  constexpr std::size_t kPixels = 40, kImages = 5;
  const std::vector<std::vector<std::size_t>> apart{{4}, {1, 3}};
  const auto gain_of = [&](std::size_t c, std::size_t k) {
    const bool is_apart = std::ranges::find(apart[c], k) != apart[c].end();
    return (c == 0 ? 20.0 : 30.0) * (is_apart ? 1.0 + 0.01 * static_cast<double>(k) : 1.0);
  };
  std::vector<GridSamples> all;
  Sensitivity::Values base;
  for (std::size_t c = 0; c < 2; ++c) {
    GridSamples s;
    s.camera = c;
    s.grid = {1, 0, 0, 8, 5};
    s.images = {0, 1, 2, 3, 4};
    s.gain_dn = 22.0, s.black_level_dn = 5.0;
    s.lit_apart = apart[c];
    s.light.assign(kImages, 1.0);
    base.emplace_back();
    for (std::size_t p = 0; p < kPixels; ++p) {
      s.cell.push_back(p);
      for (std::size_t k = 0; k < kImages; ++k) {
        const double e = 1.0 + static_cast<double>((7 * p + 3 * k) % 11);
        base[c].push_back(static_cast<float>(e));
        s.real_dn.push_back(static_cast<float>(gain_of(c, k) * e + 7.0));
        s.weight.push_back(10.0F);
      }
    }
    all.push_back(std::move(s));
  }
  Sensitivity sensitivity(renderer(), all);
  sensitivity.set_scale({1e9, 1e9});  // all values count in full
  std::vector<std::size_t> unknowns(7);
  std::iota(unknowns.begin(), unknowns.end(), 0);
  for (int round = 0; round < 2; ++round) {  // the prior is about the gain of the others as it was
    const NormalEquations e = sensitivity.equations_at(base, {base, {}}, FreePerPixel::nothing);
    ASSERT_EQ(e.right.size(), 2 * 2 + 3);
    const Step step = solve_step(e, unknowns);
    EXPECT_EQ(step.n_determined, 7);
    if (round == 1) {
      EXPECT_LT(step.chi2, 0.05);  // three lights that are 1, 3 and 4 % off, of a prior of 30 %
    }
    sensitivity.move_sensors(step.change);
  }
  for (std::size_t c = 0; c < 2; ++c) {
    const GridSamples& s = sensitivity.samples()[c];
    EXPECT_NEAR(s.black_level_dn, 7.0, 1e-4);
    for (std::size_t k = 0; k < kImages; ++k) EXPECT_NEAR(s.gain_of(k), gain_of(c, k), 1e-4) << c << ' ' << k;
    EXPECT_EQ(s.light[0], 1.0);
  }
}

TEST(Sensitivity, PixelsThatFillABlockExactlyAreSummed) {
  constexpr std::size_t kPixels = 1024, kColumns = 60;  // 32 for each of the 32 parts
  GridSamples s;
  s.grid = {1, 0, 0, 32, 32};
  s.images = {0, 1, 2};
  for (std::size_t i = 0; i < kPixels; ++i) s.cell.push_back(i);
  s.real_dn.assign(3 * kPixels, 3.0F);
  s.weight.assign(3 * kPixels, 1.0F);
  const Sensitivity::Values base{std::vector<float>(3 * kPixels, 1.0F)};
  const Sensitivity sensitivity(renderer(), {s});
  const NormalEquations e = sensitivity.equations_at(
      base, {base, std::vector<Sensitivity::Values>(kColumns, base)}, FreePerPixel::nothing);
  EXPECT_EQ(e.n, 3 * kPixels);
  EXPECT_DOUBLE_EQ(e.chi2, 4.0 * 3 * kPixels);
  EXPECT_DOUBLE_EQ(e.normal(0, kColumns - 1), 3.0 * kPixels);
}

/// Expects that a grid of a camera shows what the whole images have at its pixels, to 1e-4: lens tables of
/// another size interpolate elsewhere.
void expect_same_pixels(const Twin& twin, std::size_t camera, const GridView& grid,
                        const std::vector<ImageF>& all) {
  const std::vector<ImageF> thin = render_grid(renderer(), twin, camera, grid, 9);
  ASSERT_EQ(thin.size(), all.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    ASSERT_EQ(thin[k].width, grid.width);
    ASSERT_EQ(thin[k].height, grid.height);
    const double brightest = *std::max_element(all[k].data.begin(), all[k].data.end());
    double largest = 0.0;
    for (int y = 0; y < grid.height; ++y)
      for (int x = 0; x < grid.width; ++x)
        largest = std::max(largest, std::abs(static_cast<double>(thin[k](x, y)) -
                                             static_cast<double>(all[k].data[grid.pixel_of(x, y, kWidth)])));
    EXPECT_LE(largest, 1e-4 * brightest)
        << "camera " << camera << " stride " << grid.stride << " image " << k;
  }
}

TEST(Sensitivity, AThinnedViewShowsTheSamePixels) {
  Twin twin = window_on_the_sphere();
  twin.cameras[0].vignetting.kind = Vignetting::Kind::polynomial;  // follows the whole image
  twin.cameras[0].vignetting.a[0] = -0.3;
  twin.cameras[0].vignetting.tilt[0] = 0.1;
  for (std::size_t camera = 0; camera < 2; ++camera) {
    const std::vector<ImageF> all = renderer().render(twin, camera, {Sampler::gauss, 9}).irradiance;
    for (const int stride : {1, 3, 4}) {
      const std::size_t n = kWidth * kHeight, square = static_cast<std::size_t>(stride * stride);
      const std::size_t most = (n + square - 1) / square;
      const GridView grid = choose_grid(twin.cameras[camera], kWidth * kHeight, most);
      ASSERT_EQ(grid.stride, stride);
      EXPECT_GE(grid.first_x + grid.stride * grid.width, kWidth - grid.stride + 1);  // up to the border
      expect_same_pixels(twin, camera, grid, all);
      ImageU8 mask(kWidth, kHeight, 0);
      for (int y = 12; y < 31; ++y)
        for (int x = 9; x < 20; ++x) mask(x, y) = 1;
      const GridView part = cut_to(grid, twin.cameras[camera], mask);
      EXPECT_GE(part.first_x, 9);
      EXPECT_LT(part.first_x + part.stride * (part.width - 1), 20);
      EXPECT_GE(part.first_y, 12);
      EXPECT_LT(part.first_y + part.stride * (part.height - 1), 31);
      EXPECT_EQ(part.width, (19 - part.first_x) / stride + 1);
      expect_same_pixels(twin, camera, part, all);
    }
  }
}

TEST(Sensitivity, NothingIsThinnedWhereNeighboursMatter) {
  Camera camera = window_on_the_sphere().cameras[0];
  EXPECT_EQ(choose_grid(camera, kWidth * kHeight, 100).stride, 9);
  EXPECT_EQ(choose_grid(camera, 100, 100).stride, 1);
  camera.psf_px = 0.7;
  EXPECT_EQ(choose_grid(camera, kWidth * kHeight, 100).stride, 1);
  ImageU8 mask(kWidth, kHeight, 0);
  mask(5, 5) = 1;
  EXPECT_EQ(cut_to(choose_grid(camera, 100, 100), camera, mask).width, kWidth);
}

/// A wall that ends in the middle of the view, its edge a little slanted.
Twin half_a_wall() {
  Twin twin = window_on_the_sphere();
  const Eigen::Vector3d middle = testing::physical_sphere().center_mm, normal(0, 0, -1),
                        u = Eigen::Vector3d(1.0, 0.03, 0.0).normalized();
  twin.objects[0].shape = PlaneShape{middle - 100.0 * u, normal, Eigen::Vector2d(200, 200), u};
  return twin;
}

TEST(Sensitivity, EdgesAreLeftOutAndNothingElse) {
  const Twin twin = half_a_wall();
  GridSamples s = samples_of(twin, 0, whole());
  const std::size_t k = s.images.size();
  Sensitivity sensitivity(renderer(), {s});
  const std::size_t n = sensitivity.leave_out_edges(twin);
  EXPECT_LE(n, 4u * kHeight);  // the edge and a pixel on each side, two where it changes columns
  std::size_t left_out = 0;
  for (int y = 0; y < kHeight; ++y) {
    const auto row = static_cast<std::size_t>(y * kWidth);
    const auto bright = [&](int x) {
      const auto first =
          s.real_dn.begin() + static_cast<std::ptrdiff_t>((row + static_cast<std::size_t>(x)) * k);
      return *std::max_element(first, first + static_cast<std::ptrdiff_t>(k)) > kBlack + 1;
    };
    int edge = 0;  // the first pixel beyond the wall
    while (edge < kWidth && bright(edge)) ++edge;
    ASSERT_GT(edge, 2);
    ASSERT_LT(edge, kWidth - 2);
    for (int x = 0; x < kWidth; ++x) {
      const bool out = sensitivity.samples()[0].weight[(row + static_cast<std::size_t>(x)) * k] == 0.0F;
      left_out += out ? 1u : 0u;
      EXPECT_TRUE(out || x != edge) << x << ' ' << y;
      EXPECT_FALSE(out && std::abs(x - edge) > 3) << x << ' ' << y;
    }
  }
  EXPECT_EQ(left_out, n);
}

TEST(Sensitivity, NothingIsLeftOutWhereAllIsSmooth) {
  const Twin twin = window_on_the_sphere();
  Sensitivity sensitivity(renderer(), {samples_of(twin, 0, whole()), samples_of(twin, 1, whole())});
  EXPECT_EQ(sensitivity.leave_out_edges(twin), 0u);
}

TEST(Sensitivity, AllIsKeptWhereMostWouldBeLeftOut) {
  const Twin twin = window_on_the_sphere();
  GridSamples s = samples_of(twin, 0, whole());
  std::fill(s.weight.begin(), s.weight.end(), 1e9F);  // no rule of points is so exact
  Sensitivity sensitivity(renderer(), {std::move(s)});
  EXPECT_EQ(sensitivity.leave_out_edges(twin), 0u);
}

class Planted : public ::testing::TestWithParam<const char*> {};

TEST_P(Planted, AStepFindsASmallChange) {
  const Twin twin = window_on_the_sphere();
  const std::string group = GetParam();
  const std::vector<Parameter> parameters = parameters_of(twin, group);
  Eigen::VectorXd planted = start_values(parameters);
  for (Eigen::Index k = 0; k < planted.size(); ++k)  // at most a hundredth of a fringe
    planted[k] += (k % 2 == 0 ? 1.0 : -0.7) * parameters[static_cast<std::size_t>(k)].step;
  const Twin truth = with_values(twin, parameters, planted);
  for (const auto how : {Sensitivity::Derivative::quick, Sensitivity::Derivative::exact}) {
    std::vector<GridSamples> samples;
    for (std::size_t c = 0; c < 2; ++c) {
      samples.push_back(samples_of(truth, c, whole()));
      samples.back().black_level_dn += 0.3;  // the sensor is found with it
    }
    Sensitivity sensitivity(renderer(), std::move(samples));
    const NormalEquations e = sensitivity.equations(twin, parameters, start_values(parameters), false, how);
    std::vector<std::size_t> unknowns;
    for (std::size_t k = 0; k < parameters.size(); ++k) unknowns.push_back(k);
    for (std::size_t c = 0; c < 2; ++c) unknowns.push_back(e.black_at(c));
    const Step step = solve_step(e, unknowns);
    for (Eigen::Index k = 0; k < planted.size(); ++k) {
      const Parameter& p = parameters[static_cast<std::size_t>(k)];
      EXPECT_NEAR(step.change[k], planted[k] - p.start, 0.01 * std::abs(planted[k] - p.start)) << p.name;
    }
    for (std::size_t c = 0; c < 2; ++c)
      EXPECT_NEAR(step.change[static_cast<Eigen::Index>(e.black_at(c))], -0.3, 0.01);
    EXPECT_LT(step.chi2, 1e-2 * e.chi2);
    EXPECT_EQ(step.n_determined, static_cast<int>(unknowns.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(Groups, Planted, ::testing::Values("pose", "vignetting", "albedo", "blur"),
                         [](const auto& tested) { return std::string(tested.param); });

/// A flat field of fringes of four steps, with noise of 3 DN and errors that all images of a pixel share.
struct ScatteredFringes {
  Fringes fringes;
  GridSamples samples;
  Sensitivity::Values predicted;
  explicit ScatteredFringes(double shared_dn) {
    constexpr int kAcross = 320, kDown = 256;
    constexpr double kNoise = 3.0;
    fringes.directions.emplace_back().pitches_px = {16.0};
    samples.grid = {1, 0, 0, kAcross, kDown};
    samples.images = {0, 1, 2, 3};
    samples.gain_dn = kGain;
    samples.black_level_dn = kBlack;
    samples.scatter_dn2 = Eigen::Matrix4d::Constant(shared_dn * shared_dn);
    predicted.resize(1);
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < std::size_t{kAcross} * kDown; ++i) {
      samples.cell.push_back(i);
      const double off = shared_dn * normal(random);
      for (const int k : samples.images) {
        const double phase = std::numbers::pi * (static_cast<double>(i % kAcross) / 8.0 + k / 2.0);
        predicted[0].push_back(static_cast<float>(10.0 + 5.0 * std::cos(phase)));
        samples.real_dn.push_back(static_cast<float>(kGain * static_cast<double>(predicted[0].back()) +
                                                     kBlack + off + kNoise * normal(random)));
        samples.weight.push_back(static_cast<float>(1.0 / std::hypot(kNoise, shared_dn)));
      }
    }
  }
  std::vector<CauseRegion> regions() const {
    return cause_regions(Sensitivity(renderer(), {samples}), fringes, predicted);
  }
};

TEST(Sensitivity, RegionsAddUpWhatIsOffInAPixelAsAWholeOverItsImagesNotOverPixels) {
  ScatteredFringes scattered(3.0);
  for (const CauseRegion& kind : scattered.regions()) EXPECT_NEAR(kind.chi2, 1.0, 0.12) << kind.kind;
  // 0.9 DN on all values: 64 pixels of 4 add up to (256 0.9)^2, against 64 (4 9 + 16 9)
  for (float& real : scattered.samples.real_dn) real += 0.9F;
  EXPECT_NEAR(scattered.regions()[0].chi2, 1.0 + 53'084.0 / 11'520.0, 0.6);
}

TEST(Sensitivity, WithAnOffsetOfEachPixelNoLevelIsTold) {
  ScatteredFringes bent(0.0);
  for (std::size_t i = 0; i < bent.samples.weight.size();
       ++i) {  // noise of photons, and a response that bends
    const auto dn = static_cast<double>(bent.samples.real_dn[i]);
    bent.samples.weight[i] = static_cast<float>(1.0 / std::sqrt(9.0 + dn / 2.0));
    bent.samples.real_dn[i] += static_cast<float>(1e-3 * dn * dn);
  }
  for (const FreePerPixel free : {FreePerPixel::offset, FreePerPixel::factor_and_offset}) {
    const std::vector<CauseRegion> regions =
        cause_regions(Sensitivity(renderer(), {bent.samples}), bent.fringes, bent.predicted, free);
    EXPECT_EQ(regions[0].kind, std::string("level"));
    EXPECT_EQ(regions[0].n, 0) << "an offset is a level";
    EXPECT_GT(regions[2].n, 1000) << "of the shift, which no number of a pixel takes";
    EXPECT_EQ(regions[1].n > 1000, free == FreePerPixel::offset) << "a factor takes the contrast";
  }
}

TEST(Sensitivity, StandardErrorsAreThoseOfTheNormalEquations) {
  NormalEquations e{Eigen::MatrixXd(3, 3), Eigen::VectorXd(3), 100.0, 50, 1};
  e.normal << 4, 1, 0, 1, 9, 0, 0, 0, 16;
  e.right << 2, 3, 8;
  const Step all = solve_step(e, {0, 1, 2});
  const Eigen::Matrix3d inverse = Eigen::Matrix3d(e.normal).inverse();
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(all.change[i], (inverse * e.right)[i], 1e-12);
    EXPECT_NEAR(all.sigma[i], std::sqrt(inverse(i, i)), 1e-12);
  }
  EXPECT_NEAR(all.chi2, 100.0 - e.right.dot(inverse * e.right), 1e-12);
  const Step one = solve_step(e, {2});
  EXPECT_EQ(one.change[0], 0.0);
  EXPECT_NEAR(one.change[2], 0.5, 1e-12);
  e.normal(1, 1) = 0.25;  // now the first two are the same unknown: 4 * 0.25 = 1 * 1
  const Step degenerate = solve_step(e, {0, 1, 2});
  EXPECT_EQ(degenerate.n_determined, 2);
  EXPECT_TRUE(degenerate.change.allFinite());
}

}  // namespace
}  // namespace fringetwin::compare::sensitivity_test
