// SPDX-License-Identifier: Apache-2.0
#include "calib/board/observe.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "calib/board/corner_order.hpp"
#include "measure/decode/decode.hpp"
#include "measure/description/doubts.hpp"
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

/// The board in the images of one camera, as it is read there.
struct SeenBoard {
  std::string camera = {};
  std::vector<Corner> corners = {};            ///< empty: not seen
  std::vector<ProjectorCorner> readings = {};  ///< the projector's pixels at the corners
};

std::vector<Corner> places(const std::vector<ProjectorCorner>& readings) {
  std::vector<Corner> out;
  for (const ProjectorCorner& reading : readings) out.push_back({reading.q_px, reading.seen() ? 1.0 : -1.0});
  return out;
}

/// Refuses images in a mirror: a camera finds the rows of the board to run to the right in them all the same,
/// and the projector's pixels say that they do not.
void check_mirrored(const std::filesystem::path& folder, const Board& board,
                    const std::vector<SeenBoard>& boards) {
  const SeenBoard* mirrored = nullptr;
  bool all = true;
  for (const SeenBoard& seen : boards) {
    const std::optional<bool> is_so = is_mirrored(board, places(seen.readings));
    if (!is_so) continue;
    if (*is_so) mirrored = &seen;
    all = all && *is_so;
  }
  if (!mirrored) return;
  if (all)
    throw UserError(ExitCode::input, folder.string(),
                    "the projector's pixels lie on the board as in a mirror",
                    "are the fringes of x and y exchanged ([fringes] directions), the images of the cameras "
                    "mirrored, or is the projector set to rear projection?");
  throw UserError(ExitCode::input, folder.string(),
                  fmt::format("the images of {} are mirrored: the projector's pixels lie on the board the "
                              "other way round than in those of the other camera",
                              mirrored->camera),
                  "switch mirroring off in the camera, or flip the images back");
}

/// Brings the corners of each camera into the order of the first: where a camera stands upside down beside
/// it, a board that looks the same turned by 180 degrees is read from its other end. The projector's pixels
/// tell the corners.
void turn_to_the_first(const Board& board, std::vector<SeenBoard>& boards) {
  const SeenBoard* first = nullptr;
  for (SeenBoard& seen : boards) {
    if (!any_seen(seen.readings)) continue;
    if (!first) {
      first = &seen;
      continue;
    }
    const CornerOrder* order = turn_beside(board, places(first->readings), places(seen.readings));
    if (!order) continue;
    seen.corners = reordered(board, seen.corners, *order);
    seen.readings = reordered(board, seen.readings, *order);
  }
}

/// Refuses images that show other fringes than the twin describes, and says which where that is found.
void check_description(const std::filesystem::path& folder, const CameraImages& images,
                       const Fringes& fringes, const measure::DecodeOptions& options,
                       const measure::CameraDecode& decoded) {
  for (const measure::Doubt& doubt : measure::description_doubts(images, fringes, options, decoded, {}))
    if (doubt.shows_other_fringes)
      throw UserError(ExitCode::input, folder.string(), doubt.sentence, "mend [fringes] of the twin");
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
  if (images.white) return images.white->floats();
  const auto sequence = expand_sequence(fringes);
  const bool has_steps = fringes.steps > 0;
  ImageF mean(images.images.front().width, images.images.front().height);
  float n = 0.0F;
  for (std::size_t k = 0; k < sequence.size(); ++k) {
    if (sequence[k].is_image() || (has_steps && sequence[k].kind != PatternSpec::Kind::phase_step)) continue;
    for (std::size_t i = 0; i < mean.size(); ++i) mean.data[i] += images.images[k][i];
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
    std::vector<SeenBoard> boards;
    for (const Camera& camera : twin.cameras) {
      const CameraImages images = load_camera_images(set, camera, twin.fringes);
      const auto corners = find_board(evenly_lit(images, twin.fringes), pattern);
      if (!corners) {
        warn(fmt::format("{}: {} does not see the board", folder.string(), camera.name));
        boards.push_back({.camera = camera.name});
        continue;
      }
      boards.push_back({.camera = camera.name, .corners = *corners});
      if (!twin.projector) continue;
      const measure::CameraDecode decoded = measure::decode(images, twin.fringes, options);
      boards.back().readings = projector_corners(decoded, pattern.board, *corners);
      const bool is_first = std::ranges::none_of(of_projector, any_seen);
      if (is_first && !any_seen(boards.back().readings))
        check_description(folder, images, twin.fringes, options, decoded);
    }
    check_mirrored(folder, pattern.board, boards);
    turn_to_the_first(pattern.board, boards);
    std::vector<std::vector<ProjectorCorner>> readings;
    for (std::size_t c = 0; c < boards.size(); ++c) {
      out.push_back({boards[c].camera + "-" + name, on_whole_sensor(boards[c].corners, twin.cameras[c]), 0});
      if (any_seen(boards[c].readings)) readings.push_back(std::move(boards[c].readings));
    }
    if (twin.projector) {
      if (readings.empty()) warn(folder.string() + ": no corner of the board is lit by decodable fringes");
      of_projector.push_back(mean_of_cameras(readings));
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
