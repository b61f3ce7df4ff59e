// SPDX-License-Identifier: Apache-2.0
#include "render/base/specialise.hpp"

#include <spirv-tools/libspirv.h>

#include <cstring>
#include <spirv-tools/optimizer.hpp>
#include <string>
#include <unordered_map>

#include "render/base/disk_cache.hpp"

namespace fringetwin::render {
namespace {

std::vector<std::uint32_t> optimise(std::span<const std::uint32_t> spirv,
                                    std::span<const std::uint32_t> constants) {
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> values;
  for (std::uint32_t i = 0; i < constants.size(); ++i) values[i] = {constants[i]};
  spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
  // None of these passes moves or fuses arithmetic: images must not depend on the optimiser.
  optimizer.RegisterPass(spvtools::CreateSetSpecConstantDefaultValuePass(values))
      .RegisterPass(spvtools::CreateFreezeSpecConstantValuePass())
      .RegisterPass(spvtools::CreateFoldSpecConstantOpAndCompositePass())
      .RegisterPass(spvtools::CreateDeadBranchElimPass())
      .RegisterPass(spvtools::CreateBlockMergePass())
      .RegisterPass(spvtools::CreateEliminateDeadFunctionsPass())
      .RegisterPass(spvtools::CreateEliminateDeadConstantPass());
  spvtools::OptimizerOptions options;
  options.set_run_validator(false);  // the tests do
  std::vector<std::uint32_t> out;
  if (!optimizer.Run(spirv.data(), spirv.size(), &out, options)) out.clear();
  return out;
}

// Returns whether these are the instructions of a module, from its head to the end of its last function. What
// they mean is not looked at: the validator takes a third of the optimiser's time.
bool is_whole(std::span<const std::uint32_t> words) {
  constexpr std::uint32_t kMagic = 0x07230203, kMostIds = 0x3fffff,
                          kFunctionEnd = 56;  // SPIR-V 1.5, 2.3, 2.17
  constexpr std::size_t kHead = 5;
  if (words.size() < kHead || words[0] != kMagic || words[3] > kMostIds || words[4] != 0) return false;
  std::uint32_t last = 0;
  for (words = words.subspan(kHead); !words.empty(); words = words.subspan(words[0] >> 16)) {
    if (words[0] >> 16 == 0 || words[0] >> 16 > words.size()) return false;
    last = words[0] & 0xffff;
  }
  return last == kFunctionEnd;
}

}  // namespace

std::vector<std::uint32_t> specialised(std::span<const std::uint32_t> spirv,
                                       std::span<const std::uint32_t> constants,
                                       const std::optional<std::filesystem::path>& folder) {
  if (!folder) return optimise(spirv, constants);
  // The digest of this file (CMakeLists.txt) and the optimiser's version stand for the passes.
  const std::string maker = std::string(FRINGETWIN_CODE_DIGEST) + spvSoftwareVersionDetailsString();
  const std::string name = "shader-" + content_key({std::as_bytes(std::span(maker)), std::as_bytes(spirv),
                                                    std::as_bytes(constants)});
  std::vector<std::uint32_t> out;
  if (const auto bytes = read_cached(folder, name)) {
    out.resize(bytes->size() / sizeof(std::uint32_t));
    std::memcpy(out.data(), bytes->data(), out.size() * sizeof(std::uint32_t));
    if (is_whole(out)) return out;
  }
  out = optimise(spirv, constants);
  if (!out.empty()) write_cached(folder, name, {std::as_bytes(std::span<const std::uint32_t>(out))});
  return out;
}

}  // namespace fringetwin::render
