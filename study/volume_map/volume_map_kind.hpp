// SPDX-License-Identifier: Apache-2.0
// Makes the Kind of a study of kind "volume-map": a sphere at a lattice of positions.
#pragma once
#include <memory>

#include "study/kind/kind.hpp"
#include "study/volume_map/volume_map.hpp"

namespace fringetwin::study {

/// The head must outlive it.
std::unique_ptr<Kind> make_kind(const StudyHead& head, const VolumeMapPlan& plan);

}  // namespace fringetwin::study
