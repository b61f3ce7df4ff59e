// SPDX-License-Identifier: Apache-2.0
#include "cosim/refined_into_twin.hpp"

#include <fmt/format.h>

#include "compare/refine/refine.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/merge/merge_into_twin.hpp"

namespace fringetwin::cosim {
namespace fs = std::filesystem;

void check_refined_into_twin(const Twin& twin, const std::vector<std::string>& refine, const fs::path& into) {
  if (refine.empty())
    throw UserError(ExitCode::usage, "--into " + into.string(), "has no values to put there",
                    "name what to fit with --refine");
  check_merge_into_twin(into, compare::refinable_tables(twin));
}

void put_refined_into_twin(const fs::path& dir, const Run& run, const fs::path& into) {
  const compare::Refinement* refinement = run.options.refinement ? &*run.options.refinement : nullptr;
  std::string why;
  if (refinement == nullptr || refinement->taken_back)
    why = "the refinement was taken back";
  else if (!refinement->converged)
    why = "the refinement has not converged";
  else if (run.refined_blocks.empty())
    why = "no value has changed";
  if (!why.empty()) {
    say(fmt::format("{} stays as it is: {}", into.string(), why));
    return;
  }
  std::vector<TomlBlock> blocks = run.refined_blocks;
  name_files_from(into, dir, {"texture"}, blocks);  // which lies beside refined.toml
  const std::size_t n = merge_into_twin(into, blocks);
  say(fmt::format("{} refined {} put into {}", n, n == 1 ? "value" : "values", into.string()));
}

}  // namespace fringetwin::cosim
