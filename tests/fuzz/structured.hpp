// SPDX-License-Identifier: Apache-2.0
// Changes inputs knowing their format, so that what comes out still passes the first checks of its reader.
#pragma once
#include <string>

#include "tests/fuzz/random.hpp"

namespace fringetwin::fuzz {

/// TOML: keys are renamed, dotted, exchanged; tables become lists of tables and the other way round.
std::string mutate_toml(const std::string& input, Random& random);
/// PLY: elements and properties of the header are doubled, dropped, counted and typed otherwise; the body
/// stays.
std::string mutate_ply(const std::string& input, Random& random);
/// Camera models and other texts that name a lens model: its name gets another configuration.
std::string mutate_lens(const std::string& input, Random& random);
/// PNG: fields of the chunks are changed and the checksums made right again.
std::string mutate_png(const std::string& input, Random& random);

/// Returns a lens model's name, of those that libmrcal knows or nearly so.
std::string lens_name(Random& random);

}  // namespace fringetwin::fuzz
