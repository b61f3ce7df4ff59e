// SPDX-License-Identifier: Apache-2.0
// Does to a window what a user or a desktop does. For *_test.cpp only; apart, because Xlib's macros are plain
// words.
#pragma once
#include <string>

namespace fringetwin::testing {

/// These act on the topmost window of the display's first screen and return false if there is none.
bool ask_window_to_close(const std::string& display_name);
bool press_escape(const std::string& display_name);
/// Lets another window come and go over it.
bool cover_and_uncover(const std::string& display_name);

}  // namespace fringetwin::testing
