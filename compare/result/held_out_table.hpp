// SPDX-License-Identifier: Apache-2.0
// Holds the rows of what images were predicted to that took no part in the fit, and what each number of a row
// is. The formulas: docs/metrics/gray.md, "Held-out images".
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "compare/result/field_options.hpp"
#include "twin/base/constants.hpp"
#include "twin/image/image.hpp"

namespace fringetwin::compare {

/// One image that was predicted from others.
struct HeldOutRow {
  std::string camera, pattern;
  std::uint64_t fold = 0, folds = 0;
  double light_factor = kNaN, exposure_factor = kNaN;  ///< NaN: none was fitted
  double mean_dn = kNaN, rms_dn = kNaN, noise_dn = kNaN, fitted_dn = kNaN, predicted_dn = kNaN;
  double ratio = kNaN, ratio_sigma = kNaN;
  std::uint64_t n = 0;

  static void describe(auto& f) {
    using Row = HeldOutRow;
    f.name("camera", "camera of the twin", &Row::camera).shown({"camera"});
    f.name("pattern", "image of the sequence", &Row::pattern).shown({"image"});
    f.add("fold", "the fold that it is held out with, from 1", &Row::fold).shown({"fold"});
    f.add("folds", "how many folds the phase steps were dealt to", &Row::folds);
    f.add("light_factor",
          "the only number that is taken from the image itself, with exposure_factor: its light over that of "
          "the images fitted; null where light was not asked for",
          &Row::light_factor)
        .shown({"own light", "", Column::fixed, 4});
    f.add(
         "exposure_factor",
         "the same of its exposure, which is of the room's light, too; null where exposure was not asked for",
         &Row::exposure_factor)
        .shown({"own exposure", "", Column::fixed, 4});
    f.add("mean_dn", "mean of predicted - real", &Row::mean_dn)
        .shown({"mean", "DN", Column::signed_fixed, 3});
    f.positive("rms_dn", "rms of predicted - real", &Row::rms_dn).shown({"rms", "DN", Column::fixed, 3});
    f.positive("noise_dn", "rms noise of a gray value of this image", &Row::noise_dn)
        .shown({"noise", "DN", Column::fixed, 3});
    f.positive("fitted_dn", "rms standard error of the prediction, from what was fitted", &Row::fitted_dn)
        .shown({"of the fit", "DN", Column::fixed, 3});
    f.positive("predicted_dn", "root of the sum of both squares: what rms_dn would be of a right twin",
               &Row::predicted_dn)
        .shown({"predicted", "DN", Column::fixed, 3});
    f.positive("ratio", "rms_dn over predicted_dn; 1 where noise is all that the prediction lacks",
               &Row::ratio)
        .shown({"rms over predicted", "", Column::with_sigma});
    f.sigma("ratio_sigma", "its standard error in a right twin", &Row::ratio_sigma);
    f.add("n", "gray values used", &Row::n).shown({"n"});
  }
};

/// What is left of the image of a camera that is predicted worst.
struct HeldOutMap {
  std::string camera, pattern;
  double ratio = kNaN;                                ///< of its row
  int first_x_px = 0, first_y_px = 0, stride_px = 1;  ///< of the map's first pixel, and from one to the next
  ImageF sigmas;  ///< predicted - real over what is predicted of its size; NaN where nothing is used
};

struct HeldOutTables {
  std::vector<HeldOutRow> held_out;
};

}  // namespace fringetwin::compare
