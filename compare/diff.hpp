// SPDX-License-Identifier: Apache-2.0
// Subtracts two results: takes two result.json and returns their numbers side by side, for a text table or as
// JSON.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin::compare {

/// One number that both results have.
struct Difference {
  std::string name;  ///< "gain left gain_dn"
  double a = 0.0, b = 0.0;
  double z = 0.0;  ///< (b - a) / sqrt(sigma_a^2 + sigma_b^2); NaN where it is not known
};

struct Differences {
  std::string a, b;  ///< the runs, as they were named
  std::string verdict_a, verdict_b;
  std::size_t common_images = 0;      ///< that both runs read: what is made from them has no z
  std::size_t n_shared = 0;           ///< numbers that both have, standard errors among them
  std::vector<Difference> rows = {};  ///< without the standard errors
  std::vector<std::string> only_in_a = {}, only_in_b = {};
};

/// Returns the differences B - A of all numbers that both result.json have; rows are matched by their names
/// (object, camera, pattern, direction ...). z is known where both standard errors are, unless the runs share
/// images: their errors are then not independent. `a` and `b` name a result.json or the folder that holds it.
/// Throws UserError(input) for a missing file, broken JSON or another schema.
Differences diff_results(const std::filesystem::path& a, const std::filesystem::path& b);

/// Returns them as a table for people, and as JSON (docs/metrics/run.md, "Differences of two results").
std::string differences_text(const Differences& differences);
std::string differences_json(const Differences& differences);

}  // namespace fringetwin::compare
