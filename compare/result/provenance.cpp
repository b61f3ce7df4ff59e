// SPDX-License-Identifier: Apache-2.0
#include "compare/result/provenance.hpp"

#include <fmt/format.h>

#include <set>

#include "twin/base/sha256.hpp"

namespace fringetwin::compare {

std::string RenderNote::text() const {
  std::string out = samples ? fmt::format("{}, {} samples per pixel", sampler, *samples) : sampler;
  out += fmt::format(", {:.3g} rays per pixel", rays_per_pixel);
  if (double_precision) out += ", double precision";
  if (phase_error_rad && gray_error)
    out += fmt::format(", errors estimated at {:.1e} rad and {:.1e} of full scale", *phase_error_rad,
                       *gray_error);
  return out;
}

std::map<std::string, std::string> sha256_of_files(const std::vector<std::filesystem::path>& files) {
  const std::set<std::filesystem::path> unique(files.begin(), files.end());
  std::map<std::string, std::string> digests;
  for (const auto& file : unique)
    digests[file.string()] = sha256_of_file(
        file, "it was an input of this run and must stay in place until the result is written");
  return digests;
}

}  // namespace fringetwin::compare
