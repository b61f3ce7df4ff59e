// SPDX-License-Identifier: Apache-2.0
// The EXR half of image_io.hpp, through OpenEXR's C++ interface.
#include <OpenEXR/ImfArray.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfThreading.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "twin/base/errors.hpp"
#include "twin/image/exr_header.hpp"
#include "twin/image/image_io.hpp"
#include "twin/image/image_limits.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

constexpr float kMostIrradiance = 1e18F;  // the squares of larger values are no floats

void use_exr_threads() {
  static const bool once = (Imf::setGlobalThreadCount(2), true);
  (void)once;
}

// OpenEXR addresses pixel (x,y) of the data window as base + x*xStride + y*yStride.
Imf::Slice float_slice(const ImageF& image, const Imath::Box2i& window) {
  const std::size_t row_bytes = sizeof(float) * static_cast<std::size_t>(image.width);
  return Imf::Slice::Make(Imf::FLOAT, image.data.data(), window, sizeof(float), row_bytes);
}

/// Keeps the bytes of a file in pieces: one that grows as a whole is there two or three times while it does.
class Pieces : public Imf::OStream {
 public:
  Pieces() : OStream("memory") {}
  void write(const char* bytes, int n) override {
    for (std::uint64_t left = static_cast<std::uint64_t>(n); left > 0;) {
      if (at_ / kPiece == pieces_.size()) pieces_.emplace_back(kPiece);
      const std::uint64_t first = at_ % kPiece, part = std::min(left, kPiece - first);
      std::copy_n(bytes, part, pieces_[at_ / kPiece].begin() + static_cast<std::ptrdiff_t>(first));
      bytes += part, left -= part, at_ += part;
      size_ = std::max(size_, at_);
    }
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t position) override {
    FT_CHECK(position <= size_, "an EXR is written over where it has been written");
    at_ = position;
  }
  std::vector<FileBytes> bytes() const {
    std::vector<FileBytes> out;
    for (std::size_t k = 0; k < pieces_.size(); ++k)
      out.push_back(std::as_bytes(std::span(pieces_[k])).first(std::min(kPiece, size_ - k * kPiece)));
    return out;
  }

 private:
  static constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;
  std::vector<std::vector<char>> pieces_;
  std::uint64_t at_ = 0, size_ = 0;
};

/// Gives the bytes of the file. OpenEXR writes the last of them in a destructor, which cannot say that the
/// disk is full: so it does not write to the disk.
void encode_channels(const std::vector<NamedChannel>& channels, Pieces& bytes) {
  const ImageF& first = *channels.front().second;
  Imf::Header header(first.width, first.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.zipCompressionLevel() = 1;  // 3 times faster than the default 4 and a few per cent larger
  Imf::FrameBuffer frame;
  for (const auto& [name, image] : channels) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    frame.insert(name, float_slice(*image, header.dataWindow()));
  }
  Imf::OutputFile output(bytes, header);
  output.setFrameBuffer(frame);
  output.writePixels(first.height);
}

using Channels = std::vector<std::pair<std::string, ImageF>>;

Channels read_channels(const fs::path& file) {
  Imf::InputFile input(file.c_str());
  if (!input.isComplete())
    throw UserError(ExitCode::input, file.string(), "is truncated (an incomplete EXR)", "write it again");
  const Imath::Box2i window = input.header().dataWindow();
  const int width = window.max.x - window.min.x + 1;
  const int height = window.max.y - window.min.y + 1;
  Channels channels;
  const Imf::ChannelList& list = input.header().channels();
  for (auto it = list.begin(); it != list.end(); ++it)
    channels.emplace_back(it.name(), ImageF(width, height));
  Imf::FrameBuffer frame;
  for (const auto& [name, image] : channels) frame.insert(name, float_slice(image, window));
  input.setFrameBuffer(frame);
  input.readPixels(window.min.y, window.max.y);
  return channels;
}

/// Bytes for the channels, and for the four blocks of up to 256 lines that OpenEXR keeps.
std::uint64_t decoding_bytes(const PromisedImage& image, std::uint64_t n_values) {
  return sizeof(float) * (n_values + 4 * 256 * image.width * image.channels);
}

/// Calls `use` with the channels of an EXR that `accept` takes by its header.
template <typename Accept, typename Use>
auto with_channels(const fs::path& file, const std::optional<RightSize>& right, const Accept& accept,
                   const Use& use) {
  const std::uintmax_t file_bytes = check_image_file(file);
  const PromisedImage promised = read_exr_header(file);
  accept(promised);
  const std::uint64_t n_values = check_promise(file, promised, file_bytes, right);
  use_exr_threads();
  const DecodingMemory memory(decoding_bytes(promised, n_values));
  try {
    return use(read_channels(file));
  } catch (const UserError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("is no EXR that can be decoded, or is truncated ({})", e.what()));
  }
}

template <typename Use>
auto with_only_channel(const fs::path& file, const std::optional<RightSize>& right, const Use& use) {
  const auto one = [&](const PromisedImage& image) {
    if (image.channels != 1)
      throw UserError(ExitCode::input, file.string(),
                      fmt::format("has {} channels, an irradiance image has one (Y)", image.channels));
  };
  return with_channels(file, right, one,
                       [&](Channels&& read) { return use(std::move(read.front().second)); });
}

}  // namespace

void write_exr(const fs::path& file, const std::vector<NamedChannel>& channels) {
  FT_CHECK(!channels.empty(), "an EXR needs a channel");
  for (const auto& [name, image] : channels)
    FT_CHECK(image != nullptr && !image->empty() && image->same_size(*channels.front().second),
             "channel " + name + " has another size than the first one");
  use_exr_threads();
  Pieces pieces;
  encode_channels(channels, pieces);
  write_whole_file(file, pieces.bytes());
}

std::vector<std::pair<std::string, ImageF>> read_exr(const fs::path& file) {
  return with_channels(
      file, {}, [](const PromisedImage&) {}, [](Channels&& read) { return read; });
}

ImageF read_irradiance(const fs::path& file, const RightSize& right) {
  ImageF image = with_only_channel(file, right, [](ImageF&& read) { return read; });
  const auto no_light = [](float v) { return !(std::abs(v) <= kMostIrradiance); };
  if (const auto at = std::ranges::find_if(image.data, no_light); at != image.data.end()) {
    const auto index = static_cast<int>(at - image.data.begin());
    throw UserError(ExitCode::input, file.string(),
                    fmt::format("value {} at pixel ({}, {}) is no irradiance", *at, index % image.width,
                                index / image.width));
  }
  return image;
}

ImageKind check_exr(const fs::path& file) {
  return with_only_channel(file, {}, [](const ImageF& read) {
    return ImageKind{read.width, read.height, 32};
  });
}

}  // namespace fringetwin
