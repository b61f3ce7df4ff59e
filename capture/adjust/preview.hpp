// SPDX-License-Identifier: Apache-2.0
// Gives the numbers by which a user adjusts aperture, focus and exposure: saturation, modulation and focus of
// each camera.
#pragma once
#include <string>
#include <vector>

#include "capture/device/pattern_display.hpp"
#include "capture/record/step_frames.hpp"
#include "capture/record/streams.hpp"
#include "twin/twin.hpp"

namespace fringetwin::capture {

struct PreviewNumbers {
  std::string camera;
  double saturated_share = 0.0;  ///< pixels at full scale in any of the pictures
  double mean_dn = 0.0;          ///< over pixels and phase steps
  double lit_share = 0.0;        ///< pixels with min_modulation_dn and more, none of their values saturated
  /// Medians over these: amplitude B of the fringes, and B over their mean above black. A sinusoid blurred
  /// with a Gaussian sigma, in px of the projector, keeps exp(-2 pi^2 sigma^2/pitch^2) of it: the finest
  /// pitch shows the focus of projector and camera together, also on parts without any texture.
  double modulation_dn = 0.0, contrast = 0.0;
  /// Sharpness of the camera alone, on what texture and edges the part has: mean squared gradient (Sobel:
  /// Tenenbaum's measure, 1970) of the mean of the steps, where no fringes are, noise taken off, over the
  /// squared mean, per px^2. Dividing by brightness makes it comparable between exposures; gradients rather
  /// than Laplacians, which noise fools more easily (Pertuz, Puig, Garcia, Pattern Recognition 46, 2013).
  /// Compare values of one scene only.
  double focus = 0.0;
  std::string text() const;  ///< one line
};

/// Returns the numbers from N phase steps of one pitch and the first of them once more (`again`, for the
/// noise). Without phase steps, `steps` is {white, black}.
PreviewNumbers preview_numbers(const std::string& camera, const std::vector<ImageF>& steps,
                               const ImageF& again, const Sensor& sensor, double min_modulation_dn);

class Preview {
 public:
  /// Cameras run as long as it lives. Of `plan` it takes latency, settling frames, time-out.
  Preview(const Twin& twin, const Rig& rig, PatternDisplay& display, const CapturePlan& plan);
  /// Shows the steps of the finest pitch of the first direction once. Throws DeviceFault.
  std::vector<PreviewNumbers> look();

 private:
  const Twin& twin_;
  const Rig& rig_;
  PatternDisplay& display_;
  CapturePlan plan_;
  std::vector<Pattern> patterns_;
  Streams streams_;
};

}  // namespace fringetwin::capture
