// SPDX-License-Identifier: Apache-2.0
// Writes the manual page of a command for man(1), section 1.
#pragma once
#include <string>

#include "cli/manual/command_text.hpp"

namespace fringetwin::cli {

/// Returns "fringetwin-import-opencv", the name of the page of "import opencv"; of the program: "fringetwin".
std::string man_name(const std::string& command_path);

/// Returns the page in troff's man macros. It has no date, so that the same program writes the same bytes.
std::string man_page(const CommandText& command, const std::string& version);

}  // namespace fringetwin::cli
