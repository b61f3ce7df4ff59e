// SPDX-License-Identifier: Apache-2.0
// Which code has run: g++ calls us at each branch of what FRINGETWIN_FUZZ builds
// (-fsanitize-coverage=trace-pc). Without that option nothing is ever new.
#pragma once

namespace fringetwin::fuzz {

/// Forgets what the last input ran.
void begin_coverage();
/// Returns whether code ran since that had not run in any earlier input of this process.
bool found_new_code();

}  // namespace fringetwin::fuzz
