// SPDX-License-Identifier: Apache-2.0
#include "twin/base/module_loader.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>

namespace fringetwin {

// Beside the program, above it (tests), or where it was built.
void* find_in_module(const std::string& file, const std::string& name, const ModuleRefusal& refusal) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::string fault;
  for (const fs::path& folder : {program, program.parent_path(), fs::path(FRINGETWIN_BINARY_DIR)}) {
    const fs::path path = folder / file;
    if (void* module = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      if (void* address = ::dlsym(module, name.c_str())) return address;
    }
    const char* error = ::dlerror();
    fault += (fault.empty() ? "" : "; ") + (error ? std::string(error) : path.string());
  }
  throw UserError(refusal.code, refusal.subject,
                  fmt::format("the module that {} cannot be loaded ({})", refusal.does, fault), refusal.help);
}

}  // namespace fringetwin
