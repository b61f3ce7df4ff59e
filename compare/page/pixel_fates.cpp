// SPDX-License-Identifier: Apache-2.0
#include "compare/page/pixel_fates.hpp"

#include <fmt/format.h>

#include "report/text.hpp"

namespace fringetwin::compare {

Image<PixelFate> pixel_fates(const measure::Measurement& measurement, std::size_t camera) {
  const measure::CameraDecode& decode = measurement.cameras[camera];
  Image<PixelFate> fates(decode.width(), decode.height(), PixelFate::decoded);
  if (camera == 0) {
    const Image<int> points = measure::point_grid(measurement.cloud, decode.width(), decode.height());
    for (std::size_t i = 0; i < fates.size(); ++i)
      if (points.data[i] >= 0) fates.data[i] = PixelFate::point;
  }
  for (std::size_t i = 0; i < fates.size(); ++i) {
    const unsigned flags = decode.flags.data[i];
    if ((flags & measure::kLowModulation) != 0) fates.data[i] = PixelFate::dark;
    if ((flags & measure::kOrderInvalid) != 0 && (flags & measure::kUnseen) == 0)
      fates.data[i] = PixelFate::no_order;
    if ((flags & measure::kSaturated) != 0) fates.data[i] = PixelFate::saturated;
  }
  return fates;
}

std::string fate_name(PixelFate fate, bool first_camera) {
  switch (fate) {
    case PixelFate::point:
      return "carry a point";
    case PixelFate::decoded:
      return first_camera ? "are decoded, without a point" : "are decoded";
    case PixelFate::dark:
      return "show too little modulation";
    case PixelFate::no_order:
      return "have no fringe order";
    case PixelFate::saturated:
      break;
  }
  return "are saturated";
}

std::string fate_reason(PixelFate fate, const Twin& twin, const measure::Measurement& measurement) {
  const measure::TriangulationSummary& t = measurement.triangulation;
  switch (fate) {
    case PixelFate::point:
      return "";
    case PixelFate::decoded:
      return fmt::format(
          "{} without a match in the other image, {} with several, {} rejected (no convergence, a jump of "
          "depth, isolated), {} at borders that mix two surfaces",
          report::count(t.n_no_match), report::count(t.n_ambiguous), report::count(t.n_rejected),
          report::count(t.n_mixed));
    case PixelFate::dark:
      return fmt::format(
          "background, shadow or dark surface: the amplitude at some pitch is below min_modulation_dn = {:g} "
          "of [measure]; expose longer, or lower it where noise allows",
          twin.measure.min_modulation_dn);
    case PixelFate::no_order:
      return "pitches or code contradict each other, or the coordinate lies outside the projector's image: "
             "noise, "
             "edges, or a wrong description of the fringes";
    case PixelFate::saturated:
      break;
  }
  return "a gray value of an image stands at the end of the sensor's range: expose shorter, or turn the "
         "projector down";
}

}  // namespace fringetwin::compare
