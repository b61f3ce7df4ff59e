// SPDX-License-Identifier: Apache-2.0
// The EXR half of image_io.hpp, through OpenEXR's C++ interface.
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfThreading.h>
#include <fmt/format.h>

#include "twin/base/errors.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

void use_exr_threads() {
  static const bool once = (Imf::setGlobalThreadCount(2), true);
  (void)once;
}

// OpenEXR addresses pixel (x,y) of the data window as base + x*xStride + y*yStride.
Imf::Slice float_slice(const ImageF& image, const Imath::Box2i& window) {
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(image.width);
  return Imf::Slice::Make(Imf::FLOAT, image.data.data(), window, sizeof(float), row_bytes);
}

/// Returns the bytes of the file. OpenEXR writes the last of them in a destructor, which cannot say that the
/// disk is full: so it does not write to the disk.
std::string encode_channels(const std::vector<NamedChannel>& channels) {
  const ImageF& first = *channels.front().second;
  Imf::Header header(first.width, first.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.zipCompressionLevel() = 1;  // 3 times faster than the default 4 and a few per cent larger
  Imf::FrameBuffer frame;
  for (const auto& [name, image] : channels) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, float_slice(*image, header.dataWindow()));
  }
  Imf::StdOSStream bytes;
  {
    Imf::OutputFile output(bytes, header);
    output.setFrameBuffer(frame);
    output.writePixels(first.height);
  }
  return bytes.str();
}

void check_header(const fs::path& file, const Imf::Header& header, int parts, bool complete) {
  const auto refuse = [&](const std::string& what, const std::string& hint = "") {
    throw UserError(ExitCode::input, file.string(), what, hint);
  };
  if (parts > 1) refuse(fmt::format("is an EXR with {} parts, one part is read", parts));
  if (header.hasType() && (header.type() == "deepscanline" || header.type() == "deeptile"))
    refuse("is a deep EXR, a flat one is needed");
  if (!complete) refuse("is truncated (an incomplete EXR)", "write it again");
  if (header.dataWindow() != header.displayWindow())
    refuse("is an EXR whose data window is not its display window", "save it uncropped");
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
      refuse(fmt::format("channel {} is subsampled, full resolution is needed", it.name()));
  if (header.channels().begin() == header.channels().end()) refuse("is an EXR without channels");
}

std::vector<std::pair<std::string, ImageF>> read_channels(const fs::path& file) {
  Imf::MultiPartInputFile parts(file.c_str());
  check_header(file, parts.header(0), parts.parts(), parts.partComplete(0));
  Imf::InputFile input(file.c_str());
  const Imath::Box2i window = input.header().dataWindow();
  const int width = window.max.x - window.min.x + 1;
  const int height = window.max.y - window.min.y + 1;
  std::vector<std::pair<std::string, ImageF>> channels;
  const Imf::ChannelList& list = input.header().channels();
  for (auto it = list.begin(); it != list.end(); ++it)
    channels.emplace_back(it.name(), ImageF(width, height));
  Imf::FrameBuffer frame;
  for (const auto& [name, image] : channels) frame.insert(name, float_slice(image, window));
  input.setFrameBuffer(frame);
  input.readPixels(window.min.y, window.max.y);
  return channels;
}

}  // namespace

void write_exr(const fs::path& file, const std::vector<NamedChannel>& channels) {
  FT_CHECK(!channels.empty(), "an EXR needs a channel");
  for (const auto& [name, image] : channels)
    FT_CHECK(image != nullptr && !image->empty() && image->same_size(*channels.front().second),
             "channel " + name + " has another size than the first one");
  use_exr_threads();
  write_text_file(file, encode_channels(channels));
}

std::vector<std::pair<std::string, ImageF>> read_exr(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error))
    throw UserError(ExitCode::input, file.string(), "no such image", "check the name and the folder");
  use_exr_threads();
  try {
    return read_channels(file);
  } catch (const UserError&) {
    throw;
  } catch (const std::exception& e) {
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("is no EXR that can be decoded, or is truncated ({})", e.what()));
  }
}

}  // namespace fringetwin
