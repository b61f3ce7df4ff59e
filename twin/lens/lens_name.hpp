// SPDX-License-Identifier: Apache-2.0
// Checks the name of a lens model before libmrcal reads it: libmrcal reads the numbers of a name into 16 bits
// without a look at their size, multiplies them as int, and aborts on an order or a number of knots that it
// does not have.
#pragma once
#include <string>
#include <string_view>

namespace fringetwin {

/// Returns what is wrong with the numbers in the name of a lens model ("its order must be 2 or 3, is 7"),
/// empty where nothing is. A name that libmrcal does not know at all is none of this function's faults.
std::string lens_name_fault(std::string_view name);

/// Returns the name as sentences show it: a stranger's name can have any length.
std::string shown_lens_name(std::string_view name);

}  // namespace fringetwin
