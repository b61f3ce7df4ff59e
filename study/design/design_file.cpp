// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <set>

#include "render/base/sobol.hpp"
#include "study/design/design_plan.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::study {
namespace {

constexpr double kMostKeyValues =
    1e7;  // whoever runs them keeps them all, 100 to 200 bytes each: the most runs with 10 keys

Design read_scheme(const TomlTable& root) {
  const std::string name =
      root.choice("design", {"grid", "list", "latin-hypercube", "sobol"}).value_or("grid");
  if (name == "list") return Design::list;
  if (name == "latin-hypercube") return Design::latin_hypercube;
  return name == "sobol" ? Design::sobol : Design::grid;
}

std::size_t list_length(const Variation& v) {
  return v.range ? static_cast<std::size_t>(v.range->count.value_or(0)) : v.values.size();
}

/// Returns the number of points without their repetition by noise seeds.
double count_points(const TomlTable& root, const DesignPlan& plan) {
  if (plan.is_sampled()) return plan.points;
  double n = 1.0;
  const std::vector<TomlTable> tables = root.tables("vary");
  for (std::size_t i = 0; i < plan.vary.size(); ++i) {
    const auto length = static_cast<double>(list_length(plan.vary[i]));
    if (plan.design == Design::grid) {
      n *= length;
    } else {
      if (i > 0 && length != n)
        tables[i].fail("", fmt::format("has {} values, the first [[vary]] has {}", length, n),
                       "a list takes them side by side");
      n = length;
    }
  }
  return n;
}

void read_sampling(const TomlTable& root, DesignPlan* plan) {
  if (!plan->is_sampled()) {
    for (const char* key : {"points", "seed"})
      if (root.has(key)) root.fail(key, "has no effect with a grid or list");
    return;
  }
  plan->points = root.required_integer("points", 1, kMostPoints);
  plan->seed = root.integer("seed", 0, kMostSeed).value_or(1);
  if (plan->design == Design::sobol && plan->vary.size() > std::size_t{render::kSobolDimensions})
    root.fail("vary", fmt::format("is given {} times, a Sobol design takes at most {}", plan->vary.size(),
                                  render::kSobolDimensions));
}

}  // namespace

std::vector<std::string> design_keys() {
  return {"record", "design", "points", "noise_seeds", "first_noise_seed", "vary"};
}

DesignPlan read_design(const TomlTable& root) {
  DesignPlan plan;
  plan.design = read_scheme(root);
  plan.noise_seeds = root.integer("noise_seeds", 1, kMostPoints).value_or(1);
  plan.first_noise_seed = root.integer("first_noise_seed", 0, kMostSeed).value_or(1);
  std::set<std::string> taken;
  for (const TomlTable& table : root.tables("vary"))
    plan.vary.push_back(read_variation(table, plan.is_sampled(), &taken));
  read_sampling(root, &plan);
  if (plan.vary.empty() && (plan.noise_seeds == 1 || plan.is_sampled()))
    root.fail("vary", "is missing: the design is empty", "give a [[vary]], or noise_seeds of a plain grid");
  const double runs = count_points(root, plan) * plan.noise_seeds;
  if (runs > kMostPoints)
    root.fail("", fmt::format("asks for {:.0f} runs, at most {} are possible", runs, kMostPoints));
  double keys = 0.0;
  for (const Variation& variation : plan.vary) keys += static_cast<double>(variation.keys.size());
  if (runs * keys > kMostKeyValues)
    root.fail("vary",
              fmt::format("asks for {:.0f} runs with {:.0f} keys each, at most {:.0g} values are possible",
                          runs, keys, kMostKeyValues));
  return plan;
}

}  // namespace fringetwin::study
