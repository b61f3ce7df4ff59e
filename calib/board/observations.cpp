// SPDX-License-Identifier: Apache-2.0
#include "calib/board/observations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "twin/base/errors.hpp"

namespace fringetwin::calib {
namespace {

/// A board of one view has 8 usable equations at best (a homography) and 6 unknowns of its own: two left for
/// the lens. Three views can just give 4 to 6 parameters without anything to check them by.
constexpr int kLeastViews = 4;
constexpr int kLeastCornersPerView = 6;
/// Corners lie a little outside the imager only when a detector extrapolates.
constexpr double kImagerMarginPx = 2.0;
constexpr double kLeastSpacingMm = 0.5, kLargestSpacingMm = 500.0;

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& hint) {
  throw UserError(ExitCode::input, where, what, hint);
}

void check_board(const Board& board) {
  if (board.width_n < 2 || board.height_n < 2)
    refuse("calibration board", fmt::format("has {} x {} corners", board.width_n, board.height_n),
           "give the inner corners per row and the number of rows, at least 2 each");
  const double spacing_m = 1e-3 * board.spacing_mm;
  if (!std::isfinite(spacing_m) || spacing_m <= 0.0)
    refuse("calibration board", "the spacing of the corners must be a positive length", "");
  if (board.spacing_mm >= kLargestSpacingMm)
    refuse("calibration board",
           fmt::format("a corner spacing of {} m makes a board {:.4g} m wide; the spacing is in metres, and "
                       "this looks like millimetres",
                       spacing_m, 1e-3 * board.width_mm()),
           fmt::format("did you mean {}?", 1e-3 * spacing_m));
  if (board.spacing_mm < kLeastSpacingMm)
    refuse("calibration board", fmt::format("a corner spacing of {} m is too small to be real", spacing_m),
           fmt::format("the spacing is in metres; did you mean {}?", 1e3 * spacing_m));
}

void check_device(const Device& device) {
  if (device.imagersize_px[0] < 1 || device.imagersize_px[1] < 1)
    refuse(device.name, "the size of the imager is not known", "give --imagersize WIDTHxHEIGHT");
  const double largest = std::max(device.imagersize_px[0], device.imagersize_px[1]);
  if (!std::isfinite(device.focal_px) || device.focal_px < 0.05 * largest || device.focal_px > 50.0 * largest)
    refuse(device.name,
           fmt::format("a rough focal length of {} px does not go with an imager of {} x {}", device.focal_px,
                       device.imagersize_px[0], device.imagersize_px[1]),
           "it is in pixels: focal length / pixel pitch");
  if (!std::isfinite(device.sigma_px) || device.sigma_px <= 0.0)
    refuse(device.name, "the corner noise must be positive", "");
}

/// "corners.vnl: left", or "left" alone where the corners come from no file.
std::string place(const Observations& o, const std::string& what) {
  return (o.file.empty() ? "" : o.file.string() + ": ") + what;
}

void check_view(const Observations& o, const View& view) {
  const std::string where = place(o, o.label(view));
  if (view.corners.size() != o.board.corners())
    refuse(where,
           fmt::format("has {} corners, the board has {} x {} = {}", view.corners.size(), o.board.width_n,
                       o.board.height_n, o.board.corners()),
           "another board, or the wrong --object-width-n and --object-height-n");
  const Device& device = o.devices[view.device];
  for (std::size_t i = 0; i < view.corners.size(); ++i) {
    const Corner& c = view.corners[i];
    const auto corner = [&] {
      const auto width = static_cast<std::size_t>(o.board.width_n);
      return fmt::format("corner {} (row {}, column {})", i, i / width, i % width);
    };
    if (std::isnan(c.weight) || (c.seen() && !(c.q_px.allFinite() && std::isfinite(c.weight))))
      refuse(where, corner() + " is not finite", "mark a missing corner with - in its last column");
    if (!c.seen()) continue;
    const Eigen::Vector2d size(device.imagersize_px[0], device.imagersize_px[1]);
    if ((c.q_px.array() < -0.5 - kImagerMarginPx).any() ||
        (c.q_px.array() > size.array() - 0.5 + kImagerMarginPx).any())
      refuse(where,
             fmt::format("{} at ({:.7g}, {:.7g}) lies outside the imager of {} x {} px", corner(), c.q_px.x(),
                         c.q_px.y(), device.imagersize_px[0], device.imagersize_px[1]),
             "are two devices swapped, or is --imagersize wrong?");
  }
}

void check_counts(const Observations& o) {
  std::vector<int> n_devices(o.frames.size());  // that see enough of the board in a frame
  const auto sees = [](const View& view) { return view.n_seen() >= kLeastCornersPerView; };
  for (const View& view : o.views) n_devices[view.frame] += sees(view);
  for (std::size_t d = 0; d < o.devices.size(); ++d) {
    int n = 0, shared = 0;
    for (const View& view : o.views) {
      if (view.device != static_cast<int>(d) || !sees(view)) continue;
      ++n;
      shared += n_devices[view.frame] > 1;
    }
    const std::string name = place(o, o.devices[d].name);
    if (n < kLeastViews)
      refuse(name, fmt::format("sees the board in {} view{} only", n, n == 1 ? "" : "s"),
             fmt::format("at least {} are needed, 15 or more with different tilts are good", kLeastViews));
    if (o.devices.size() > 1 && shared < 2)
      refuse(name, fmt::format("shares {} view{} with the other devices", shared, shared == 1 ? "" : "s"),
             "at least 2 tie it to the rig; are the frame numbers in the file names the same?");
  }
}

}  // namespace

