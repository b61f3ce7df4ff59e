// SPDX-License-Identifier: Apache-2.0
#include "capture/device/pfnc_unpack.hpp"

#include <algorithm>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace fringetwin::capture {
namespace {

bool without_vectors = false;

// --- one pixel at a time

struct Lsb10 {
  static std::uint16_t pixel(const std::uint8_t* from, std::size_t i) {
    const std::uint8_t* at = from + i / 4 * 5 + i % 4;
    const auto shift = static_cast<unsigned>(2 * (i % 4));
    return static_cast<std::uint16_t>((at[0] | at[1] << 8) >> shift & 0x3ff);
  }
  static constexpr std::size_t kBytesOfEight = 10;
};

struct Lsb12 {
  static std::uint16_t pixel(const std::uint8_t* from, std::size_t i) {
    const std::uint8_t* at = from + i / 2 * 3 + i % 2;
    const auto shift = static_cast<unsigned>(4 * (i % 2));
    return static_cast<std::uint16_t>((at[0] | at[1] << 8) >> shift & 0xfff);
  }
  static constexpr std::size_t kBytesOfEight = 12;
};

// The middle byte holds the low bits of both pixels, each in a half of its own.
template <int low_bits>
struct Gige {
  static std::uint16_t pixel(const std::uint8_t* from, std::size_t i) {
    const std::uint8_t* at = from + i / 2 * 3;
    const int low = at[1] >> 4 * (i % 2) & ((1 << low_bits) - 1);
    return static_cast<std::uint16_t>(at[2 * (i % 2)] << low_bits | low);
  }
  static constexpr std::size_t kBytesOfEight = 12;
};

// --- eight at a time: each pixel's two bytes are brought into a word, and what is its neighbours' is
// removed

#if defined(__x86_64__)
#define FRINGETWIN_SSSE3 __attribute__((target("ssse3")))

FRINGETWIN_SSSE3 inline __m128i eight(Lsb10, __m128i bytes) {
  const __m128i pairs =
      _mm_shuffle_epi8(bytes, _mm_setr_epi8(0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 6, 7, 7, 8, 8, 9));
  const __m128i high = _mm_mullo_epi16(pairs, _mm_setr_epi16(64, 16, 4, 1, 64, 16, 4, 1));
  return _mm_srli_epi16(high, 6);
}

FRINGETWIN_SSSE3 inline __m128i eight(Lsb12, __m128i bytes) {
  const __m128i pairs =
      _mm_shuffle_epi8(bytes, _mm_setr_epi8(0, 1, 1, 2, 3, 4, 4, 5, 6, 7, 7, 8, 9, 10, 10, 11));
  const __m128i high = _mm_mullo_epi16(pairs, _mm_setr_epi16(16, 1, 16, 1, 16, 1, 16, 1));
  return _mm_srli_epi16(high, 4);
}

// The middle byte below the pixel's own.
FRINGETWIN_SSSE3 inline __m128i gige_pairs(__m128i bytes) {
  return _mm_shuffle_epi8(bytes, _mm_setr_epi8(1, 0, 1, 2, 4, 3, 4, 5, 7, 6, 7, 8, 10, 9, 10, 11));
}

template <int low_bits>
FRINGETWIN_SSSE3 inline __m128i eight(Gige<low_bits>, __m128i bytes) {
  constexpr short kLow = (1 << low_bits) - 1, kHigh = static_cast<short>(0xff << low_bits);
  const __m128i pairs = gige_pairs(bytes);
  const __m128i high = _mm_and_si128(_mm_srli_epi16(pairs, 8 - low_bits), _mm_set1_epi16(kHigh));
  const __m128i even = _mm_and_si128(pairs, _mm_setr_epi16(kLow, 0, kLow, 0, kLow, 0, kLow, 0));
  const __m128i odd =
      _mm_and_si128(_mm_srli_epi16(pairs, 4), _mm_setr_epi16(0, kLow, 0, kLow, 0, kLow, 0, kLow));
  return _mm_or_si128(high, _mm_or_si128(even, odd));
}

/// Returns how many pixels it has unpacked: a multiple of eight. A load takes 16 bytes, of which those behind
/// the eight pixels must be the run's, too.
template <class Packing>
FRINGETWIN_SSSE3 std::size_t unpack_eights(const std::uint8_t* from, std::size_t n, std::uint16_t* to) {
  constexpr std::size_t kStep = Packing::kBytesOfEight, kLoad = 16;
  const std::size_t n_bytes = n / 8 * kStep;
  std::size_t at = 0;
  for (; at + kLoad <= n_bytes; at += kStep, to += 8)
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to),
                     eight(Packing(), _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + at))));
  return at / kStep * 8;
}

bool has_vectors() {
  static const bool has = __builtin_cpu_supports("ssse3") != 0;
  return has && !without_vectors;
}
#else
template <class Packing>
std::size_t unpack_eights(const std::uint8_t*, std::size_t, std::uint16_t*) {
  return 0;
}
bool has_vectors() { return false; }
#endif

template <class Packing>
void unpack(const std::uint8_t* from, std::size_t n, std::uint16_t* to) {
  const std::size_t done = has_vectors() ? unpack_eights<Packing>(from, n, to) : 0;
  for (std::size_t i = done; i < n; ++i) to[i] = Packing::pixel(from, i);
}

}  // namespace

void unpack_10p(const std::uint8_t* from, std::size_t n, std::uint16_t* to) { unpack<Lsb10>(from, n, to); }
void unpack_12p(const std::uint8_t* from, std::size_t n, std::uint16_t* to) { unpack<Lsb12>(from, n, to); }
void unpack_10packed(const std::uint8_t* from, std::size_t n, std::uint16_t* to) {
  unpack<Gige<2>>(from, n, to);
}
void unpack_12packed(const std::uint8_t* from, std::size_t n, std::uint16_t* to) {
  unpack<Gige<4>>(from, n, to);
}

unsigned unpack_words(const std::uint8_t* from, std::size_t n, int shift, std::uint16_t* to) {
  unsigned seen = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto word = static_cast<std::uint16_t>(from[2 * i] | from[2 * i + 1] << 8);
    seen |= word;
    to[i] = static_cast<std::uint16_t>(word >> shift);
  }
  return seen;
}

void unpack_without_vectors(bool without) { without_vectors = without; }

}  // namespace fringetwin::capture
