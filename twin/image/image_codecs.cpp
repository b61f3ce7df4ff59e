// SPDX-License-Identifier: Apache-2.0
#include "twin/image/image_codecs.hpp"

#include "twin/base/module_loader.hpp"

namespace fringetwin {
bool decode_image(const std::vector<std::uint8_t>& bytes, DecodedImage* image) {
  static const auto decode = reinterpret_cast<DecodeImageFunction>(
      find_in_module("libfringetwin_image_codecs.so", kDecodeImageName,
                     {ExitCode::input, "BMP, TIFF and PGM images", "reads them",
                      "put it beside the program, or convert the images to PNG"}));
  return decode(bytes.data(), bytes.size(), image);
}

}  // namespace fringetwin
