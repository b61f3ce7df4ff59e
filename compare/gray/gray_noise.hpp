// SPDX-License-Identifier: Apache-2.0
// Noise of the real gray values as far as the comparison knows it.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "compare/gray/gray_source.hpp"
#include "measure/decode/decode.hpp"
#include "measure/decode/phase_noise.hpp"

namespace fringetwin::compare {

/// Gray-value variance against the mean gray level: from the redundancy of the real images' own N steps
/// wherever N > 3, whatever noise the decode was told; else the twin's sensor model; else rounding.
class GrayNoise {
 public:
  /// `real`: decode of the real images, may be null. `use_steps`: phase steps compared, empty = all.
  GrayNoise(const GrayPair& pair, const measure::CameraDecode* real, const std::vector<int>& use_steps);

  /// DN^2, rounding of both sides included.
  double variance(double gray_dn) const;
  /// Of that, what rounding to whole gray values leaves.
  double rounding_dn2() const;
  const std::string& source() const { return source_; }
  /// From the images themselves.
  bool measured() const { return measured_.has_value(); }

 private:
  void estimate(const GrayPair& pair, const measure::CameraDecode& real, const std::vector<int>& steps,
                int steps_total);

  const Sensor& sensor_;
  bool radiance_;
  double added_ = 0.0;
  std::optional<measure::NoiseModel> measured_;
  std::string source_;
};

}  // namespace fringetwin::compare
