// SPDX-License-Identifier: Apache-2.0
// Gives the present time and the name of this machine, as they are written beside results, what its
// environment says, and what it allows.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace fringetwin {

/// Returns the present second in UTC, "2026-01-31T12:00:00Z".
std::string utc_now();
/// Returns the network name of this machine; an empty string where it has none.
std::string host_name();
/// Returns the value of an environment variable; an empty string where it is not set.
std::string environment_value(const char* name);
/// Returns how many bytes of addresses this process may still take (`ulimit -v`); nothing without a limit.
std::optional<std::uintmax_t> addresses_left();

}  // namespace fringetwin
