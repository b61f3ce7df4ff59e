// SPDX-License-Identifier: Apache-2.0
// The reading half of image_io.hpp for gray images: what the header promises is checked before anything is
// decoded.
#include <fmt/format.h>

#include <algorithm>

#include "twin/base/errors.hpp"
#include "twin/base/module_loader.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_codecs.hpp"
#include "twin/image/image_header.hpp"
#include "twin/image/image_io.hpp"
#include "twin/image/image_limits.hpp"
#include "twin/image/png_codec.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

/// Decodes the bytes of a file. Returns false where they are no image or end too soon. Throws
/// UserError(input) when the module is not found.
bool decode_image(const std::vector<std::uint8_t>& bytes, const std::optional<ColourChannel>& channel,
                  DecodedImage* image) {
  static const auto decode = reinterpret_cast<DecodeImageFunction>(
      find_in_module("libfringetwin_image_codecs.so", kDecodeImageName,
                     {ExitCode::input, "BMP, TIFF, PGM and PPM images", "reads them",
                      "put it beside the program, or convert the images to PNG"}));
  return decode(bytes.data(), bytes.size(), channel ? &*channel : nullptr, image);
}

[[noreturn]] void refuse_undecodable(const fs::path& file) {
  throw UserError(ExitCode::input, file.string(), "is no image that can be decoded, or is truncated",
                  "gray PNG, BMP, PGM and upright TIFF are read");
}

GrayPixels decode_png(const fs::path& file, const std::vector<std::uint8_t>& bytes,
                      const std::optional<ColourChannel>& channel) {
  GrayPixels pixels;
  const std::string fault = decode_gray_png(bytes, channel, &pixels);
  if (!fault.empty()) throw UserError(ExitCode::input, file.string(), fault);
  return pixels;
}

GrayPixels decode_other_format(const fs::path& file, const std::vector<std::uint8_t>& bytes,
                               const std::optional<ColourChannel>& channel) {
  DecodedImage image;
  if (!decode_image(bytes, channel, &image)) refuse_undecodable(file);
  if (!image.fault.empty()) throw UserError(ExitCode::input, file.string(), image.fault);
  if (image.channels != 1 && !channel)
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("is a colour image ({} channels), a gray image is needed", image.channels),
                    kNameAColour);
  if (image.bits == 0 || image.channels != 1)
    throw UserError(ExitCode::input, file.string(), "does not hold 8 or 16 bit unsigned gray values");
  return {image.width, image.height, image.bits, std::move(image.values)};
}

/// Calls `use` with the pixels of a gray image, which are gone when it returns.
template <typename Use>
auto with_gray_pixels(const fs::path& file, const std::optional<RightSize>& right,
                      const std::optional<ColourChannel>& channel, const Use& use) {
  const std::uintmax_t file_bytes = check_image_file(file);
  const auto header = read_image_header(file);
  if (!header) refuse_undecodable(file);
  // Colour images are decoded only for a channel, and none of more than RGB and alpha is.
  const std::uint64_t channels = channel && header->channels <= 4 ? header->channels : 1;
  const std::uint64_t n_values =
      check_promise(file, {header->width, header->height, channels}, file_bytes, right);
  const DecodingMemory memory(file_bytes + n_values * static_cast<std::uint64_t>(header->decoding_bytes));
  const auto bytes = read_whole_bytes(file, {FileKind::image, "image", ExitCode::input, ""});
  const GrayPixels pixels =
      header->png ? decode_png(file, bytes, channel) : decode_other_format(file, bytes, channel);
  if (static_cast<std::uint64_t>(pixels.width) != header->width ||
      static_cast<std::uint64_t>(pixels.height) != header->height)
    refuse_undecodable(file);
  return use(pixels);
}

/// Returns the gray values, which stand as their bytes in native order.
LoadedGray to_float(const GrayPixels& pixels) {
  LoadedGray gray{ImageF(pixels.width, pixels.height), pixels.file_bits};
  if (pixels.file_bits == 16)
    std::copy_n(reinterpret_cast<const std::uint16_t*>(pixels.values.data()), gray.image.size(),
                gray.image.data.begin());
  else
    std::copy_n(pixels.values.begin(), gray.image.size(), gray.image.data.begin());
  return gray;
}

}  // namespace

LoadedGray read_gray(const fs::path& file, const std::optional<RightSize>& right,
                     const std::optional<ColourChannel>& channel) {
  return with_gray_pixels(file, right, channel, to_float);
}

ImageKind check_gray(const fs::path& file, const std::optional<ColourChannel>& channel) {
  return with_gray_pixels(file, {}, channel, [](const GrayPixels& pixels) {
    return ImageKind{pixels.width, pixels.height, pixels.file_bits};
  });
}

}  // namespace fringetwin
