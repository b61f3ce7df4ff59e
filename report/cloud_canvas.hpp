// SPDX-License-Identifier: Apache-2.0
// Writes a point cloud that the reader of a page can turn: a <canvas>, the points in the page, no library.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "report/cloud_view.hpp"
#include "report/map.hpp"

namespace fringetwin::report {

struct CloudCanvas {
  CloudView view;                   ///< where the eye is at first; its picture is the one that is printed
  MapStyle style;                   ///< colours, limits and unit of the values
  std::size_t max_points = 12'000;  ///< evenly drawn from more
  std::string label;                ///< for readers that do not see the picture
};

/// Drag turns, the wheel zooms, a double click starts again (keys: arrows, + and -, 0). Where no script runs
/// and in print the still picture of draw_cloud() stands there instead. `id` is unique on the page, which
/// carries cloud_script() once.
std::string cloud_canvas_html(const std::vector<Eigen::Vector3d>& p_world_mm, const std::vector<float>& value,
                              const CloudCanvas& canvas, const std::string& id);

/// JavaScript that brings every such cloud of a page to life.
const char* cloud_script();

}  // namespace fringetwin::report
