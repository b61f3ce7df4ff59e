// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/measured_steps.hpp"

#include <fmt/format.h>

#include <numeric>

#include "twin/base/errors.hpp"

namespace fringetwin {
namespace {

constexpr std::size_t kStepsOfAPhase = 3;

bool uses(const MeasuredShape& shape, int step) {
  return shape.steps == "all" || (shape.steps == "even") == (step % 2 == 0);
}

std::string where(const Twin& twin, const Object& object) {
  return fmt::format("{}: [[object]] \"{}\"", twin.file.string(), object.name);
}

}  // namespace

std::vector<int> built_from_steps(const Twin& twin, const Object& object, const MeasuredShape& shape) {
  std::vector<int> used;
  if (twin.fringes.steps == 0) {  // a code alone is decoded whole
    if (shape.steps == "all") return used;
    throw UserError(
        ExitCode::usage, where(twin, object),
        fmt::format("steps = \"{}\" takes a part of the phase steps, and there are none", shape.steps),
        "set steps = \"all\": the shape is built from the whole code, and gray levels are compared");
  }
  for (int n = 0; n < twin.fringes.steps; ++n)
    if (uses(shape, n)) used.push_back(n);
  if (used.size() < kStepsOfAPhase)
    throw UserError(ExitCode::usage, where(twin, object),
                    fmt::format("steps = \"{}\" takes {} of the {} phase steps, and a phase needs {}",
                                shape.steps, used.size(), twin.fringes.steps, kStepsOfAPhase),
                    "record more phase steps or set steps = \"all\"");
  return used;
}

std::vector<int> left_over_steps(const Twin& twin) {
  const Object* last = nullptr;
  bool every_one_says_all = true;
  std::vector<int> left(twin.fringes.steps);
  std::iota(left.begin(), left.end(), 0);
  for (const Object& object : twin.objects) {
    const auto* shape = std::get_if<MeasuredShape>(&object.shape);
    if (shape == nullptr) continue;
    built_from_steps(twin, object, *shape);  // checks
    std::erase_if(left, [&](int n) { return uses(*shape, n); });
    every_one_says_all = every_one_says_all && shape->steps == "all";
    last = &object;
  }
  if (last == nullptr || every_one_says_all) return {};
  if (left.size() < kStepsOfAPhase)
    throw UserError(
        ExitCode::usage, where(twin, *last),
        fmt::format("the measured objects leave {} of the {} phase steps to compare with, and a phase "
                    "needs {}",
                    left.size(), twin.fringes.steps, kStepsOfAPhase),
        "give all measured objects the same steps (\"even\" or \"odd\"), record 6 or more phase steps, or "
        "set steps = \"all\" to compare gray levels only");
  return left;
}

}  // namespace fringetwin
