// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "study/uncertain/uncertain_file.hpp"
#include "study/volume_map/volume_map.hpp"
#include "twin/file/toml_reader.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {
namespace {

constexpr int kMostTrials = 10'000;
constexpr int kMostPositions = 512;  // 130,816 spacings

void read_lattice(const TomlTable& root, VolumeMapPlan* plan) {
  plan->center_mm = root.required_vector3("center_mm");
  plan->size_mm = root.required_vector3("size_mm");
  if ((plan->size_mm.array() < 0.0).any()) root.fail("size_mm", "must not be negative");
  const Eigen::Vector3d counts = root.required_vector3("counts");
  double n = 1.0;
  for (int k = 0; k < 3; ++k) {
    if (counts[k] < 1.0 || counts[k] > kMostPositions || counts[k] != std::floor(counts[k]))
      root.fail("counts", fmt::format("must be whole numbers from 1 to {}", kMostPositions));
    if ((counts[k] > 1.0) != (plan->size_mm[k] > 0.0))
      root.fail("counts", "must be 1 where size_mm is 0, and more than 1 elsewhere");
    plan->counts[k] = static_cast<int>(counts[k]);
    n *= counts[k];
  }
  if (n > kMostPositions)
    root.fail("counts", fmt::format("ask for {:.0f} positions, at most {} are possible", n, kMostPositions));
}

void need_fit(const TomlTable& root, const Twin& twin, const std::string& object) {
  for (const FitRequest& fit : twin.measure.fits)
    if (fit.object == object) return;
  root.fail("object", fmt::format("\"{}\" is not fitted by the twin", object),
            fmt::format("give it a [[measure.fit]] object = \"{}\"", object));
}

}  // namespace

std::vector<std::string> volume_map_keys() {
  return with_uncertain_keys({"object", "center_mm", "size_mm", "counts", "trials", "coverage"});
}

VolumeMapPlan read_volume_map(const TomlTable& root, const std::filesystem::path& twin_file) {
  VolumeMapPlan plan;
  plan.twin = twin_file;
  plan.object = root.required_string("object");
  const Twin twin = load_twin(twin_file);
  const Object* object = twin.find_object(plan.object);
  const auto* sphere = object == nullptr ? nullptr : std::get_if<SphereShape>(&object->shape);
  if (sphere == nullptr) root.fail("object", fmt::format("\"{}\" is no sphere of the twin", plan.object));
  plan.radius_mm = sphere->radius_mm;
  need_fit(root, twin, plan.object);
  read_lattice(root, &plan);
  plan.trials = root.integer("trials", 2, kMostTrials).value_or(20);
  const std::size_t points = plan.positions().size() * plan.trials;
  if (points > std::size_t{kMostPoints})
    root.fail("trials",
              fmt::format("asks for {} measurements, at most {} are possible", points, kMostPoints));
  plan.seed = root.integer("seed", 0, kMostSeed).value_or(1);
  plan.coverage = read_coverage(root);
  static_cast<UncertainSettings&>(plan) = read_uncertain_settings(root, twin_file);
  return plan;
}

}  // namespace fringetwin::study
