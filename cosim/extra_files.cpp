// SPDX-License-Identifier: Apache-2.0
#include "cosim/extra_files.hpp"

#include "compare/geometry/deviation_cloud.hpp"
#include "measure/measured_npz.hpp"
#include "report/plot/page_drawings.hpp"
#include "twin/base/safe_file.hpp"

namespace fringetwin::cosim {

std::vector<std::string> files_of_some_runs(const Twin& twin) {
  std::vector<std::string> names;
  for (const Camera& camera : twin.cameras) names.push_back(measure::measured_npz_name(camera.name));
  for (const Object& object : twin.objects) names.push_back(compare::deviation_cloud_name(object.name));
  return names;
}

void write_npz_if_asked(const std::filesystem::path& dir, const measure::Measurement& measurement,
                        const ExtraFiles& extra) {
  if (extra.npz) measure::write_measured_npz(dir, measurement);
}

void write_figures_if_asked(const std::filesystem::path& dir, const ExtraFiles& extra) {
  if (!extra.figures) return;
  const std::string page = read_whole_text(dir / "report.html", {.what = "page"});
  report::write_drawings(dir / "figures", report::drawings_of_page(page));
}

void check_figures(const std::filesystem::path& dir, const ExtraFiles& extra) {
  if (extra.figures) report::check_all_drawn(dir / "report.html");
}

}  // namespace fringetwin::cosim
