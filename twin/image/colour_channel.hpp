// SPDX-License-Identifier: Apache-2.0
// Names one colour of an image file whose pixels have several: which of them is taken for the gray value.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fringetwin {

/// A colour; its number is its place among the values of an RGB pixel.
enum class ColourChannel { red = 0, green = 1, blue = 2 };

/// The names of the colours, in their order, as capture.toml and the options say them.
inline const std::vector<std::string> kColourChannelNames = {"red", "green", "blue"};

/// Returns the name of a colour.
inline const std::string& colour_channel_name(ColourChannel channel) {
  return kColourChannelNames[static_cast<std::size_t>(channel)];
}

/// Returns the colour of this name; nothing where there is none, as for an option that was not given.
inline std::optional<ColourChannel> colour_channel_of(const std::optional<std::string>& name) {
  for (const ColourChannel channel : {ColourChannel::red, ColourChannel::green, ColourChannel::blue})
    if (name == colour_channel_name(channel)) return channel;
  return {};
}

/// Keeps one value, of the type `Value`, of each pixel's `channels`, in place.
template <class Value>
void keep_channel(std::size_t channels, ColourChannel channel, std::vector<std::uint8_t>* bytes) {
  auto* values = reinterpret_cast<Value*>(bytes->data());
  const std::size_t n = bytes->size() / (channels * sizeof(Value));
  for (std::size_t k = 0; k < n; ++k) values[k] = values[k * channels + static_cast<std::size_t>(channel)];
  bytes->resize(n * sizeof(Value));
}

/// Keeps one colour of pixels of `channels` values with 8 or 16 bits each, in place.
inline void keep_channel(std::size_t channels, int bits, ColourChannel channel,
                         std::vector<std::uint8_t>* bytes) {
  if (bits == 16)
    keep_channel<std::uint16_t>(channels, channel, bytes);
  else
    keep_channel<std::uint8_t>(channels, channel, bytes);
}

}  // namespace fringetwin
