// SPDX-License-Identifier: Apache-2.0
// The images of a capture set as they are stored, where no twin says what they are.
#include <fmt/format.h>

#include "twin/base/errors.hpp"
#include "twin/base/parallel.hpp"
#include "twin/captures/capture_set.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

LoadedGray load_stored(const fs::path& file, const RightSize& right, bool radiance,
                       const std::optional<ColourChannel>& channel) {
  if (is_exr_name(file) != radiance)
    throw UserError(ExitCode::input, file.string(),
                    "a capture set has either EXR images (irradiance) or gray images, not both");
  if (radiance) return {read_irradiance(file, right), 32};
  return read_gray(file, right, channel);
}

CameraImages load_camera(const CaptureSet& set, const CaptureCamera& source) {
  if (source.files.empty())
    throw UserError(ExitCode::input, source.pattern.empty() ? set.file.string() : source.pattern,
                    fmt::format("camera \"{}\" has no image", source.name),
                    "a pattern counts from 0; check pattern and root in capture.toml");
  CameraImages loaded{.camera = source.name,
                      .radiance = is_exr_name(source.files.front()),
                      .gray_code_exposure = source.gray_code_exposure};
  const fs::path& first = source.files.front();
  const ImageKind kind = loaded.radiance ? check_exr(first) : check_gray(first, set.channel);
  if (!loaded.radiance) loaded.bit_depth = kind.bits;
  const RightSize right{kind.width, kind.height, fmt::format("the camera's first image, {}", first.string()),
                        "the images of a camera have one size"};
  const auto load = [&](const fs::path& file) {
    LoadedGray gray = load_stored(file, right, loaded.radiance, set.channel);
    if (gray.file_bits != kind.bits)
      throw UserError(ExitCode::input, file.string(),
                      fmt::format("holds {} bit values, {} {} bit ones", gray.file_bits, right.of, kind.bits),
                      "the images of a camera have values of one kind");
    return std::move(gray.image);
  };
  loaded.images.resize(source.files.size());
  for_each_parallel(static_cast<int>(source.files.size()),
                    [&](int i) { loaded.images[i] = load(source.files[i]); });
  if (source.white) loaded.white = load(*source.white);
  if (source.black) loaded.black = load(*source.black);
  return loaded;
}

}  // namespace

std::vector<CameraImages> load_stored_images(const CaptureSet& set) {
  std::vector<CameraImages> cameras;
  for (const CaptureCamera& camera : set.cameras) cameras.push_back(load_camera(set, camera));
  return cameras;
}

}  // namespace fringetwin
