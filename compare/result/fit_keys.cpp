// SPDX-License-Identifier: Apache-2.0
#include "compare/result/fit_keys.hpp"

#include "measure/fit/shape_fits.hpp"

namespace fringetwin::compare {

std::string sigma_key(const std::string& key) {
  for (const char* unit : {"_mm", "_rad", "_px", "_dn", "_rad_0", "_rad_1", "_mm_0", "_mm_1"})
    if (key.size() > std::string(unit).size() && key.ends_with(unit))
      return key.substr(0, key.size() - std::string(unit).size()) + "_sigma" + unit;
  return key + "_sigma";
}

bool is_sigma_key(const std::string& key) { return key.find("sigma") != std::string::npos; }

bool is_direction_key(const std::string& key) { return key.starts_with("tilt_direction"); }

bool is_count_key(const std::string& key) { return key == "n" || key.starts_with("n_"); }

std::vector<std::string> keys_of_fit(const std::string& kind) {
  std::vector<std::string> keys;
  for_every_shape([&](const auto& shape) {
    if (kind == shape.kKind) keys = measure::fit_keys(shape);
  });
  return keys;
}

std::string alignment_of(const std::string& kind) {
  return kind == "mesh" ? "each side registered to the CAD surface (ICP, then Gauss-Newton)"
                        : "none: both sides in the rig's frame";
}

}  // namespace fringetwin::compare
