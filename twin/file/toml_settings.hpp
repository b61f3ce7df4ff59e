// SPDX-License-Identifier: Apache-2.0
// Puts values into a parsed TOML file by the path of their key. For toml_reader.cpp only: the header takes
// toml++ along.
#pragma once
#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace fringetwin {

/// Puts each value (TOML text) at its path: "fringes.pitches_px[0]", "camera.left.sensor.gain_dn" (entries of
/// a list of tables by their "name" or "object", or by index: "camera[0]"). Tables that are missing are made;
/// whether their keys are known is for the reader to say. A node put in names its setting as its source.
/// Throws UnknownKey where the path leads nowhere, UserError(usage) for a value that is no TOML.
void put_settings(toml::table& document, const std::map<std::string, std::string>& settings,
                  const std::filesystem::path& file);

/// Returns the number at such a path; nullopt where the key is left out or is no number. Throws as
/// put_settings does.
std::optional<double> number_at(toml::table document, const std::string& key,
                                const std::filesystem::path& file);

}  // namespace fringetwin
