// SPDX-License-Identifier: Apache-2.0
#include "study/design/design_plan.hpp"

#include <memory>
#include <optional>

#include "study/plan/space_filling.hpp"
#include "study/plan/study_tables.hpp"

namespace fringetwin::study {
namespace {

/// Gives the settings of a design by their number, without noise seeds.
class DesignSettings {
 public:
  explicit DesignSettings(const DesignPlan& plan) : plan_(plan) {
    if (plan.is_sampled()) {
      size_ = static_cast<std::size_t>(plan.points);
      if (plan.design == Design::latin_hypercube) latin_.emplace(plan.points, dimensions(), plan.seed);
      return;
    }
    for (const Variation& variation : plan.vary) {
      values_.push_back(listed_values(variation));
      size_ = plan.design == Design::list ? values_.back().size() : size_ * values_.back().size();
    }
  }

  std::size_t size() const { return size_; }

  Settings operator[](std::size_t i) const {
    Settings out;
    if (plan_.is_sampled()) {
      const std::vector<double> place =
          latin_ ? latin_->point(i) : scrambled_sobol_point(i, dimensions(), plan_.seed);
      for (std::size_t d = 0; d < place.size(); ++d) assign_at(plan_.vary[d], place[d], &out);
      return out;
    }
    for (std::size_t d = values_.size(); d-- > 0;) {  // the first slowest
      const std::size_t n = values_[d].size();
      assign_listed(plan_.vary[d], values_[d], i % n, &out);
      if (plan_.design == Design::grid) i /= n;
    }
    return out;
  }

 private:
  int dimensions() const { return static_cast<int>(plan_.vary.size()); }

  DesignPlan plan_;
  std::size_t size_ = 1;
  std::vector<std::vector<std::string>> values_;  ///< of a grid or list, per variation
  std::optional<LatinHypercube> latin_;
};

}  // namespace

PointSequence design_points(const DesignPlan& plan) {
  const auto settings = std::make_shared<const DesignSettings>(plan);
  const auto seeds = static_cast<std::size_t>(plan.noise_seeds);
  return PointSequence(
      settings->size() * seeds, [settings, seeds, first = plan.first_noise_seed](std::size_t i) {
        return StudyPoint{static_cast<std::int64_t>(i), (*settings)[i / seeds], first + i % seeds};
      });
}

}  // namespace fringetwin::study
