// SPDX-License-Identifier: Apache-2.0
// A text file that shows whether it is as it was written: its first line, a TOML comment, holds the SHA-256
// of the rest.
#pragma once
#include <string>

namespace fringetwin {

/// Returns the text with its seal before it.
std::string seal(const std::string& text);

enum class Seal { none, intact, broken };
Seal check_seal(const std::string& sealed);
/// Returns the line that would be right for what follows the first line.
std::string right_seal(const std::string& sealed);

}  // namespace fringetwin
