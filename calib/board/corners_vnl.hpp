// SPDX-License-Identifier: Apache-2.0
// Reads and writes corner files as mrcal's tools do (`# filename x y level` or `… weight`).
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calib/board/observations.hpp"

namespace fringetwin::calib {

/// One image of a corner file. `corners` is empty for an image without a board ("filename - - -").
struct ImageCorners {
  std::string filename;
  std::vector<Corner> corners;
  int line = 0;  ///< of its first row
};

/// The fourth column is a weight when the legend names it so or `has_weights`; else a detector's level,
/// weight 2^-level; absent: weight 1. "-" or a negative number: the corner was not seen. Throws
/// UserError(input) with file and line; a coordinate that is not finite is an error, unlike in mrcal.
std::vector<ImageCorners> read_corners_vnl(const std::filesystem::path& file, bool has_weights = false);

/// Writes corners with their weights as the shortest decimals that read back the same. mrcal reads the file
/// with
/// --corners-cache-has-weights.
void write_corners_vnl(const std::filesystem::path& file, const std::vector<ImageCorners>& images);

/// Sorts images to devices by glob (on the whole name, or on the last part when the glob has no '/'), and to
/// frames by what is left of the names of one device without their common beginning and end. Numbers are
/// compared as numbers (7 = 007). Fills views and frames; throws UserError(input).
void assign_views(const std::vector<ImageCorners>& images, const std::vector<std::string>& globs,
                  Observations& observations);

}  // namespace fringetwin::calib
