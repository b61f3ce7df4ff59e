// SPDX-License-Identifier: Apache-2.0
#include "study/monte_carlo/monte_carlo_study.hpp"
#include "study/uncertain/uncertain_file.hpp"
#include "twin/file/toml_reader.hpp"

namespace fringetwin::study {

std::vector<std::string> monte_carlo_keys() {
  std::vector<std::string> keys = with_uncertain_keys(
      {"coverage", "digits", "block_trials", "least_blocks", "most_trials", "sensitivity_rows"});
  keys.insert(keys.begin(), "record");
  return keys;
}

MonteCarloPlan read_monte_carlo(const TomlTable& root, const std::filesystem::path& twin_file) {
  MonteCarloPlan plan;
  plan.seed = root.integer("seed", 0, kMostSeed).value_or(1);
  plan.rule.coverage = read_coverage(root);
  plan.rule.digits = root.integer("digits", 1, 4).value_or(1);
  plan.rule.block_trials = root.integer("block_trials", 2, kMostPoints).value_or(100);
  plan.rule.least_blocks = root.integer("least_blocks", 2, kMostPoints).value_or(5);
  plan.most_trials = root.integer("most_trials", 2, kMostPoints).value_or(10'000);
  plan.sensitivity_rows = root.integer("sensitivity_rows", 0, kMostPoints).value_or(0);
  if (plan.sensitivity_rows > plan.most_trials)
    root.fail("sensitivity_rows", "must not exceed most_trials", "the rows are trials, too");
  static_cast<UncertainSettings&>(plan) = read_uncertain_settings(root, twin_file);
  return plan;
}

}  // namespace fringetwin::study
