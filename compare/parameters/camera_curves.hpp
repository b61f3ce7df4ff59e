// SPDX-License-Identifier: Apache-2.0
// Lists what bends a camera's gray values as parameters of the groups camera_response and camera_knee
// (docs/metrics/causes.md, "Causes").
#pragma once
#include "compare/parameters/parameter.hpp"

namespace fringetwin::compare {

/// Returns the smooth curves of a camera's response that the search for causes tries: an exponent and three
/// polynomials. No key of twin.toml holds them.
std::vector<Parameter> response_parameters(const Camera& camera);

/// Returns what `--refine camera_response` fits: three numbers c that bend what the camera's response gives,
/// one after the other: y becomes y + R c s^2 T_k(2 s - 1), k = 0, 1, 2, R the sensor's range above black, s
/// from 0 at y = R/20 to 1 at R. The twin holds the curve as a table.
std::vector<Parameter> bend_parameters(const Twin& twin, std::size_t camera);

/// Returns the slope beyond the knee and, after it, the knee's place, in this order: the place's effect is
/// that of the fitted slope. Empty where the camera's response is a table of more than one corner. Of a
/// camera whose response is straight the place begins at 40 % of its range; it changes nothing until the
/// slope has left 1.
std::vector<Parameter> knee_parameters(const Twin& twin, std::size_t camera);

}  // namespace fringetwin::compare
