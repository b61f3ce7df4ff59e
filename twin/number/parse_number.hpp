// SPDX-License-Identifier: Apache-2.0
// Reads a text that is one number and nothing else, and writes a number as a text, in every locale alike.
#pragma once
#include <optional>
#include <string>
#include <string_view>

namespace fringetwin {

/// Returns the number that the whole text writes, with '.' as the decimal point; nullopt when the text is
/// empty, has a blank, a '+' or anything else around the number, or is beyond Number's range. "nan" and "inf"
/// are numbers of the type double. Number is int, unsigned, std::int64_t, std::size_t or double.
template <class Number>
std::optional<Number> parse_number(std::string_view text);

/// Returns the shortest text that reads back as the same number; whole numbers have no point, so that they
/// serve keys of TOML that take integers only and reals as well.
std::string number_text(double value);

}  // namespace fringetwin
