// SPDX-License-Identifier: Apache-2.0
// Says in one line what the images of a sequence are.
#pragma once
#include <string>

#include "twin/fringes.hpp"

namespace fringetwin {

/// Returns what the sequence is made of, by file number, in one line however long it is: "0-3: x pitch 13 in
/// 4 steps; 4-9: x 6 gray bits, most significant first".
std::string sequence_outline(const Fringes& fringes);

}  // namespace fringetwin
