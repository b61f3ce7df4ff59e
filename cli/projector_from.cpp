// SPDX-License-Identifier: Apache-2.0
#include "cli/projector_from.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "calib/page/projector_result.hpp"
#include "calib/solve/lit_points.hpp"
#include "cli/tell/json_output.hpp"
#include "compare/result/provenance.hpp"
#include "cosim/load.hpp"
#include "measure/measurement.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_folder.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::cli {
namespace {

namespace fs = std::filesystem;

void check_rig(const Twin& twin) {
  const std::string file = twin.file.string();
  if (twin.cameras.size() != 2)
    throw UserError(ExitCode::usage, file,
                    "--projector-from needs two calibrated cameras: they tell where the points are",
                    "add the second [[camera]], or calibrate with a board");
  if (twin.fringes.unwrap == Unwrap::none)
    throw UserError(ExitCode::usage, file, "fringes.unwrap = \"none\" gives no projector coordinates", "");
  if (std::ranges::none_of(twin.fringes.directions, [](const auto& d) { return d.axis == Axis::x; }))
    throw UserError(ExitCode::usage, file, "--projector-from needs columns: fringes.directions without \"x\"",
                    "");
}

std::array<int, 2> size_of_projector(const ProjectorFromCommand& o, const Twin& twin) {
  if (o.imagersize_px) return *o.imagersize_px;
  if (!twin.projector)
    throw UserError(ExitCode::usage, "--imagersize",
                    "is needed: the twin has no [projector] that says its size",
                    "e.g. --imagersize 1024x768");
  return {twin.projector->lens.width(), twin.projector->lens.height()};
}

/// What is written must not take the place of what the twin is read from.
void check_not_read(const Twin& twin, const fs::path& out) {
  for (const fs::path& file : twin.input_files)
    if (fs::weakly_canonical(file) == fs::weakly_canonical(out / "projector.cameramodel"))
      throw UserError(ExitCode::usage, "--out",
                      "projector.cameramodel there is what the twin reads: it would be overwritten",
                      "choose another folder");
}

/// Measures with the cameras alone: a projector that the twin already has would choose among matches, and its
/// objects would be fitted.
measure::Measurement measure_by_stereo(Twin twin, const std::vector<CameraImages>& images,
                                       std::array<int, 2> projector_size) {
  twin.projector.reset();
  twin.objects.clear();
  twin.measure.fits.clear();
  twin.measure.triangulate = Triangulate::stereo;
  std::vector<measure::CameraDecode> decodes;
  for (std::size_t c = 0; c < images.size(); ++c) {
    throw_if_cancelled();
    measure::DecodeOptions options = measure::decode_options(twin, twin.cameras[c], images[c]);
    options.projector_width_px = projector_size[0];
    options.projector_height_px = projector_size[1];
    decodes.push_back(measure::decode(images[c], twin.fringes, options));
  }
  return measure::measure_decoded(twin, std::move(decodes));
}

/// Puts the rows that are lit into the middle of the projector's image, where rows were not decoded.
void centre_rows(const fs::path& twin, std::array<int, 2> size, calib::ProjectorFromPoints& solved) {
  if (solved.rows) return;
  const double shift = 0.5 * (size[1] - 1) - 0.5 * (solved.rows_px[0] + solved.rows_px[1]);
  solved.parameters[calib::ProjectorParameter::cy] += shift;
  for (double& row : solved.rows_px) row += shift;
  if (solved.rows_px[1] - solved.rows_px[0] > size[1])
    warn(
        fmt::format("{}: with square pixels the points span {:.0f} rows, more than the projector's {}: check "
                    "--imagersize and the pitch, or give it more rows",
                    twin.string(), solved.rows_px[1] - solved.rows_px[0], size[1]));
}

}  // namespace

int run_projector_from(const ProjectorFromCommand& o, const Invocation& invocation) {
  check_out_folder(o.out);
  Twin twin = cosim::load_for_run(o.twin);
  check_rig(twin);
  check_not_read(twin, o.out);
  const std::array<int, 2> size = size_of_projector(o, twin);
  const cosim::Captures captures = cosim::load_captures(twin, o.captures);
  const measure::Measurement measured = measure_by_stereo(twin, captures.cameras, size);
  for (const std::string& warning : measured.warnings) warn(warning);
  calib::ProjectorFromPoints solved = calib::projector_from_points(
      calib::lit_points(measured),
      {.imagersize_px = size,
       .solve_k1 = o.solve_k1,
       .near_world_mm = 0.5 * (twin.cameras[0].center_world_mm() + twin.cameras[1].center_world_mm())},
      o.captures);
  centre_rows(o.twin, size, solved);

  const fs::path dir = o.out;
  begin_output(dir, {"projector.json"});
  std::vector<fs::path> inputs = twin.input_files;
  inputs.insert(inputs.end(), captures.files.begin(), captures.files.end());
  const calib::Origin origin{invocation.argv, version_string(), compare::sha256_of_files(inputs)};
  calib::write_projector(solved,
                         {.dir = dir,
                          .imagersize_px = size,
                          .camera_width_px = measured.cameras[0].width(),
                          .camera_height_px = measured.cameras[0].height()},
                         origin);
  if (!print_json_if(o.json, dir / "projector.json"))
    for (const std::string& line : calib::projector_lines(solved)) fmt::print("{}\n", plain_text(line));
  say("for the twin: [projector] model = \"" + (dir / "projector.cameramodel").string() +
      "\" (lengths in metres: cameramodel_unit = \"m\")");
  return static_cast<int>(ExitCode::ok);
}

}  // namespace fringetwin::cli
