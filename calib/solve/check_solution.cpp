// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/solve/calibrate.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/statistics.hpp"

namespace fringetwin::calib {

namespace {

/// fx/fy of a projector with a diamond pixel raster is 2 or 1/2; nothing real lies outside of this.
constexpr double kLargestAspect = 2.5;
/// A lens-shifted projector has its centre outside the image, but not further than this many sizes away.
constexpr double kFarthestCentre = 2.0;
/// A view that fits this much worse than the middle one is not of the same board at rest.
constexpr double kBadViewFactor = 5.0, kBadViewPx = 0.5;
constexpr int kGoodNumberOfViews = 10;

[[noreturn]] void diverged(const std::string& where, const std::string& what) {
  throw UserError(ExitCode::no_convergence, where, what,
                  "check the rough focal lengths, the order of the corners and the board's size");
}

void check_lens(const Calibration& c, int d) {
  const DeviceResult& device = c.devices[d];
  const auto& size = c.problem.imagersizes[d];
  const double fx = device.intrinsics[0], fy = device.intrinsics[1];
  const double largest = std::max(size[0], size[1]);
  if (!(fx > 0.0 && fy > 0.0) || std::min(fx, fy) < 0.05 * largest || std::max(fx, fy) > 50.0 * largest)
    diverged(device.name,
             fmt::format("its solved focal length ({:.5g}, {:.5g}) px is absurd for an imager of {} x {}", fx,
                         fy, size[0], size[1]));
  if (std::max(fx / fy, fy / fx) > kLargestAspect)
    diverged(device.name,
             fmt::format("its solved focal lengths {:.5g} and {:.5g} px differ too much", fx, fy));
  for (std::size_t i = 0; i < 2; ++i)
    if (std::abs(device.intrinsics[2 + i] / size[i] - 0.5) > kFarthestCentre)
      diverged(device.name,
               fmt::format("its solved image centre ({:.5g}, {:.5g}) px is far outside the imager",
                           device.intrinsics[2], device.intrinsics[3]));
  try {
    (void)c.lens(d);
  } catch (const UserError& e) {
    throw UserError(ExitCode::no_convergence, device.name,
                    std::string("the solved lens cannot be used: ") + e.what(),
                    "cover more of the image with boards, or use a model with fewer terms");
  }
}

void check_in_front(const Calibration& c) {
  for (const View& view : c.observations.views) {
    const Pose T = T_device_ref(c.problem, view.device) * T_ref_board(c.problem, view.frame);
    for (std::size_t i = 0; i < view.corners.size(); ++i)
      if (view.corners[i].seen() && !((T * c.observations.board.point_mm(i, c.warp_mm)).z() > 0.0))
        diverged(c.observations.label(view), "the solution has the board behind the device");
  }
}

[[noreturn]] void refuse_view(const Calibration& c, std::size_t v, const std::string& what) {
  throw UserError(
      ExitCode::input, c.observations.label(c.observations.views[v]), "does not fit with the others" + what,
      "another board, a board that moved between the captures, or corners out of order; remove the view");
}

void check_views(const Calibration& c) {
  for (std::size_t v = 0; v < c.views.size(); ++v)
    if (const FitQuality& fit = c.views[v].fit; fit.n_outliers > fit.n_corners)
      refuse_view(c, v,
                  fmt::format(" ({} of its {} corners are outliers)", fit.n_outliers,
                              fit.n_outliers + fit.n_corners));
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    std::vector<double> rms;
    for (const ViewResult& v : c.views)
      if (v.device == static_cast<int>(d) && v.fit.n_corners > 0) rms.push_back(v.fit.rms_px);
    if (rms.empty()) diverged(c.devices[d].name, "no corner is left of it");
    const double middle = upper_median(rms);
    std::size_t worst = c.views.size();
    for (std::size_t v = 0; v < c.views.size(); ++v)
      if (c.views[v].device == static_cast<int>(d) &&
          (worst == c.views.size() || c.views[v].fit.rms_px > c.views[worst].fit.rms_px))
        worst = v;
    const double worst_rms = c.views[worst].fit.rms_px;
    if (worst_rms > kBadViewFactor * middle && worst_rms > kBadViewPx)
      refuse_view(c, worst, fmt::format(" ({:.3g} px rms, the middle one {:.3g} px)", worst_rms, middle));
  }
}

void check_rms(const Calibration& c, const CalibrateOptions& options) {
  for (const DeviceResult& device : c.devices) {
    if (device.fit.rms_px > options.max_rms_px)
      throw UserError(ExitCode::no_convergence, device.name,
                      fmt::format("its corners fit to {:.3g} px rms, the limit is {:.3g} px",
                                  device.fit.rms_px, options.max_rms_px),
                      "check the board's size, the lens model and the corners, or raise --max-rms");
    const int n = device.fit.n_corners + device.fit.n_outliers;
    if (device.fit.n_outliers > n / 5)
      throw UserError(ExitCode::no_convergence, device.name,
                      fmt::format("{} of its {} corners are outliers", device.fit.n_outliers, n),
                      "check the corners and the lens model");
  }
}

bool contains(const std::string& name, const std::string& word) {
  return name.find(word) != std::string::npos;
}

/// Frames are right-handed with x to the right, so a right camera has its centre at positive x.
void check_sides(const Calibration& c) {
  for (const DeviceResult& left : c.devices)
    for (const DeviceResult& right : c.devices) {
      if (!contains(left.name, "left") || !contains(right.name, "right")) continue;
      const Pose T_left_right = left.T_device_ref * right.T_device_ref.inverse();
      if (T_left_right.translation_mm.x() < 0.0)
        throw UserError(
            ExitCode::input, right.name,
            fmt::format("lies {:.4g} mm to the left of {}", -T_left_right.translation_mm.x(), left.name),
            "the two cameras look swapped; exchange their images or their names");
    }
}

void add_warnings(Calibration& c) {
  for (std::size_t d = 0; d < c.devices.size(); ++d) {
    const auto n =
        std::ranges::count_if(c.views, [&](const ViewResult& v) { return v.device == static_cast<int>(d); });
    if (n < kGoodNumberOfViews)
      c.warnings.push_back(
          fmt::format("{}: only {} views; 15 or more with different tilts constrain the lens better",
                      c.devices[d].name, n));
  }
}

}  // namespace

void check_solution(Calibration& c, const CalibrateOptions& options) {
  if (!c.residuals.allFinite()) diverged("calibration", "the solution is not finite");
  c.warnings.clear();
  check_views(c);
  check_in_front(c);
  check_rms(c, options);
  for (std::size_t d = 0; d < c.devices.size(); ++d) check_lens(c, static_cast<int>(d));
  check_sides(c);
  add_warnings(c);
}

}  // namespace fringetwin::calib
