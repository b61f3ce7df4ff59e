// SPDX-License-Identifier: Apache-2.0
// bench_ray_query: the driver's ray query (VK_KHR_ray_query over VK_KHR_acceleration_structure) beside the
// renderer's own BVH traversal (render/shaders/mesh.glsl). Both shaders get the same rays from the same
// table, write the same output and run in turns; timed is one dispatch over the frame with its submission and
// wait. No lens, no shading, no patterns: the traversal alone, with a table look-up and one 8-byte store per
// ray.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "bench/acceleration_structure.hpp"
#include "ray_bvh_spv.h"
#include "ray_query_spv.h"
#include "render/scene/mesh_geometry.hpp"
#include "tests/support/freeform.hpp"
#include "tests/support/paper_rig.hpp"
#include "twin/base/errors.hpp"

namespace {

using namespace fringetwin;
using render::Buffer;
using render::ComputePipeline;
using render::vk_check;
using render::vk_struct;
using render::VulkanDevice;

constexpr std::array kRayQueryExtensions{VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                         VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                         VK_KHR_RAY_QUERY_EXTENSION_NAME};

// The features that a ray query takes, as a chain for asking and for enabling.
struct RayQueryFeatures {
  VkPhysicalDeviceRayQueryFeaturesKHR query{};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structure{};
  VkPhysicalDeviceBufferDeviceAddressFeatures address{};

  explicit RayQueryFeatures(VkBool32 wanted) {
    query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
    structure.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
    address.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_BUFFER_DEVICE_ADDRESS_FEATURES;
    query.pNext = &structure;
    structure.pNext = &address;
    query.rayQuery = structure.accelerationStructure = address.bufferDeviceAddress = wanted;
  }
  RayQueryFeatures(const RayQueryFeatures&) = delete;
  RayQueryFeatures& operator=(const RayQueryFeatures&) = delete;
  bool all() const {
    return query.rayQuery && structure.accelerationStructure && address.bufferDeviceAddress;
  }
};

bool offers_ray_query(VkPhysicalDevice device) {
  std::uint32_t n = 0;
  vk_check(vkEnumerateDeviceExtensionProperties(device, nullptr, &n, nullptr),
           "vkEnumerateDeviceExtensionProperties");
  std::vector<VkExtensionProperties> offered(n);
  vk_check(vkEnumerateDeviceExtensionProperties(device, nullptr, &n, offered.data()),
           "vkEnumerateDeviceExtensionProperties");
  for (const char* name : kRayQueryExtensions)
    if (std::none_of(offered.begin(), offered.end(),
                     [name](const auto& e) { return std::strcmp(e.extensionName, name) == 0; }))
      return false;
  RayQueryFeatures features(VK_FALSE);
  auto all = vk_struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  all.pNext = &features.query;
  vkGetPhysicalDeviceFeatures2(device, &all);
  return features.all();
}

constexpr int kRounds = 3;
constexpr double kShadowOffset = 1e-6;  // of the largest coordinate, as the renderer's

struct Cost {
  double cpu_s = 0.0, wall_s = 0.0;
};

double cpu_now_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

template <class Work>
Cost cost_of(Work work) {
  const double cpu = cpu_now_s();
  const auto wall = std::chrono::steady_clock::now();
  work();
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - wall;
  return {cpu_now_s() - cpu, elapsed.count()};
}

// As in ray_bench.glsl.
struct Push {
  std::array<float, 12> T_object_cam;
  std::array<float, 4> light;
  std::array<std::uint32_t, 4> blocks_across;
};
struct Seen {
  std::uint32_t t_bits, triangle_and_state;
  float t() const { return std::bit_cast<float>(t_bits); }
  int triangle() const { return static_cast<int>(triangle_and_state >> 2) - 1; }
  std::uint32_t state() const { return triangle_and_state & 3; }
};
static_assert(sizeof(Seen) == 8);
constexpr std::uint32_t kNoShadowRay = 0, kShadowed = 2;

std::array<float, 12> rows(const Pose& T) {
  std::array<float, 12> out{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      out[static_cast<std::size_t>(4 * i + j)] = static_cast<float>(T.rotation(i, j));
    out[static_cast<std::size_t>(4 * i + 3)] = static_cast<float>(T.translation_mm[i]);
  }
  return out;
}

// Directions (x/z, y/z) of the pixels' centres; `zoom` narrows them around the image's middle.
std::vector<float> make_directions(const Lens& lens, double zoom) {
  std::vector<float> out(static_cast<std::size_t>(2 * lens.width() * lens.height()));
  const double middle_x = 0.5 * (lens.width() - 1), middle_y = 0.5 * (lens.height() - 1);
#pragma omp parallel for
  for (int y = 0; y < lens.height(); ++y)
    for (int x = 0; x < lens.width(); ++x) {
      const auto d = lens.unproject({middle_x + (x - middle_x) / zoom, middle_y + (y - middle_y) / zoom});
      FT_CHECK(d.has_value(), "the lens can be inverted");
      const auto i = static_cast<std::size_t>(2 * (y * lens.width() + x));
      out[i] = static_cast<float>(d->x() / d->z());
      out[i + 1] = static_cast<float>(d->y() / d->z());
    }
  return out;
}

// One way to trace, without (0) and with (1) shadow rays.
struct Way {
  std::string name;
  std::array<std::unique_ptr<ComputePipeline>, 2> pipelines;
  std::array<Cost, 2> best;
  std::array<std::vector<Seen>, 2> seen;
};

class Bench {
 public:
  Bench(VulkanDevice& device, const Twin& rig);
  void compare(const std::string& title, double zoom, const Eigen::Vector3d& light_mm);
  bool agreed() const { return agreed_; }

