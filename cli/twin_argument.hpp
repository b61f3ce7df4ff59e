// SPDX-License-Identifier: Apache-2.0
// Adds the argument TWIN.toml, and options that name one; in its place its folder may be given.
#pragma once
#include <string>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace fringetwin::cli {

/// Adds the argument; of a folder that holds a twin.toml, `twin` becomes that file.
CLI::Option* add_twin_argument(CLI::App& sub, std::string& twin, const std::string& meaning);

/// Adds an option that names one, alike.
CLI::Option* add_twin_option(CLI::App& sub, const std::string& name, std::string& twin,
                             const std::string& meaning);

}  // namespace fringetwin::cli
