// SPDX-License-Identifier: Apache-2.0
#include "render/indirect/indirect_trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "render/base/pixel_list.hpp"
#include "render/indirect/light_cells.hpp"
#include "render/indirect/light_lattice.hpp"
#include "render/indirect/mirror_places.hpp"
#include "render/trace/pixel_blocks.hpp"
#include "render/trace/sum_targets.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::render {
namespace {

// Light over other surfaces is interpolated to so much of itself.
constexpr float kTolerance = 0.004F;
// What interpolation leaves of it on average (tests/accuracy/bounces_test.cpp: 1.2e-3 in a groove).
constexpr double kInterpolated = 1.5e-3;
// Places from which cells are looked for.
constexpr std::size_t kPlacesForCells = 4096;
// Where a pixel that an edge crosses is looked through, sides from its middle: 2 x 2 points of Gauss's rule.
constexpr double kPoint = 0.28867513459481287;
// Numbers of a place besides its light: Gathered::towards().
constexpr std::size_t kTowards = 3;
// Of the directions of a place so many serve its lobe, which takes them of a smaller part of what is around.
constexpr std::size_t kForLobe = 2;

class IndirectLight {
 public:
  IndirectLight(TraceDevice& device, const TraceJob& job) : device_(device), job_(job) { look(); }

  void add(const std::vector<PassPlan>& passes) {
    if (seen_.places.empty()) return;
    job_.mirrors = upload_mirrors(device_, job_, seen_.places);
    find_cells(passes.front());
    look_at_edges();
    for (std::size_t i = 0; i < passes.size(); ++i) {
      if (job_.cells) cells_->upload(device_, job_, passes[i], i == 0);
      add_layer(of_reflectivity_, passes[i], i == 0);
      if (is_glossy(job_)) add_layer(of_lobes_, passes[i], i == 0);
    }
    widen_estimate();
  }

 private:
  /// Light that is interpolated by itself: what comes of surfaces' reflectivity, or of their lobes.
  struct Layer {
    Gatherer::By by;
    std::size_t more;  ///< numbers of a place besides its light
    std::size_t directions;
    std::optional<LightLattice> lattice = std::nullopt;
    std::vector<float> shares = {};  ///< per pixel: of the light, what it sends to the camera
  };

  std::size_t directions(std::size_t one_of) const {
    const auto all = static_cast<std::size_t>(std::max(2, job_.twin.render.bounce_samples));
    return std::max<std::size_t>(2, all / one_of / 2 * 2);
  }

  // Views whose pixels stand apart, as the search for causes has them, have squares as large as the image's.
  int first_step_px() const {
    const double side_px = job_.twin.sampled_side_px(job_.camera);
    return std::clamp(static_cast<int>(std::lround(LightLattice::kFirstStepPx * side_px)), 1,
                      LightLattice::kFirstStepPx);
  }

  // Finds what all pixels see, and those that an edge crosses.
  void look() {
    const int width = job_.camera.lens.width(), height = job_.camera.lens.height();
    std::vector<std::uint32_t> pixels;
    for (const std::uint32_t block : job_.blocks) {
      const auto [x0, y0] = corner_of(block);
      for (int y = y0; y < std::min(y0 + BLOCK_HEIGHT, height); ++y)
        for (int x = x0; x < std::min(x0 + BLOCK_WIDTH, width); ++x)
          pixels.push_back(static_cast<std::uint32_t>(y * width + x));
    }
    std::ranges::sort(pixels);
    seen_ = seen_image(width, height, look_at(device_, job_, pixels),
                       first_step_px() / (LightLattice::kFirstStepPx / 2));
    std::ranges::copy_if(pixels, std::back_inserter(edges_),
                         [this](std::uint32_t pixel) { return edge_crosses(pixel); });
  }

