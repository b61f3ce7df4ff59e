// SPDX-License-Identifier: Apache-2.0
#include "calib/board/observe.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "measure/decode/decode.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::calib {
namespace {

bool any_seen(const std::vector<ProjectorCorner>& corners) {
  return std::ranges::any_of(corners, [](const auto& c) { return c.seen(); });
}

/// The corners where the whole sensor has them: what is calibrated is its lens, not that of a channel's
/// image.
std::vector<Corner> on_whole_sensor(std::vector<Corner> corners, const Camera& camera) {
  for (Corner& corner : corners) corner.q_px = camera.on_sensor_px(corner.q_px);
  return corners;
}

}  // namespace

std::vector<ImageCorners> detect_in_pictures(const std::vector<Picture>& pictures,
                                             const BoardPattern& pattern) {
  std::vector<ImageCorners> out;
  std::size_t n_found = 0;
  Progress progress("looking for the board", pictures.size());
  for (const auto& [file, right] : pictures) {
    auto corners = find_board(read_gray(file, right).image, pattern);
    n_found += corners.has_value();
    if (!corners) warn(file.string() + ": no board found");
    out.push_back({file.string(), corners.value_or(std::vector<Corner>{}), 0});
    progress.advance();
  }
  if (n_found == 0)
    throw UserError(ExitCode::input, fmt::format("{} pictures", pictures.size()), "none shows the board",
                    "check --board, --object-width-n and --object-height-n (inner corners)");
  return out;
}

ImageF evenly_lit(const CameraImages& images, const Fringes& fringes) {
  if (images.white) return *images.white;
  const auto sequence = expand_sequence(fringes);
  const bool has_steps = fringes.steps > 0;
  ImageF mean(images.images.front().width, images.images.front().height);
  float n = 0.0F;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (sequence[k].is_image() || (has_steps && sequence[k].kind != PatternSpec::Kind::phase_step)) continue;
    for (std::size_t i = 0; i < mean.size(); ++i) mean.data[i] += images.images[k].data[i];
    n += 1.0F;
  }
  for (float& v : mean.data) v /= std::max(n, 1.0F);
  return mean;
}

std::vector<ImageCorners> detect_in_captures(const Twin& twin,
                                             const std::vector<std::filesystem::path>& folders,
                                             const BoardPattern& pattern) {
  std::vector<ImageCorners> out;
  const int n_images = static_cast<int>(expand_sequence(twin.fringes).size());
  measure::DecodeOptions options;
  options.min_modulation_dn = twin.measure.min_modulation_dn;
  if (twin.projector) {
    options.projector_width_px = twin.projector->lens.width();
    options.projector_height_px = twin.projector->lens.height();
  }
  std::vector<std::vector<ProjectorCorner>> of_projector;
  Progress progress("decoding the board", folders.size());
  for (const auto& folder : folders) {
    const std::filesystem::path tidy = folder.has_filename() ? folder : folder.parent_path();
    const std::string name = tidy.filename().string();
    const CaptureSet set = read_capture_set(folder, n_images);
    std::vector<std::vector<ProjectorCorner>> readings;
    for (const Camera& camera : twin.cameras) {
      const CameraImages images = load_camera_images(set, camera, twin.fringes);
      const auto corners = find_board(evenly_lit(images, twin.fringes), pattern);
      out.push_back(
          {camera.name + "-" + name, on_whole_sensor(corners.value_or(std::vector<Corner>{}), camera), 0});
      if (!corners) {
        warn(fmt::format("{}: {} does not see the board", folder.string(), camera.name));
        continue;
      }
      if (twin.projector)
        readings.push_back(
            projector_corners(measure::decode(images, twin.fringes, options), pattern.board, *corners));
    }
    if (twin.projector) {
      auto corners = mean_of_cameras(readings);
      if (!any_seen(corners)) {
        warn(folder.string() + ": no corner of the board is lit by decodable fringes");
        corners.clear();
      }
      of_projector.push_back(std::move(corners));
      out.push_back({"projector-" + name, {}, 0});
    }
    progress.advance();
  }
  const auto weighted = weighted_corners(of_projector);
  for (std::size_t f = 0; f < weighted.size(); ++f)
    out[(f + 1) * (twin.cameras.size() + 1) - 1].corners = weighted[f];
  return out;
}

}  // namespace fringetwin::calib
