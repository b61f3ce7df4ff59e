// SPDX-License-Identifier: Apache-2.0
// The images of one camera become wrapped phases and, through them, absolute projector coordinates.
#pragma once
#include "measure/decode/decode_types.hpp"
#include "twin/captures/capture_set.hpp"

namespace fringetwin::measure {

/// Decodes one camera: N-step least squares (any N >= 3, any subset of steps), masks, then unwrapping as
/// fringes.unwrap says. `images` in sequence order. Throws UserError(usage) when the fringes cannot
/// be unwrapped as asked (heterodyne needs three pitches whose synthetic wavelength covers the
/// projector, gray needs its code ...).
CameraDecode decode(const CameraImages& images, const Fringes& fringes, const DecodeOptions& options);

}  // namespace fringetwin::measure
