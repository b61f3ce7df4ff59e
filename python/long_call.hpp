// SPDX-License-Identifier: Apache-2.0
// Runs work that takes long: other threads of Python run meanwhile, and Ctrl-C ends it.
#pragma once
#include <pybind11/pybind11.h>
#include <unistd.h>

#include <optional>

#include "twin/base/progress.hpp"

namespace fringetwin::python {

/// While it lives Python's lock is released; on the main thread, to which Python brings its signals, Ctrl-C
/// cancels the work, and Python hears of it afterwards.
class LongCall : NotCopyable {
 public:
  LongCall() {
    if (::gettid() == ::getpid()) scope_.emplace();
  }
  ~LongCall() {
    if (scope_ && cancelled()) PyErr_SetInterrupt();
  }

 private:
  std::optional<CancelScope> scope_;
  pybind11::gil_scoped_release release_;
};

/// Returns what `work` returns, run as a LongCall; nothing of Python may be touched in it.
template <class Work>
auto long_call(Work&& work) {
  const LongCall call;
  return work();
}

}  // namespace fringetwin::python
