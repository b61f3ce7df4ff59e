// SPDX-License-Identifier: Apache-2.0
#include "measure/description_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "measure/description/pitch_ratios.hpp"
#include "measure/swapped_images.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::measure {
namespace {

constexpr std::size_t kRays = 400;      ///< points at which the directions are compared
constexpr double kTellsLess = 1.0 / 3;  ///< of what the other direction would tell
constexpr double kStep_mm = 0.01;

/// Returns where the projector would show a point.
std::optional<Eigen::Vector2d> projector_pixel(const Twin& twin, const Eigen::Vector3d& p_world_mm) {
  return twin.projector->lens.project(twin.projector->T_proj_world * p_world_mm);
}

/// Returns what the rendered twin expects in a camera: the decoded coordinates of the directions it has; in
/// the first camera those of the other direction, too, from its points.
ExpectedCoordinates expected_coordinates(const Twin& twin, const Measurement& simulated, std::size_t camera) {
  ExpectedCoordinates out;
  const CameraDecode& decoded = simulated.cameras[camera];
  for (const DirectionDecode& d : decoded.directions)
    if (d.unwrapped) (d.axis == Axis::x ? out.x_px : out.y_px) = d.coordinate_px;
  ImageD& other = out.x_px.empty() ? out.x_px : out.y_px;
  if (camera != 0 || !other.empty() || !twin.projector) return out;
  other = ImageD(decoded.width(), decoded.height(), kNaN);
  const int axis = &other == &out.x_px ? 0 : 1;
  for (std::size_t i = 0; i < simulated.cloud.size(); ++i) {
    const Eigen::Vector2f& q = simulated.cloud.q_cam_px[i];
    if (const auto at = projector_pixel(twin, simulated.cloud.p_world_mm[i]))
      other(static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y()))) = (*at)[axis];
  }
  return out;
}

/// Returns a sentence where the only direction of the fringes tells much less of the depth than the other.
std::optional<std::string> weak_direction(const Twin& twin, const PointCloud& cloud) {
  if (!twin.projector || twin.triangulate() != Triangulate::projector ||
      twin.fringes.directions.size() != 1 || cloud.size() == 0)
    return std::nullopt;
  const Eigen::Vector3d camera_mm = twin.cameras[0].center_world_mm();
  std::vector<double> moved[2];
  for (std::size_t k = 0; k < kRays; ++k) {
    const Eigen::Vector3d& p_mm = cloud.p_world_mm[k * cloud.size() / kRays];
    const Eigen::Vector3d along = (p_mm - camera_mm).normalized();
    const auto near = projector_pixel(twin, p_mm), far = projector_pixel(twin, p_mm + kStep_mm * along);
    if (!near || !far) continue;
    for (const int axis : {0, 1}) moved[axis].push_back(std::abs((*far - *near)[axis]) / kStep_mm);
  }
  if (moved[0].empty()) return std::nullopt;
  const double px_per_mm[2] = {median(moved[0]), median(moved[1])};
  const int has = twin.fringes.directions[0].axis == Axis::x ? 0 : 1;
  if (px_per_mm[has] >= kTellsLess * px_per_mm[1 - has]) return std::nullopt;
  return fmt::format(
      "directions = [\"{}\"]: a millimetre of depth moves these fringes by {:.2g} px of the projector and "
      "fringes along \"{}\" by {:.2g} px, so that the depth would be {:.0f} times as exact: is that what was "
      "projected?",
      has == 0 ? "x" : "y", px_per_mm[has], has == 0 ? "y" : "x", px_per_mm[1 - has],
      px_per_mm[1 - has] / px_per_mm[has]);
}

std::vector<Doubt> pitch_doubts(const CameraDecode& camera) {
  std::vector<Doubt> doubts;
  for (const DirectionDecode& d : camera.directions)
    if (const auto sentence = pitch_doubt(d))
      doubts.push_back({fmt::format("camera \"{}\", {}", camera.camera, *sentence), true});
  return doubts;
}

/// Returns the doubts about the pitches of each camera, and takes those that they explain from that camera's
/// own. Where an image repeats another one the phases tell no pitch.
std::vector<Doubt> take_doubts_for_pitches(const Measurement& real, std::vector<std::vector<Doubt>>& own) {
  std::vector<Doubt> out;
  for (std::size_t c = 0; c < own.size(); ++c) {
    if (std::ranges::find(own[c], DoubtKind::repeated_image, &Doubt::kind) != own[c].end()) continue;
    std::vector<Doubt> pitches = pitch_doubts(real.cameras[c]);
    if (pitches.empty()) continue;
    std::erase_if(own[c], [](const Doubt& doubt) { return doubt.kind == DoubtKind::explained_by_pitches; });
    std::ranges::move(pitches, std::back_inserter(out));
  }
  return out;
}

}  // namespace

std::vector<Doubt> description_warnings(const Twin& twin, const std::vector<CameraImages>& images,
                                        const Measurement& real, const Measurement* simulated) {
  std::vector<std::vector<Doubt>> own;  // of each camera
  for (std::size_t c = 0; c < images.size(); ++c) {
    const ExpectedCoordinates expected =
        simulated ? expected_coordinates(twin, *simulated, c) : ExpectedCoordinates();
    own.push_back(description_doubts(images[c], twin.fringes,
                                     decode_options(twin, twin.cameras[c], images[c]), real.cameras[c],
                                     expected));
  }
  std::vector<Doubt> out;
  if (!std::ranges::all_of(own, &std::vector<Doubt>::empty) || mostly_rejected(real.triangulation))
    out = take_doubts_for_pitches(real, own);
  for (std::vector<Doubt>& doubts : own) std::ranges::move(doubts, std::back_inserter(out));
  if (out.empty())
    if (auto sentence = swapped_images(twin, real)) out.push_back({std::move(*sentence), true});
  if (auto sentence = weak_direction(twin, real.cloud)) out.push_back({std::move(*sentence)});
  return out;
}

void put_first(const std::vector<Doubt>& doubts, std::vector<std::string>& warnings) {
  std::vector<std::string> first;
  for (const Doubt& doubt : doubts) first.push_back(doubt.sentence);
  warnings.insert(warnings.begin(), first.begin(), first.end());
}

}  // namespace fringetwin::measure