 private:
  void build_structures();
  void make_ways();
  double slope(std::size_t pixel, int triangle) const;
  void check(const std::string& what, std::size_t shadow);

  VulkanDevice& device_;
  const Lens& lens_;
  Pose T_cam_object_{rotation_from_vector({0.11, -0.23, 0.37}), {0.0, 0.0, 275.0}};
  render::MeshGeometry mesh_;
  std::vector<float> rays_;
  std::unique_ptr<Buffer> directions_, triangles_, nodes_, output_;
  std::unique_ptr<bench::AccelerationStructure> structure_;
  std::array<Way, 2> ways_;
  bool agreed_ = true;
};

Bench::Bench(VulkanDevice& device, const Twin& rig) : device_(device), lens_(rig.cameras[0].lens) {
  FT_CHECK(lens_.width() % BLOCK_WIDTH == 0 && lens_.height() % BLOCK_HEIGHT == 0, "whole blocks only");
  build_structures();
  constexpr VkBufferUsageFlags kTexels = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  const auto n = static_cast<std::size_t>(lens_.width() * lens_.height());
  directions_ = std::make_unique<Buffer>(device_, 2 * n * sizeof(float), kTexels, VK_FORMAT_R32G32_SFLOAT);
  output_ = std::make_unique<Buffer>(device_, n * sizeof(Seen), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  make_ways();
}

// Both builds, timed; the acceleration structure twice, as the first one compiles the driver's build shaders.
void Bench::build_structures() {
  const auto mesh = std::make_shared<Mesh>(testing::make_bumpy_icosphere(6, 35.0, testing::default_bumps()));
  const Cost own = cost_of([&] { mesh_ = render::build_mesh_geometry(mesh, "mesh"); });
  constexpr VkBufferUsageFlags kTexels = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  nodes_ = std::make_unique<Buffer>(device_, std::as_bytes(std::span(mesh_.bvh.nodes)).size(), kTexels,
                                    VK_FORMAT_R32G32B32A32_SINT);
  nodes_->upload(mesh_.bvh.nodes);
  triangles_ = std::make_unique<Buffer>(device_, std::as_bytes(std::span(mesh_.triangles)).size(),
                                        kTexels | bench::kAccelerationInput, VK_FORMAT_R32G32B32A32_SFLOAT);
  triangles_->upload(mesh_.triangles);
  // Vertices are relative to the mesh's centre.
  T_cam_object_.translation_mm = T_cam_object_ * mesh_.center_mm;
  const auto n = static_cast<std::uint32_t>(mesh_.bvh.order.size());
  const auto build = [&] {
    structure_ = std::make_unique<bench::AccelerationStructure>(device_, *triangles_, n, rows(T_cam_object_));
  };
  const Cost first = cost_of(build), again = cost_of(build);
  constexpr double kMib = 1024.0 * 1024.0;
  fmt::print("\nstructures over {} triangles\n", n);
  fmt::print("{:<44}{:>10}{:>10}{:>10}\n", "", "CPU ms", "wall ms", "MiB");
  fmt::print("{:<44}{:>10.0f}{:>10.0f}{:>10.1f}\n", "own BVH, with normals and leaf order", 1e3 * own.cpu_s,
             1e3 * own.wall_s, static_cast<double>(nodes_->bytes() + triangles_->bytes()) / kMib);
  fmt::print("{:<44}{:>10.0f}{:>10.0f}{:>10.1f}\n", "acceleration structure, first", 1e3 * first.cpu_s,
             1e3 * first.wall_s, static_cast<double>(structure_->bytes()) / kMib);
  fmt::print("{:<44}{:>10.0f}{:>10.0f}\n", "acceleration structure, again", 1e3 * again.cpu_s,
             1e3 * again.wall_s);
}

void Bench::make_ways() {
  constexpr VkDescriptorType kTexels = VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
  for (const bool query : {false, true}) {
    Way& way = ways_[query];
    way.name = query ? "ray query" : "own BVH";
    const std::vector<VkDescriptorType> types{
        kTexels, kTexels, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
        query ? VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR : kTexels};
    const std::span<const std::uint32_t> code =
        query ? std::span<const std::uint32_t>(ray_query_spv) : std::span<const std::uint32_t>(ray_bvh_spv);
    for (std::uint32_t shadow = 0; shadow < 2; ++shadow) {
      way.pipelines[shadow] = std::make_unique<ComputePipeline>(
          device_, code, types, std::vector<std::uint32_t>{shadow}, sizeof(Push), VK_NULL_HANDLE);
      way.pipelines[shadow]->bind(
          {directions_.get(), triangles_.get(), output_.get(), query ? nullptr : nodes_.get()});
      if (query) bench::bind_acceleration_structure(device_, *way.pipelines[shadow], 3, *structure_);
    }
  }
}

void Bench::compare(const std::string& title, double zoom, const Eigen::Vector3d& light_mm) {
  rays_ = make_directions(lens_, zoom);
  directions_->upload(rays_);
  const auto across = static_cast<std::uint32_t>(lens_.width() / BLOCK_WIDTH);
  const auto groups = across * static_cast<std::uint32_t>(lens_.height() / BLOCK_HEIGHT);
  const auto n = static_cast<std::size_t>(lens_.width() * lens_.height());
  const Push push{rows(T_cam_object_.inverse()),
                  {static_cast<float>(light_mm.x()), static_cast<float>(light_mm.y()),
                   static_cast<float>(light_mm.z()), static_cast<float>(kShadowOffset)},
                  {across}};
  for (int round = -1; round < kRounds; ++round)  // -1: compilation, page faults
    for (std::size_t shadow = 0; shadow < 2; ++shadow)
      for (Way& way : ways_) {
        const Cost cost =
            cost_of([&] { way.pipelines[shadow]->dispatch(groups, std::as_bytes(std::span(&push, 1))); });
        if (round <= 0) way.best[shadow] = {1e30, 1e30};
        way.best[shadow].cpu_s = std::min(way.best[shadow].cpu_s, cost.cpu_s);
        way.best[shadow].wall_s = std::min(way.best[shadow].wall_s, cost.wall_s);
        if (round >= 0) continue;
        way.seen[shadow].resize(n);
        std::memcpy(way.seen[shadow].data(), output_->read(n * sizeof(Seen)), n * sizeof(Seen));
      }

  const auto& seen = ways_[0].seen[1];
  const auto n_hits = std::count_if(seen.begin(), seen.end(), [](Seen s) { return s.triangle() >= 0; });
  const auto n_shadow =
      std::count_if(seen.begin(), seen.end(), [](Seen s) { return s.state() != kNoShadowRay; });
  fmt::print("\n{}, {} x {} rays ({:.1f} % hit), best of {} rounds in turns\n", title, lens_.width(),
             lens_.height(), 100.0 * static_cast<double>(n_hits) / static_cast<double>(n), kRounds);
  fmt::print("{:<44}{:>12}{:>10}{:>10}{:>10}{:>10}\n", "", "rays", "CPU s", "wall s", "Mrays/s", "own BVH");
  for (std::size_t shadow = 0; shadow < 2; ++shadow)
    for (const Way& way : ways_) {
      const Cost& cost = way.best[shadow];
      const double rays = static_cast<double>(n) + (shadow ? static_cast<double>(n_shadow) : 0.0);
      // A CPU device: what two free cores would do, whatever else runs.
      const double rate = device_.info().is_cpu ? 2e-6 * rays / cost.cpu_s : 1e-6 * rays / cost.wall_s;
      const double ratio = device_.info().is_cpu ? ways_[0].best[shadow].cpu_s / cost.cpu_s
                                                 : ways_[0].best[shadow].wall_s / cost.wall_s;
      fmt::print("{:<44}{:>12.0f}{:>10.4f}{:>10.4f}{:>10.2f}{:>9.2f}x\n",
                 way.name + (shadow ? ", primary and shadow rays" : ", primary rays"), rays, cost.cpu_s,
                 cost.wall_s, rate, ratio);
    }
  check("primary rays", 0);
  check("primary and shadow rays", 1);
}

// The plane of a triangle seen from the camera: |normal . d| turns a difference of depths along d = (x, y, 1)
// into one across the surface, which is what rounding can do at a grazing ray, too.
double Bench::slope(std::size_t pixel, int triangle) const {
  const auto k = static_cast<std::size_t>(3 * triangle);
  const Eigen::Vector3d n(mesh_.triangles[k].w, mesh_.triangles[k + 1].w, mesh_.triangles[k + 2].w);
  const Eigen::Vector3d d(rays_[2 * pixel], rays_[2 * pixel + 1], 1.0);
  return std::abs((T_cam_object_.rotation * n).dot(d));
}

// Equal work: the same rays must see the same things, but for rays within rounding of an edge.
void Bench::check(const std::string& what, std::size_t shadow) {
  const auto &own = ways_[0].seen[shadow], &query = ways_[1].seen[shadow];
  std::size_t n_hits = 0, one_only = 0, other_triangle = 0, n_dark = 0, other_state = 0;
  double along_mm = 0.0, across_mm = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    const bool hit = own[i].triangle() >= 0, hit_query = query[i].triangle() >= 0;
    n_hits += hit;
    n_dark += own[i].state() == kShadowed;
    one_only += hit != hit_query;
    if (!hit || !hit_query) continue;
    other_triangle += own[i].triangle() != query[i].triangle();
    other_state += own[i].state() != query[i].state();
    const double apart_mm = std::abs(static_cast<double>(own[i].t()) - static_cast<double>(query[i].t()));
    along_mm = std::max(along_mm, apart_mm);
    across_mm = std::max(across_mm, apart_mm * slope(i, own[i].triangle()));
    squares += apart_mm * apart_mm;
  }
  const auto hits = static_cast<double>(n_hits);
  fmt::print(
      "{}: {} hits; distances differ by rms {:.1e}, at most {:.1e} mm ({:.1e} mm across the surface)\n", what,
      n_hits, std::sqrt(squares / hits), along_mm, across_mm);
  fmt::print("  {} hits on another triangle, {} for one of the two only; {} in shadow, {} differ\n",
             other_triangle, one_only, n_dark, other_state);
  constexpr double kSameMm = 2e-4, kShare = 1e-4;  // floats at 300 mm are 3e-5 mm apart
  if (n_hits == 0 || across_mm > kSameMm ||
      static_cast<double>(one_only + other_triangle + other_state) > kShare * hits) {
    fmt::print("the two ways see different things: this comparison is void\n");
    agreed_ = false;
  }
}

}  // namespace

