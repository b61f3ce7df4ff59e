// SPDX-License-Identifier: Apache-2.0
#include "twin/image_codecs.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "twin/errors.hpp"

namespace fringetwin {
namespace {

namespace fs = std::filesystem;

// Beside the program, above it (tests), or where it was built.
DecodeImageFunction load() {
  constexpr const char* name = "libfringetwin_image_codecs.so";
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  std::string fault;
  for (const fs::path& file :
       {program / name, program.parent_path() / name, fs::path(FRINGETWIN_BINARY_DIR) / name}) {
    if (void* module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
      if (void* function = ::dlsym(module, decode_image_name))
        return reinterpret_cast<DecodeImageFunction>(function);
    }
    const char* error = ::dlerror();
    fault += fmt::format("{}{}", fault.empty() ? "" : "; ", error ? error : file.string());
  }
  throw UserError(ExitCode::input, "BMP, TIFF and PGM images",
                  fmt::format("the module that reads them cannot be loaded ({})", fault),
                  "put it beside the program, or convert the images to PNG");
}

}  // namespace

bool decode_image(const std::vector<std::uint8_t>& bytes, DecodedImage* image) {
  static const DecodeImageFunction decode = load();
  return decode(bytes.data(), bytes.size(), image);
}

}  // namespace fringetwin
