// SPDX-License-Identifier: Apache-2.0
// The module fringetwin._core: errors of the program as exceptions of Python, and everything that is bound.
#include <pybind11/pybind11.h>

#include "cli/version.hpp"
#include "python/types.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::python {
namespace {

/// Raises the exception with the sentence that the command line would show, and its exit code.
void raise_user_error(const py::handle& type, const UserError& error) {
  const py::object raised = type(plain_sentence(error.what()));
  raised.attr("exit_code") = static_cast<int>(error.code());
  PyErr_SetObject(type.ptr(), raised.ptr());
}

void bind_errors(py::module_& module) {
  static py::object user_error = py::exception<UserError>(module, "UserError", PyExc_RuntimeError);
  static py::object unknown_key = py::exception<UnknownKey>(module, "UnknownKey", user_error.ptr());
  user_error.attr("__doc__") =
      "What a user can mend: one sentence with the place and the remedy. exit_code: the program's.";
  unknown_key.attr("__doc__") = "A key, or the path of one, that a twin does not have.";
  py::register_exception_translator([](std::exception_ptr fault) {
    try {
      std::rethrow_exception(fault);
    } catch (const UnknownKey& error) {
      raise_user_error(unknown_key, error);
    } catch (const UserError& error) {
      raise_user_error(user_error, error);
    } catch (const Cancelled& error) {
      // LongCall has told Python of the signal; its handler says what becomes of that.
      if (PyErr_CheckSignals() == 0) PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
    }
  });
}

}  // namespace
}  // namespace fringetwin::python

PYBIND11_MODULE(_core, module) {
  using namespace fringetwin;
  module.doc() = "The compiled part of fringetwin: bindings without logic of their own.";
  set_quiet(true);
  python::bind_errors(module);
  python::bind_captures(module);
  python::bind_twin(module);
  python::bind_capture_calls(module);
  python::bind_measure(module);
  python::bind_cosim(module);
  module.def("version", &cli::version_string,
             "Returns the version with the commit it was built from, as `fringetwin --version` prints it.");
  module.def("set_quiet", &set_quiet, pybind11::arg("quiet"),
             "Says whether progress is told on standard error; it is not until this is called with False.");
}
