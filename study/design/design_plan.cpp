// SPDX-License-Identifier: Apache-2.0
#include "study/design/design_plan.hpp"

#include "study/plan/space_filling.hpp"
#include "study/plan/study_tables.hpp"

namespace fringetwin::study {
namespace {

std::vector<Settings> grid(const DesignPlan& plan) {
  std::vector<Settings> all = {{}};
  for (const Variation& variation : plan.vary) {
    const std::vector<std::string> values = listed_values(variation);
    std::vector<Settings> longer;
    longer.reserve(all.size() * values.size());
    for (const Settings& settings : all)
      for (std::size_t i = 0; i < values.size(); ++i) {
        longer.push_back(settings);
        assign_listed(variation, values, i, &longer.back());
      }
    all = std::move(longer);
  }
  return all;
}

std::vector<Settings> list(const DesignPlan& plan) {
  std::vector<Settings> all;
  for (const Variation& variation : plan.vary) {
    const std::vector<std::string> values = listed_values(variation);
    all.resize(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) assign_listed(variation, values, i, &all[i]);
  }
  return all.empty() ? std::vector<Settings>{{}} : all;
}

std::vector<Settings> sampled(const DesignPlan& plan) {
  const auto dimensions = static_cast<int>(plan.vary.size());
  const UnitPoints points = plan.design == Design::sobol
                                ? scrambled_sobol(plan.points, dimensions, plan.seed)
                                : latin_hypercube(plan.points, dimensions, plan.seed);
  std::vector<Settings> all(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t d = 0; d < plan.vary.size(); ++d) assign_at(plan.vary[d], points[i][d], &all[i]);
  return all;
}

}  // namespace

std::vector<StudyPoint> design_points(const DesignPlan& plan) {
  const std::vector<Settings> all = plan.design == Design::grid   ? grid(plan)
                                    : plan.design == Design::list ? list(plan)
                                                                  : sampled(plan);
  std::vector<StudyPoint> points;
  points.reserve(all.size() * static_cast<std::size_t>(plan.noise_seeds));
  for (const Settings& settings : all)
    for (int k = 0; k < plan.noise_seeds; ++k)
      points.push_back({static_cast<std::int64_t>(points.size()), settings,
                        plan.first_noise_seed + static_cast<std::uint64_t>(k)});
  return points;
}

}  // namespace fringetwin::study
