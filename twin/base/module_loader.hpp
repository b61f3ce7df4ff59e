// SPDX-License-Identifier: Apache-2.0
// Loads parts of the program that bring many shared libraries, as modules, when they are asked for.
#pragma once
#include <string>

namespace fringetwin {

struct ModuleFunction {
  void* address = nullptr;
  std::string fault;  ///< why not, where there is no address
};

/// Returns the function `name` of the module `file`, e.g. "libfringetwin_image_codecs.so". The module stays
/// loaded.
ModuleFunction find_in_module(const std::string& file, const std::string& name);

}  // namespace fringetwin
