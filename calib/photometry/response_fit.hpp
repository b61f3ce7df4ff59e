// SPDX-License-Identifier: Apache-2.0
// Fits the curve of a camera's gray values over the light from one still scene at many exposures.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calib/photometry/photon_transfer.hpp"
#include "twin/camera_response.hpp"
#include "twin/image/gray_image.hpp"

namespace fringetwin::calib {

/// One image of the series: the means of its blocks of 32 x 32 pixels, NaN where one is clipped.
struct ExposedBlocks {
  double exposure_ms = 0.0;
  std::vector<double> level_dn;
};
/// Returns the means of whole blocks over images of one exposure.
ExposedBlocks exposed_blocks(const std::vector<GrayImage>& images, double exposure_ms, double saturation_dn);

struct ResponseFit {
  CameraResponse response;
  std::vector<double> corner_sigma_dn;  ///< of each corner's out_dn over its in_dn
  Estimate dn_per_ms;                   ///< slope at the origin of the mean block
  Estimate delay_ms;                    ///< light counts from this part of the exposure on
  Estimate knee_dn;                     ///< gray value where the slope changes most
  Estimate knee_slope_ratio;            ///< slope beyond it over the slope before it
  bool has_knee = false;                ///< the ratio differs from 1 by 4 standard errors
  /// Every second exposure fitted, the others predicted: rms over the blocks, and with a factor of its own
  /// for the light of each predicted image, which is then told by that image.
  double held_out_rms_dn = 0.0, held_out_rms_own_light_dn = 0.0;
  std::vector<double> held_out_ms,
      held_out_image_dn;          ///< rms of each predicted image, without its own factor
  std::vector<double> own_light;  ///< the factors
};

/// Nothing with fewer than 16 exposures. Standard errors: jackknife over 8 groups of images, so that light
/// that varies from image to image is in them. Throws UserError(input) where the curve does not rise.
std::optional<ResponseFit> fit_response(std::vector<ExposedBlocks> images, double black_level_dn,
                                        const std::string& where);

}  // namespace fringetwin::calib
