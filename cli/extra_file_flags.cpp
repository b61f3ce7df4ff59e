// SPDX-License-Identifier: Apache-2.0
#include "cli/extra_file_flags.hpp"

#include <CLI/CLI.hpp>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {

void add_npz_flag(CLI::App& sub, cosim::ExtraFiles& extra) {
  sub.add_flag("--npz", extra.npz,
               "Also measured_<camera>.npz: phases, modulation, mask and points as arrays for numpy");
}

void add_figures_flag(CLI::App& sub, cosim::ExtraFiles& extra) {
  sub.add_flag("--figures", extra.figures, "Also the plots of report.html as SVG files (DIR/figures)");
}

int code_with_figures(bool asked_for, const std::filesystem::path& dir, int otherwise) {
  try {
    cosim::check_figures(dir, {.figures = asked_for});
  } catch (const UserError& fault) {
    if (otherwise == 0) throw;
    warn(fault.what());
  }
  return otherwise;
}

}  // namespace fringetwin::cli
