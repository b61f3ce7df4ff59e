// SPDX-License-Identifier: Apache-2.0
// Binds the main job: render, measure both sides, compare, write.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "cli/version.hpp"
#include "cosim/cosim.hpp"
#include "python/long_call.hpp"
#include "python/types.hpp"
#include "twin/base/out_folder.hpp"

namespace fringetwin::python {
namespace {

void run(const PyTwin& twin, const std::filesystem::path& out, const std::vector<std::string>& refine,
         const std::string& steps, int hold_out, bool radiance, std::optional<int> samples,
         std::optional<std::string> sampler, std::optional<double> phase_error_rad,
         std::optional<double> gray_error, std::uint64_t seed, const std::string& device) {
  cosim::Origin origin = origin_of("fringetwin.cosim", twin.file, twin.settings);
  origin.version = cli::version_string();
  const cosim::CosimRequest request{
      twin.file, twin.settings,
      refine,    steps,
      hold_out,  {std::move(samples), std::move(sampler), phase_error_rad, gray_error, seed, device}};
  long_call([&] {
    check_out_folder(out);
    cosim::Run run = cosim::run_cosim(request);
    cosim::write_simulated_side(out, run, radiance);
    cosim::compare_and_write(out, run, origin);
  });
}

}  // namespace

void bind_cosim(py::module_& module) {
  module.def("cosim", &run, py::arg("twin"), py::arg("out"), py::kw_only(),
             py::arg("refine") = std::vector<std::string>{}, py::arg("steps") = "", py::arg("hold_out") = 0,
             py::arg("radiance") = false, py::arg("samples") = py::none(), py::arg("sampler") = py::none(),
             py::arg("phase_error_rad") = py::none(), py::arg("gray_error") = py::none(), py::arg("seed") = 0,
             py::arg("device") = "", "Writes what `fringetwin cosim --out` writes; see fringetwin.cosim.");
}

}  // namespace fringetwin::python
