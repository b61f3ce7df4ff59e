// SPDX-License-Identifier: Apache-2.0
// Keeps results that cost more to make than to read in files, named by the content they were made from.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace fringetwin::render {

using Bytes = std::span<const std::byte>;

/// Returns the folder FRINGETWIN_CACHE; without it fringetwin/ in XDG_CACHE_HOME or ~/.cache; none if
/// FRINGETWIN_CACHE is empty or there is no home.
std::optional<std::filesystem::path> cache_folder();

/// When the folder holds more than this, the oldest files are removed.
constexpr std::uintmax_t kLargestCacheBytes = std::uintmax_t{2} << 30;

/// Returns the name under which a thing made from `parts` is kept: 40 hexadecimal digits.
std::string content_key(std::initializer_list<Bytes> parts);

/// Returns the bytes kept under `name`, nothing where there are none or they are damaged. That somebody else
/// has written them into the folder cannot be seen: who uses them checks what a run must not fail of.
std::optional<std::vector<std::uint8_t>> read_cached(const std::optional<std::filesystem::path>& folder,
                                                     const std::string& name);
/// Keeps `parts`, one after the other, under `name`. A folder that cannot be written costs nothing but time.
void write_cached(const std::optional<std::filesystem::path>& folder, const std::string& name,
                  std::initializer_list<Bytes> parts);

}  // namespace fringetwin::render