int main() {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    const RayQueryFeatures features(VK_TRUE);
    VulkanDevice device(
        "", {{kRayQueryExtensions.begin(), kRayQueryExtensions.end()}, &features.query, offers_ray_query});
    if (!device.has_extensions()) {
      fmt::print("bench_ray_query: {} ({}) has no ray query, nothing to compare\n", device.info().name,
                 device.info().driver);
      return 0;
    }
    fmt::print("ray query beside the own BVH on {} ({})\n", device.info().name, device.info().driver);
    const Twin rig = testing::paper_rig();  // the left camera is the world
    Bench bench(device, rig);
    bench.compare("paper rig, left camera", 1.0, rig.projector->T_proj_world.inverse().translation_mm);
    bench.compare("twice the focal length, light from the side", 2.0, {-400.0, 0.0, 150.0});
    fmt::print("\nMrays/s: {}; column \"own BVH\": its time / theirs (2 = twice as fast as the own BVH)\n",
               device.info().is_cpu ? "2 x rays / CPU time" : "rays / wall time");
    return bench.agreed() ? 0 : static_cast<int>(ExitCode::internal);
  } catch (const UserError& error) {
    fmt::print(stderr, "bench_ray_query: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_ray_query: {}\n", error.what());
    return static_cast<int>(ExitCode::internal);
  }
}
