// SPDX-License-Identifier: Apache-2.0
// Where and when something of a study was done.
#pragma once
#include <string>

namespace fringetwin::study {

/// "2026-01-31T12:00:00Z"
std::string utc_now();
/// Of this machine; empty where it has none.
std::string host_name();

}  // namespace fringetwin::study
