// SPDX-License-Identifier: Apache-2.0
#include "twin/captures/stored_images.hpp"

#include <fmt/format.h>

#include <atomic>

#include "twin/base/errors.hpp"
#include "twin/captures/load_images.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

void check_any(const CaptureSet& set, const CaptureCamera& source) {
  if (!source.files.empty()) return;
  const bool listed = source.pattern.empty();
  throw UserError(ExitCode::input, listed ? set.file.string() : source.pattern,
                  fmt::format("camera \"{}\" has no image", source.name),
                  listed ? "name them: files = [...]"
                         : "a pattern counts from 0; check pattern and root in capture.toml");
}

StoredImages load_camera(const CaptureSet& set, const CaptureCamera& source) {
  check_any(set, source);
  const bool radiance = has_radiance(source);
  const fs::path& first = source.files.front();
  const ImageKind kind = radiance ? check_exr(first) : check_gray(first, set.channel);
  const RightSize right{kind.width, kind.height, fmt::format("the camera's first image, {},", first.string()),
                        "the images of a camera have one size"};
  std::atomic<bool> has_16_bits = false;
  LoadedImages loaded = load_images(source, [&](const fs::path& file) {
    if (radiance) return read_irradiance(file, right);
    LoadedGray gray = read_gray(file, right, set.channel);
    if (gray.file_bits == 16) has_16_bits = true;
    return std::move(gray.image);
  });
  return {.camera = source.name,
          .images = std::move(loaded.images),
          .white = std::move(loaded.white),
          .black = std::move(loaded.black),
          .file_bits = radiance      ? 32
                       : has_16_bits ? 16
                                     : 8,
          .radiance = radiance};
}

}  // namespace

std::vector<StoredImages> load_stored_images(const CaptureSet& set) {
  std::vector<StoredImages> cameras;
  for (const CaptureCamera& camera : set.cameras) cameras.push_back(load_camera(set, camera));
  return cameras;
}

}  // namespace fringetwin
