// SPDX-License-Identifier: Apache-2.0
// Says whether the text of a JSON file asks for more than the library may be given (docs/FORMATS.md,
// "Limits").
#pragma once
#include <string>
#include <string_view>

namespace fringetwin {

/// Returns what is too much in the text, empty where it may be parsed. What is no JSON is for the library to
/// say.
std::string json_excess(std::string_view text);

}  // namespace fringetwin
