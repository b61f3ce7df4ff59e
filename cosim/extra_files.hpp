// SPDX-License-Identifier: Apache-2.0
// Writes files that a run leaves on request, beside those that are always there.
#pragma once
#include <filesystem>

#include "measure/measurement.hpp"

namespace fringetwin::cosim {

struct ExtraFiles {
  bool npz = false;      ///< measured_<camera>.npz beside points.ply
  bool figures = false;  ///< the plots of the page as figures/NAME.svg
};

/// Returns the names of what only some runs write beside points.ply: an earlier run's must not stand for this
/// one's.
std::vector<std::string> files_of_some_runs(const Twin& twin);

/// Writes DIR/measured_<camera>.npz where it is asked for.
void write_npz_if_asked(const std::filesystem::path& dir, const measure::Measurement& measurement,
                        const ExtraFiles& extra);
/// Writes the plots of DIR/report.html, which is there, to DIR/figures where it is asked for.
void write_figures_if_asked(const std::filesystem::path& dir, const ExtraFiles& extra);
/// Throws UserError(usage) where they are asked for and gnuplot did not draw all of them; to be called when
/// all else is written.
void check_figures(const std::filesystem::path& dir, const ExtraFiles& extra);

}  // namespace fringetwin::cosim
