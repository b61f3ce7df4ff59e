// SPDX-License-Identifier: Apache-2.0
// Changes inputs at random: bytes, words, numbers and lines of any format.
#pragma once
#include <string>
#include <vector>

#include "tests/fuzz/random.hpp"

namespace fringetwin::fuzz {

/// No input grows beyond: readers' work grows with it, and what a reader does wrong with more, code makes
/// (tests/e2e/bad_files_made.py).
constexpr std::size_t kLargestInput = 64 * 1024;

/// Changes bytes: flips bits, puts extreme binary numbers, removes, copies, repeats, truncates.
std::string mutate_bytes(const std::string& input, Random& random);
/// Puts a word in, over other bytes or between them.
std::string insert_word(const std::string& input, const std::vector<std::string>& words, Random& random);
/// The beginning of one with the end of the other.
std::string splice(const std::string& a, const std::string& b, Random& random);

/// Changes text: numbers become extreme ones, values others of another kind, lines go, come twice, change
/// places.
std::string mutate_text(const std::string& input, Random& random);

/// Returns a number as text at which readers break: "1e999", "-1", "18446744073709551616".
std::string extreme_number(Random& random);
/// Returns a whole number at which they do, for binary fields.
std::uint64_t extreme_bits(Random& random);

std::vector<std::string> split_lines(const std::string& text);  ///< each with its line break
std::string joined(const std::vector<std::string>& parts);

}  // namespace fringetwin::fuzz
