// SPDX-License-Identifier: Apache-2.0
// Writes the page that --help prints of a command: usage, arguments, options by purpose, examples.
#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "cli/manual/command_text.hpp"

namespace CLI {
class FormatterBase;
}

namespace fringetwin::cli {

/// Returns the page, no line of which is longer than `width` where its words allow that.
std::string help_page(const CommandText& command, std::size_t width = 100);

/// Returns what makes CLI11 print these pages.
std::shared_ptr<CLI::FormatterBase> help_formatter();

}  // namespace fringetwin::cli
