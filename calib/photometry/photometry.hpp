// SPDX-License-Identifier: Apache-2.0
// Calibrates a rig photometrically from its captures: sensor, projector response, fringe MTF, vignetting.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/exposure_linearity.hpp"
#include "calib/photometry/flat_field.hpp"
#include "calib/photometry/photon_transfer.hpp"
#include "calib/photometry/pixel_maps.hpp"
#include "calib/photometry/projector_response.hpp"
#include "calib/photometry/response_fit.hpp"
#include "measure/light/light_factors.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/twin.hpp"

namespace fringetwin::calib {

/// All that is known of one camera.
struct CameraFrames {
  std::vector<CameraImages> captures;  ///< of one still scene; more than one: repeats
  std::vector<StillSeries> series;     ///< besides, each at one level of light
  std::vector<GrayImage> dark, flat;
};

struct CameraPhotometry {
  std::string camera;
  Sensor sensor;  ///< the twin's, with what was measured put in
  bool black_measured = false;
  /// Whether anything says the black level: dark images, or the twin's black_level_dn, be it 0. A twin
  /// without that key says nothing.
  bool black_known = false;
  Estimate black_level_dn, dark_noise_dn;  ///< of the dark images; dark noise needs two
  std::optional<PhotonTransfer> transfer;
  std::string noise_from;  ///< "repeats" or "phase steps"; empty when there is no transfer
  double flicker = 0.0;    ///< rms of the gain between repeats
  Saturation saturation;
  std::optional<ExposureLinearity> linearity;
  std::optional<ResponseFit> response;
  std::optional<FlatField> flat;
  std::optional<PixelMapEstimate> offsets, factors;  ///< of the pixels (dsnu, DN, and prnu)
  std::vector<ProjectorPhotometry> directions;       ///< what this camera says of the projector
  /// The light of each image of the first capture; nothing where its steps do not tell.
  std::optional<measure::LightFactors> light;
};

struct Photometry {
  std::vector<CameraPhotometry> cameras;
  /// Whose direction knows the projector best (smallest sigma): indices; -1 when none does.
  int projector_camera = -1, projector_direction = -1;
  std::vector<std::string> warnings;
  const ProjectorPhotometry* projector() const;
};

/// The factors of the images as a twin has them.
struct LightOfImages {
  std::vector<double> light_factors, sigma;  ///< of the projector
  /// Per camera: what its exposures do besides; empty where all cameras say the same.
  std::vector<std::vector<double>> exposure_factors;
};
/// Returns the mean of what the cameras say, weighted by their standard errors; where a camera's image
/// differs from the first one's by more than chance, that of the first, and what the others differ by.
/// Nothing where no image differs from the others by more than chance.
std::optional<LightOfImages> light_of_images(const Photometry& photometry);

/// frames: one per camera of the twin. Throws UserError(input) when nothing at all can be told; what cannot
/// be told beside other things is a warning.
Photometry analyse_photometry(const Twin& twin, const std::vector<CameraFrames>& frames);

}  // namespace fringetwin::calib
