// SPDX-License-Identifier: Apache-2.0
// What a user or a desktop does to a window. For *_test.cpp only; apart, because Xlib's macros are plain
// words.
#pragma once
#include <string>

namespace fringetwin::testing {

/// To the topmost window of the display's first screen; false if there is none.
bool ask_window_to_close(const std::string& display_name);
bool press_escape(const std::string& display_name);
/// Another window comes and goes over it.
bool cover_and_uncover(const std::string& display_name);

}  // namespace fringetwin::testing