double Board::diagonal_mm() const { return std::hypot(width_mm(), height_mm()); }

Eigen::Vector3d Board::point_mm(std::size_t index, const Eigen::Vector2d& warp_mm) const {
  const auto width = static_cast<std::size_t>(width_n);
  const auto col = static_cast<double>(index % width), row = static_cast<double>(index / width);
  const double u = col / (width_n - 1), v = row / (height_n - 1);
  return {col * spacing_mm, row * spacing_mm,
          4.0 * warp_mm.x() * u * (1.0 - u) + 4.0 * warp_mm.y() * v * (1.0 - v)};
}

int View::n_seen() const {
  return static_cast<int>(std::ranges::count_if(corners, [](auto& c) { return c.seen(); }));
}

const View* Observations::find(int device, int frame) const {
  for (const View& view : views)
    if (view.device == device && view.frame == frame) return &view;
  return nullptr;
}

void Observations::sort() {
  std::vector<int> new_number(frames.size(), -1);
  std::vector<std::string> kept;
  std::erase_if(views, [](const View& v) { return v.n_seen() == 0 && !v.corners.empty(); });
  std::vector<bool> is_seen(frames.size());
  for (const View& v : views) is_seen[v.frame] = true;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (!is_seen[f]) continue;
    new_number[f] = static_cast<int>(kept.size());
    kept.push_back(frames[f]);
  }
  for (View& v : views) v.frame = new_number[v.frame];
  frames = kept;
  std::ranges::stable_sort(views, [](const View& a, const View& b) {
    return std::pair(a.frame, a.device) < std::pair(b.frame, b.device);
  });
}

std::string Observations::label(const View& view) const {
  return fmt::format("{}, view {}{}", devices[view.device].name, frames[view.frame],
                     view.source.empty() ? "" : " (" + view.source + ")");
}

std::string Observations::where(const View& view) const {
  return (file.empty() ? "" : file.string() + ": ") + label(view);
}

void check_observations(const Observations& o) {
  check_board(o.board);
  if (o.devices.empty()) refuse("calibration", "has no device", "");
  for (const Device& device : o.devices) check_device(device);
  for (const View& view : o.views) check_view(o, view);
  check_counts(o);
}

Observations select_frames(const Observations& o, const std::vector<int>& frames) {
  Observations out = o;
  std::erase_if(out.views, [&](const View& v) { return std::ranges::find(frames, v.frame) == frames.end(); });
  out.sort();
  return out;
}

}  // namespace fringetwin::calib
