// SPDX-License-Identifier: Apache-2.0
#include "twin/image/image_codecs.hpp"

#include <fmt/format.h>

#include "twin/base/errors.hpp"
#include "twin/base/module_loader.hpp"

namespace fringetwin {
namespace {

DecodeImageFunction load() {
  const ModuleFunction found = find_in_module("libfringetwin_image_codecs.so", kDecodeImageName);
  if (found.address) return reinterpret_cast<DecodeImageFunction>(found.address);
  throw UserError(ExitCode::input, "BMP, TIFF and PGM images",
                  fmt::format("the module that reads them cannot be loaded ({})", found.fault),
                  "put it beside the program, or convert the images to PNG");
}

}  // namespace

bool decode_image(const std::vector<std::uint8_t>& bytes, DecodedImage* image) {
  static const DecodeImageFunction decode = load();
  return decode(bytes.data(), bytes.size(), image);
}

}  // namespace fringetwin
