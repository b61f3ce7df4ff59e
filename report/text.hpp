// SPDX-License-Identifier: Apache-2.0
// Prints numbers and text as they appear on a page.
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace fringetwin::report {

/// &, <, >, " and ' as entities; control characters (twin/base/plain_text.hpp) but line breaks as ?.
std::string escape_html(std::string_view text);

/// Returns the text that escape_html() made this of.
std::string unescape_html(std::string_view escaped);

/// Returns a relative path as the address of a link: every byte that could mean something there (a colon,
/// too, which may end a scheme) as % and two hex digits.
std::string url_path(std::string_view path);

/// Letters, digits and - stay; every other byte as _ and two hex digits: nothing can leave an attribute,
/// and different names stay different.
std::string safe_id(std::string_view text);

/// Every `from` as `to`.
std::string replace_all(std::string_view text, std::string_view from, std::string_view to);

/// `significant` digits, plain decimals between 1e-4 and 1e6, else with an exponent; a non-finite
/// value is an en dash ("unknown").
std::string number(double value, int significant = 4);
/// Exactly `decimals` digits after the point; en dash when not finite.
std::string fixed(double value, int decimals);
/// fixed() with an explicit sign, for differences.
std::string signed_fixed(double value, int decimals);
/// "17.302 ± 0.004": the value to the digits its standard error justifies (two digits of sigma).
std::string with_sigma(double value, double sigma);
/// Thousands apart by thin spaces: "1 555 200".
std::string count(unsigned long long n);

/// A text as a cell of CSV (RFC 4180): in quotes where it has commas, quotes or line breaks.
std::string csv_cell(const std::string& text);

/// An argv as one line that a POSIX shell reads back as the same words.
std::string shell_command(const std::vector<std::string>& argv);

}  // namespace fringetwin::report
