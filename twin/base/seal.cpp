// SPDX-License-Identifier: Apache-2.0
#include "twin/base/seal.hpp"

#include "twin/base/sha256.hpp"

namespace fringetwin {
namespace {

constexpr std::string_view kSeal = "# sha256 of the lines below: ";

std::string seal_line(std::string_view text) { return std::string(kSeal) + sha256_of_text(text); }

/// Returns what follows the first line.
std::string_view below(std::string_view sealed) {
  const auto end = sealed.find('\n');
  return end == std::string_view::npos ? "" : sealed.substr(end + 1);
}

}  // namespace

std::string seal(const std::string& text) { return seal_line(text) + "\n" + text; }

Seal check_seal(const std::string& sealed) {
  if (!sealed.starts_with(kSeal)) return Seal::none;
  return sealed.starts_with(seal_line(below(sealed)) + "\n") ? Seal::intact : Seal::broken;
}

std::string right_seal(const std::string& sealed) {
  return seal_line(sealed.starts_with(kSeal) ? below(sealed) : std::string_view(sealed));
}

}  // namespace fringetwin
