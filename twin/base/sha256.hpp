// SPDX-License-Identifier: Apache-2.0
// SHA-256 (FIPS 180-4) as lower-case hexadecimal digits.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "twin/base/not_copyable.hpp"

namespace fringetwin {

/// The digest of bytes that come in parts.
class Sha256 : NotCopyable {
 public:
  Sha256();
  ~Sha256();

  void add(std::span<const std::byte> bytes);
  /// Returns the 64 digits; nothing may be added afterwards.
  std::string hex();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string sha256_of_bytes(std::span<const std::byte> bytes);
std::string sha256_of_text(std::string_view text);
/// Throws UserError(input) with `hint` when the file cannot be read; Cancelled on the way through a large
/// one.
std::string sha256_of_file(const std::filesystem::path& file, const std::string& hint = "");

}  // namespace fringetwin
