// SPDX-License-Identifier: Apache-2.0
// Calibrates a rig photometrically from its captures: sensor, projector response, fringe MTF, vignetting.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/flat_field.hpp"
#include "calib/photometry/photon_transfer.hpp"
#include "calib/photometry/projector_response.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib {

/// Stills of one scene that nothing moved in, at one exposure.
struct StillSeries {
  std::string name;  ///< as the user gave it
  std::vector<ImageF> images;
  std::optional<double> exposure_ms;
};

/// All that is known of one camera.
struct CameraFrames {
  std::vector<CameraImages> captures;  ///< of one still scene; more than one: repeats
  std::vector<StillSeries> series;     ///< besides, each at one level of light
  std::vector<ImageF> dark, flat;
};

/// Mean level against exposure: level = black + slope * exposure.
struct ExposureLinearity {
  std::vector<double> exposure_ms, level_dn, residual_percent;  ///< of the line at that exposure
  Estimate slope_dn_per_ms, offset_dn;
  double worst_percent = 0.0;
};

struct CameraPhotometry {
  std::string camera;
  Sensor sensor;  ///< the twin's, with what was measured put in
  bool black_measured = false;
  Estimate black_level_dn, dark_noise_dn;  ///< of the dark images; dark noise needs two
  std::optional<PhotonTransfer> transfer;
  std::string noise_from;  ///< "repeats" or "phase steps"; empty when there is no transfer
  double flicker = 0.0;    ///< rms of the gain between repeats
  Saturation saturation;
  std::optional<ExposureLinearity> linearity;
  std::optional<FlatField> flat;
  std::vector<ProjectorPhotometry> directions;  ///< what this camera says of the projector
};

struct Photometry {
  std::vector<CameraPhotometry> cameras;
  /// Whose direction knows the projector best (smallest sigma): indices; -1 when none does.
  int projector_camera = -1, projector_direction = -1;
  std::vector<std::string> warnings;
  const ProjectorPhotometry* projector() const;
};

/// frames: one per camera of the twin. Throws UserError(input) when nothing at all can be told; what cannot
/// be told beside other things is a warning.
Photometry analyse_photometry(const Twin& twin, const std::vector<CameraFrames>& frames);

}  // namespace fringetwin::calib
