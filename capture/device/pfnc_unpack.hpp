// SPDX-License-Identifier: Apache-2.0
// Unpacks runs of pixels of GenICam's packed formats into 16-bit numbers, eight at a time where the processor
// can shuffle bytes (SSSE3).
#pragma once
#include <cstddef>
#include <cstdint>

namespace fringetwin::capture {

/// n pixels; exactly ceil(n bits / 8) bytes are read. The first begins with the first byte.
void unpack_10p(const std::uint8_t* from, std::size_t n, std::uint16_t* to);
void unpack_12p(const std::uint8_t* from, std::size_t n, std::uint16_t* to);
void unpack_10packed(const std::uint8_t* from, std::size_t n, std::uint16_t* to);
void unpack_12packed(const std::uint8_t* from, std::size_t n, std::uint16_t* to);

/// Returns all words or-ed, before they are shifted.
unsigned unpack_words(const std::uint8_t* from, std::size_t n, int shift, std::uint16_t* to);

/// Leaves the vector instructions out, for tests and benchmarks.
void unpack_without_vectors(bool without);

}  // namespace fringetwin::capture
