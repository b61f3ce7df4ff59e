// SPDX-License-Identifier: Apache-2.0
#include "twin/base/module_loader.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include "twin/base/sha256.hpp"

namespace fringetwin {
namespace fs = std::filesystem;

std::vector<fs::path> module_folders(const fs::path& program, const std::string& build_tree_sha256) {
  if (!program.has_parent_path()) return {};  // /proc is missing; dlopen would search the system's folders
  const fs::path folder = program.parent_path();
  std::vector<fs::path> folders = {folder};
  if (const fs::path prefix = prefix_of(program); !prefix.empty())
    folders.push_back(prefix / "lib" / "fringetwin" / "modules");
  const fs::path tree = build_tree_of(program, build_tree_sha256);
  if (!tree.empty() && tree != folder) folders.push_back(tree);
  return folders;
}

fs::path prefix_of(const fs::path& program) {
  const fs::path folder = program.parent_path();
  if (folder.filename() == "bin") return folder.parent_path();
  fs::path above = folder;  // PREFIX/lib/python3/dist-packages/fringetwin
  for (const char* name : {"fringetwin", "dist-packages", "python3", "lib"}) {
    if (above.filename() != name) return {};
    above = above.parent_path();
  }
  return above;
}

fs::path build_tree_of(const fs::path& program, const std::string& build_tree_sha256) {
  for (fs::path above = program.parent_path(); above != above.parent_path(); above = above.parent_path())
    if (sha256_of_text(above.native()) == build_tree_sha256) return above;
  return {};
}

fs::path own_program() {
  std::error_code ignored;
  Dl_info library = {};
  link_map* map = nullptr;
  static const char here = 0;
  const bool known = ::dladdr1(&here, &library, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0;
  if (known && map && map->l_name && *map->l_name) return fs::canonical(map->l_name, ignored);  // of Python
  return fs::read_symlink("/proc/self/exe", ignored);
}

fs::path own_build_tree() { return build_tree_of(own_program(), FRINGETWIN_BUILD_TREE_SHA256); }

void* find_in_module(const std::string& file, const std::string& name, const ModuleRefusal& refusal) {
  std::string fault;
  for (const fs::path& folder : module_folders(own_program(), FRINGETWIN_BUILD_TREE_SHA256)) {
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
