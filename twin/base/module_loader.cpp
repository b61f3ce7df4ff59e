// SPDX-License-Identifier: Apache-2.0
#include "twin/base/module_loader.hpp"

#include <dlfcn.h>

#include <filesystem>

namespace fringetwin {

// Beside the program, above it (tests), or where it was built.
ModuleFunction find_in_module(const std::string& file, const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::string fault;
  for (const fs::path& folder : {program, program.parent_path(), fs::path(FRINGETWIN_BINARY_DIR)}) {
    const fs::path path = folder / file;
    if (void* module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      if (void* address = ::dlsym(module, name.c_str())) return {address, ""};
    }
    const char* error = ::dlerror();
    fault += (fault.empty() ? "" : "; ") + (error ? std::string(error) : path.string());
  }
  return {nullptr, fault};
}

}  // namespace fringetwin
