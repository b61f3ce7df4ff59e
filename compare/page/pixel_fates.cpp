// SPDX-License-Identifier: Apache-2.0
#include "compare/page/pixel_fates.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "report/text.hpp"

namespace fringetwin::compare {
namespace {

/// Cameras whose images are irradiance have no DN, and no limit in DN.
bool any_camera_has(const measure::Measurement& measurement, bool radiance) {
  return std::ranges::any_of(measurement.cameras,
                             [&](const measure::CameraDecode& c) { return c.radiance == radiance; });
}

std::string no_point_reason(const Twin& twin, const measure::Measurement& measurement) {
  const measure::TriangulationSummary& t = measurement.triangulation;
  if (!measure::can_triangulate(twin)) return "this rig and these fringes cannot be triangulated";
  const std::string rejected = report::count(t.n_rejected), mixed = report::count(t.n_mixed);
  if (twin.triangulate() == Triangulate::projector)
    return fmt::format(
        "{} rejected (no convergence, a jump of depth, isolated), {} at borders that mix two surfaces",
        rejected, mixed);
  return fmt::format(
      "{} without a match in the other image, {} with several, {} rejected (no convergence, a jump of "
      "depth, isolated), {} at borders that mix two surfaces",
      report::count(t.n_no_match), report::count(t.n_ambiguous), rejected, mixed);
}

/// Returns why the decoding took pixels for dark: what it holds against which limit.
std::string dark_reason(const Twin& twin, const measure::Measurement& measurement) {
  const bool code_alone = twin.fringes.steps == 0;
  const std::string amplitude = code_alone
                                    ? "the modulation of the code (half of white minus black, or of the "
                                      "largest difference of a pattern and its inverse)"
                                    : "the amplitude at some pitch";
  std::string reason = "background, shadow or dark surface: " + amplitude + " is ";
  const bool radiance = any_camera_has(measurement, true), gray_values = any_camera_has(measurement, false);
  if (radiance)
    reason += fmt::format(
        "below {:g} of what the brightest pixels of the image have, or not a number (these images are "
        "radiance, without DN: min_modulation_dn does not count)",
        measure::kRadianceModulation);
  if (radiance && gray_values) reason += ", in the other camera ";
  if (gray_values)
    reason += fmt::format(
        "below min_modulation_dn = {:g} of [measure]; expose longer, or lower it where noise allows",
        twin.measure.min_modulation_dn);
  return reason;
}

/// Returns why the place of a pixel in the projector's image remained unknown.
std::string no_order_reason(const Twin& twin, const measure::Measurement& measurement) {
  const std::string causes = "noise, edges, or a wrong description of the fringes";
  const std::string outside = "the coordinate lies outside the projector's image: ";
  if (twin.fringes.steps > 0) {
    const std::string with = twin.fringes.unwrap == Unwrap::gray ? "phase and code" : "pitches";
    return with + " contradict each other, or " + outside + causes;
  }
  const auto& gray = twin.fringes.directions.front().gray;
  const bool pairs = gray && gray->threshold == GrayCode::Threshold::inverse;
  const double least_dn = measure::DecodeOptions{}.min_bit_difference_dn;
  const std::string apart = pairs ? "pattern and inverse are not " : "the gray value is not ";
  const std::string least = !any_camera_has(measurement, false) ? pairs ? "twice the least modulation apart"
                                                                        : "the least modulation away from it"
                            : pairs                             ? fmt::format("{:g} DN apart", least_dn)
                                    : fmt::format("{:g} DN away from it", 0.5 * least_dn);
  return "a bit of the code is too near its threshold (" + apart + least + "), or " + outside + causes;
}

}  // namespace

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

std::string fate_name(PixelFate fate, bool first_camera, const Fringes& fringes) {
  switch (fate) {
    case PixelFate::point:
      return "carry a point";
    case PixelFate::decoded:
      return first_camera ? "are decoded, without a point" : "are decoded";
    case PixelFate::dark:
      return "show too little modulation";
    case PixelFate::no_order:
      return fringes.steps == 0 ? "have no certain word of the code" : "have no fringe order";
    case PixelFate::saturated:
      break;
  }
  return "are saturated";
}

std::string fate_reason(PixelFate fate, const Twin& twin, const measure::Measurement& measurement) {
  switch (fate) {
    case PixelFate::point:
      return "";
    case PixelFate::decoded:
      return no_point_reason(twin, measurement);
    case PixelFate::dark:
      return dark_reason(twin, measurement);
    case PixelFate::no_order:
      return no_order_reason(twin, measurement);
    case PixelFate::saturated:
      break;
  }
  return "a gray value of an image stands at the end of the sensor's range: expose shorter, or turn the "
         "projector down";
}

}  // namespace fringetwin::compare
