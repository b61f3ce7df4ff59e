// SPDX-License-Identifier: Apache-2.0
// Tells from the principal point of an imported device that width and height of its image were given the
// wrong way round: most files of a calibration do not say the size.
#pragma once
#include <string>

#include "calib/import/imported_rig.hpp"

namespace fringetwin::calib {

/// Returns a sentence where the principal point lies in the middle of an image of swapped sides, and more
/// than a tenth of a side off the middle of the one that was given; else an empty text. A projector whose
/// lens is shifted is in the middle of neither.
std::string swapped_size_doubt(const ImportedDevice& device);

}  // namespace fringetwin::calib
