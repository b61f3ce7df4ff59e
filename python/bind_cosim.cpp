// SPDX-License-Identifier: Apache-2.0
// Binds the main job: render, measure both sides, compare, write.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "cosim/cosim.hpp"
#include "python/long_call.hpp"
#include "python/types.hpp"
#include "twin/base/out_folder.hpp"

namespace fringetwin::python {
namespace {

/// Returns the options that are not the defaults as Python writes them: "samples=4".
std::vector<std::string> given_options(const cosim::CosimRequest& request, bool radiance,
                                       const cosim::ExtraFiles& extra) {
  std::vector<std::string> given;
  const cosim::RenderRequest& render = request.render;
  if (!request.refine.empty()) given.push_back(fmt::format("refine={}", fmt::join(request.refine, ",")));
  if (!request.steps.empty()) given.push_back("steps=" + request.steps);
  if (request.hold_out != 0) given.push_back(fmt::format("hold_out={}", request.hold_out));
  if (!request.hold_out_by.empty()) given.push_back("hold_out_by=" + request.hold_out_by);
  if (radiance) given.emplace_back("radiance=True");
  if (extra.npz) given.emplace_back("npz=True");
  if (extra.figures) given.emplace_back("figures=True");
  if (render.samples) given.push_back(fmt::format("samples={}", *render.samples));
  if (render.sampler) given.push_back("sampler=" + *render.sampler);
  if (render.phase_error_rad) given.push_back(fmt::format("phase_error_rad={}", *render.phase_error_rad));
  if (render.gray_error) given.push_back(fmt::format("gray_error={}", *render.gray_error));
  if (render.seed) given.push_back(fmt::format("seed={}", *render.seed));
  if (!render.device.empty()) given.push_back("device=" + render.device);
  return given;
}

void run(const PyTwin& twin, const std::filesystem::path& out, const std::vector<std::string>& refine,
         const std::string& steps, int hold_out, const std::string& hold_out_by, bool radiance, bool npz,
         bool figures, std::optional<int> samples, std::optional<std::string> sampler,
         std::optional<double> phase_error_rad, std::optional<double> gray_error,
         std::optional<std::uint64_t> seed, const std::string& device) {
  const PyTwin::State state = twin.state();
  const cosim::CosimRequest request{
      .twin = twin.file,
      .settings = state.settings,
      .refine = refine,
      .steps = steps,
      .hold_out = hold_out,
      .hold_out_by = hold_out_by,
      .render = {std::move(samples), std::move(sampler), phase_error_rad, gray_error, seed, device}};
  const cosim::ExtraFiles extra{.npz = npz, .figures = figures};
  const cosim::Origin origin =
      origin_of("fringetwin.cosim", twin.file, state.settings, given_options(request, radiance, extra));
  long_call([&] {
    const FoldersOfCall folders;
    check_out_folder(out);
    cosim::Run run = cosim::run_cosim(request);
    cosim::write_simulated_side(out, run, radiance);
    cosim::compare_and_write(out, run, origin, extra);
    cosim::check_figures(out, extra);
  });
}

}  // namespace

void bind_cosim(py::module_& module) {
  module.def("cosim", &run, py::arg("twin"), py::arg("out"), py::kw_only(),
             py::arg("refine") = std::vector<std::string>{}, py::arg("steps") = "", py::arg("hold_out") = 0,
             py::arg("hold_out_by") = "", py::arg("radiance") = false, py::arg("npz") = false,
             py::arg("figures") = false, py::arg("samples") = py::none(), py::arg("sampler") = py::none(),
             py::arg("phase_error_rad") = py::none(), py::arg("gray_error") = py::none(),
             py::arg("seed") = py::none(), py::arg("device") = "",
             "Writes what `fringetwin cosim --out` writes; see fringetwin.cosim.");
}

}  // namespace fringetwin::python
