// SPDX-License-Identifier: Apache-2.0
// Says what is wrong with a command line that CLI11 refused, in one sentence of ours: which command or option
// there is instead, which one is missing, what a value must be.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "twin/base/errors.hpp"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace fringetwin::cli {

/// Returns the sentence for `arguments` (without the program's name), with exit code 2.
UserError argument_fault(const CLI::App& program, const std::vector<std::string>& arguments,
                         const CLI::ParseError& refusal);

/// Returns what is wrong where CLI11 has taken an option of the command for the value of another one:
/// "--from --out DIR".
std::optional<UserError> fault_of_taken_option(const CLI::App& program,
                                               const std::vector<std::string>& arguments);

/// Returns the command that these words name, "import", "opencv". Throws UserError(usage) with the nearest
/// one.
const CLI::App& find_command(const CLI::App& program, const std::vector<std::string>& words);

}  // namespace fringetwin::cli