  // Returns whether a pixel and one beside it do not see the same surface.
  bool edge_crosses(std::uint32_t pixel) {
    const int x = static_cast<int>(pixel) % seen_.width, y = static_cast<int>(pixel) / seen_.width;
    const SurfaceLimits limits = roughness_.at(1).widened(kRough, x, y);
    for (const auto& [dx, dy] : {std::array{-1, 0}, std::array{1, 0}, std::array{0, -1}, std::array{0, 1}}) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= seen_.width || v >= seen_.height) continue;
      const auto other = static_cast<std::size_t>(v * seen_.width + u);
      if (seen_.sees(pixel) != seen_.sees(other)) return true;
      if (seen_.sees(pixel) && !on_one_surface(seen_.place(pixel), seen_.place(other), limits)) return true;
    }
    return false;
  }

  void find_cells(const PassPlan& first_pass) {
    if (job_.twin.render.bounces < 2) return;
    std::vector<SurfacePlace> some;
    const std::size_t step = (seen_.places.size() + kPlacesForCells - 1) / kPlacesForCells;
    // by the golden ratio: regular steps could follow the rows
    for (std::size_t i = 0; i < seen_.places.size() / step; ++i)
      some.push_back(seen_.places[(i * step + (i * 40503) % step) % seen_.places.size()]);
    cells_.emplace(device_, job_, first_pass, some);
    if (cells_->size() > 0) job_.cells = cells_->lookup();
  }

  bool has_lobe(const SurfacePlace& place) const {
    const auto primitive = static_cast<std::size_t>(place.primitive);
    return job_.scene.materials[primitive].y > 0.0F;
  }

  void add_layer(Layer& layer, const PassPlan& pass, bool first_pass) {
    Gatherer gatherer(device_, job_, pass, layer.directions, false, layer.by);
    const LightLattice::Gather gather = [&](const std::vector<std::uint32_t>& pixels) {
      return light_of(layer, gatherer, pass, pixels);
    };
    if (!layer.lattice)
      layer.lattice.emplace(seen_, roughness_, light_channels(pass), light_channels(pass) + layer.more,
                            kTolerance, gather, first_step_px());
    if (first_pass) find_shares(layer, light_channels(pass));
    add_pass(layer, pass, first_pass,
             first_pass ? layer.lattice->values() : gather(layer.lattice->pixels()).values);
  }

  LightOfPixels light_of(const Layer& layer, Gatherer& gatherer, const PassPlan& pass,
                         const std::vector<std::uint32_t>& pixels) const {
    const bool by_lobe = layer.by == Gatherer::By::lobe;
    const std::size_t numbers = light_channels(pass) + layer.more;
    LightOfPixels light;
    light.values.assign(pixels.size() * numbers, 0.0F);
    light.sigma.assign(pixels.size(), 0.0F);
    std::vector<SurfacePlace> places;
    std::vector<std::size_t> of_place;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (by_lobe) light.beside.push_back(diffuse_light_.data[pixels[i]]);
      if (by_lobe && !has_lobe(seen_.place(pixels[i]))) continue;
      places.push_back(seen_.place(pixels[i]));
      places.back().number = static_cast<float>(pixels[i] % (1U << 24));
      of_place.push_back(i);
    }
    for (std::size_t first = 0; first < places.size(); first += gatherer.most_at_a_time()) {
      const Gathered from =
          gatherer.gather({&places[first], std::min(gatherer.most_at_a_time(), places.size() - first)});
      for (std::size_t i = 0; i < from.n; ++i) {
        float* value = &light.values[of_place[first + i] * numbers];
        *value++ = from.sum(0, i);
        for (std::size_t c = 2; c < pass.channels(); ++c) *value++ = from.sum(c, i);
        const Eigen::Vector3f towards = from.towards(i, places[first + i].n);
        for (std::size_t k = 0; k < layer.more; ++k) *value++ = towards[static_cast<Eigen::Index>(k)];
        light.sigma[of_place[first + i]] = from.sigma(i);
      }
    }
    return light;
  }

  void add_pass(const Layer& layer, const PassPlan& pass, bool first_pass, const std::vector<float>& values) {
    const std::vector<SumTarget> targets = sum_targets(job_.twin, pass, first_pass, job_.out);
    const bool by_lobe = layer.by == Gatherer::By::lobe;
    for (std::size_t c = 0; c < targets.size(); ++c) {
      if (c == 1 || !targets[c].image) continue;  // the hits
      const ImageF light =
          layer.lattice->interpolated(values, light_channels(pass) + layer.more, c == 0 ? 0 : c - 1);
      if (first_pass && c == 0 && !by_lobe && is_glossy(job_)) keep_diffuse(light, layer.shares);
      ImageF& out = *targets[c].image;
      for (std::size_t i = 0; i < out.size(); ++i)
        if (seen_.sees(i) && !is_edge_[i]) out.data[i] += targets[c].factor * light.data[i] * layer.shares[i];
      for (const Part& part : parts_)
        out.data[part.pixel] +=
            targets[c].factor * light.data[part.light_of] * part.share * (by_lobe ? 1.0F : part.reflectivity);
    }
  }

  void keep_diffuse(const ImageF& light, const std::vector<float>& shares) {
    diffuse_light_ = light;
    for (std::size_t i = 0; i < light.size(); ++i) diffuse_light_.data[i] *= shares[i];
  }

  // Finds what each pixel sends to the camera of the light around it: by its reflectivity, and by its own
  // normal, which light from one side meets more or less than the mean normal.
  // Lobes have sent it already.
  void find_shares(Layer& layer, std::size_t first_number) {
    constexpr float kMostOfMean = 3.0F;
    layer.shares.assign(seen_.at.size(), layer.by == Gatherer::By::lobe ? 1.0F : 0.0F);
    if (layer.by == Gatherer::By::lobe) return;
    const LightLattice& lattice = *layer.lattice;
    const std::array<ImageF, 3> towards{
        lattice.interpolated(lattice.values(), first_number + kTowards, first_number),
        lattice.interpolated(lattice.values(), first_number + kTowards, first_number + 1),
        lattice.interpolated(lattice.values(), first_number + kTowards, first_number + 2)};
    for (std::size_t i = 0; i < seen_.at.size(); ++i) {
      if (!seen_.sees(i)) continue;
      const Eigen::Vector3f& n = seen_.own_normals[static_cast<std::size_t>(seen_.at[i])];
      const float times =
          n.x() * towards[0].data[i] + n.y() * towards[1].data[i] + n.z() * towards[2].data[i];
      layer.shares[i] = seen_.place(i).reflectivity * std::clamp(times, 0.0F, kMostOfMean);
    }
  }

  // Finds what parts of the pixels that an edge crosses see, and pixels that see the same surfaces.
  void look_at_edges() {
    is_edge_.assign(seen_.at.size(), false);
    for (const std::uint32_t pixel : edges_) is_edge_[pixel] = true;
    const double point_px = kPoint * job_.twin.sampled_side_px(job_.camera);
    for (const double y : {-point_px, point_px})
      for (const double x : {-point_px, point_px}) {
        const SeenPlaces found = look_at(device_, job_, edges_, {x, y});
        for (std::size_t i = 0; i < found.pixels.size(); ++i)
          if (const auto like = seen_like(found.pixels[i], found.places[i]))
            parts_.push_back({found.pixels[i], *like, 0.25F, found.places[i].reflectivity});
      }
  }

  // Returns the pixel around another that sees the surface of a place nearest to it.
  std::optional<std::uint32_t> seen_like(std::uint32_t pixel, const SurfacePlace& place) {
    const int x = static_cast<int>(pixel) % seen_.width, y = static_cast<int>(pixel) / seen_.width;
    std::optional<std::uint32_t> best;
    float least = 0.0F;
    const SurfaceLimits limits = roughness_.at(1).widened(kRough, x, y);
    for (int v = std::max(0, y - 1); v <= std::min(seen_.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(seen_.width - 1, x + 1); ++u) {
        const auto other = static_cast<std::uint32_t>(v * seen_.width + u);
        if (!seen_.sees(other) || !on_one_surface(seen_.place(other), place, limits)) continue;
        const float distance = (seen_.place(other).p_mm - place.p_mm).norm();
        if (best && distance >= least) continue;
        best = other;
        least = distance;
      }
    return best;
  }

  // What the estimates have more: noise of the directions, where the light is interpolated alike in many
  // pixels.
  void widen_estimate() const {
    if (!job_.out->estimate) return;
    double reflectivity_sq = 0.0;
    for (const SurfacePlace& place : seen_.places)
      reflectivity_sq += std::pow(static_cast<double>(place.reflectivity), 2);
    const double reflectivity = std::sqrt(reflectivity_sq / static_cast<double>(seen_.places.size()));
    double noise = reflectivity * of_reflectivity_.lattice->noise(),
           light = reflectivity * of_reflectivity_.lattice->light();
    if (of_lobes_.lattice) {
      noise = std::hypot(noise, of_lobes_.lattice->noise());
      light = std::hypot(light, of_lobes_.lattice->light());
    }
    ErrorEstimate& estimate = *job_.out->estimate;
    const Sensor& sensor = job_.camera.sensor;
    // of a pattern 1/2 + 1/2 cos, the root mean square over its steps
    const double gray = std::sqrt(0.375) * noise * sensor.gain_dn / sensor.max_dn();
    estimate.gray = std::hypot(estimate.gray, gray);
    // inside surfaces a verdict counts the noise by itself: what pixels share for certain is the
    // interpolation
    const double shared = std::sqrt(0.375) * kInterpolated * light * sensor.gain_dn / sensor.max_dn();
    estimate.gray_inside = std::hypot(estimate.gray_inside, shared);
    // cosine and sine have half the variance of the mean each
    double per_amplitude = 0.0;
    for (std::size_t d = 0; d < job_.out->cosine.size(); ++d)
      per_amplitude = std::max(per_amplitude, rms_per_amplitude(d));
    estimate.phase_rad = std::hypot(estimate.phase_rad, std::sqrt(0.5) * noise * per_amplitude);
  }

  // Returns the root mean square of 1/amplitude of the finest fringes over pixels that they light.
  double rms_per_amplitude(std::size_t direction) const {
    constexpr double kLeast = 0.1;  // of the mean amplitude: others are edges and shadows
    const std::vector<double>& pitches = job_.twin.fringes.directions[direction].pitches_px;
    const auto finest = static_cast<std::size_t>(std::ranges::min_element(pitches) - pitches.begin());
    const ImageF &cosine = job_.out->cosine[direction][finest], &sine = job_.out->sine[direction][finest];
    if (cosine.empty()) return 0.0;
    std::vector<double> amplitudes;
    for (std::size_t i = 0; i < cosine.size(); ++i)
      if (const double a = std::hypot(static_cast<double>(cosine.data[i]), static_cast<double>(sine.data[i]));
          a > 0.0)
        amplitudes.push_back(a);
    if (amplitudes.empty()) return 0.0;
    const double mean =
        std::accumulate(amplitudes.begin(), amplitudes.end(), 0.0) / static_cast<double>(amplitudes.size());
    double sum = 0.0, n = 0.0;
    for (const double a : amplitudes)
      if (a > kLeast * mean) sum += 1.0 / (a * a), n += 1.0;
    return std::sqrt(sum / n);
  }

  struct Part {
    std::uint32_t pixel, light_of;
    float share, reflectivity;
  };
  TraceDevice& device_;
  TraceJob job_;
  SeenImage seen_;
  RoughnessAtSteps roughness_{seen_};
  std::vector<std::uint32_t> edges_;  // pixels that an edge crosses
  std::vector<bool> is_edge_;
  std::vector<Part> parts_;
  ImageF diffuse_light_;  // of the layer of reflectivity, where another follows
  Layer of_reflectivity_{.by = Gatherer::By::reflectivity, .more = kTowards, .directions = directions(1)};
  Layer of_lobes_{.by = Gatherer::By::lobe, .more = 0, .directions = directions(kForLobe)};
  std::optional<LightCells> cells_;
};

}  // namespace

void add_indirect_light(TraceDevice& device, const TraceJob& job, const std::vector<PassPlan>& passes) {
  if (job.camera.lens.width() >= kListLimitPx || job.camera.lens.height() >= kListLimitPx)
    throw UserError(ExitCode::usage, fmt::format("camera \"{}\"", job.camera.name),
                    fmt::format("light over other surfaces is rendered for images of less than {} px a side",
                                kListLimitPx),
                    "leave out [render] bounces");
  IndirectLight(device, job).add(passes);
}

}  // namespace fringetwin::render
