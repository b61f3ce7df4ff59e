// SPDX-License-Identifier: Apache-2.0
// Loads parts of the program that bring many shared libraries, as modules, when they are asked for.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"

namespace fringetwin {

/// What is said when a module is missing: "SUBJECT: the module that DOES cannot be loaded", and what helps.
struct ModuleRefusal {
  ExitCode code;
  std::string subject, does, help;
};

/// Returns the address of the function `name` in the module `file`, e.g. "libfringetwin_image_codecs.so",
/// which stays loaded. Throws UserError with the refusal where there is none.
void* find_in_module(const std::string& file, const std::string& name, const ModuleRefusal& refusal);

/// Returns the folders in which modules of `program` (its path) are looked for: the program's own, of an
/// installed one PREFIX/lib/fringetwin/modules, and the build tree where the program lies in it, which is
/// told by the SHA-256 of its path. Elsewhere anybody may have put a file since.
std::vector<std::filesystem::path> module_folders(const std::filesystem::path& program,
                                                  const std::string& build_tree_sha256);

/// Returns the build tree in which `program` lies, told by the SHA-256 of its path; empty: in none.
std::filesystem::path build_tree_of(const std::filesystem::path& program,
                                    const std::string& build_tree_sha256);
/// Returns PREFIX of an installed program, PREFIX/bin/fringetwin, or of an installed Python package,
/// PREFIX/lib/python3/dist-packages/fringetwin; empty: it lies elsewhere.
std::filesystem::path prefix_of(const std::filesystem::path& program);
/// Returns the path of the running program, or of the Python module that this code is linked into; empty
/// where /proc is missing.
std::filesystem::path own_program();
/// Returns the build tree of the running program: that in which it was built, if it lies there still.
std::filesystem::path own_build_tree();

}  // namespace fringetwin
