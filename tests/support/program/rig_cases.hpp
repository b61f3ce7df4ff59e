// SPDX-License-Identifier: Apache-2.0
// The independent rig with one thing that its twin does not know, and the same with a twin that does.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace fringetwin::testing {

// | case            | the rig has                     | the twin says                         |
// |-----------------|---------------------------------|---------------------------------------|
// | right           | gamma 1, no blur                | the same                              |
// | right_bent      | gamma 1.2, blur 1 px            | the same                              |
// | right_bounce    | light over a second surface     | the same ([render] bounces all)       |
// | gain_tilt       | a gain 5 % larger at the right border than at the left one | one gain   |
// | gamma           | gamma 1.2, blur 1 px            | gamma 1, blur 1 px                    |
// | pose            |                                 | the ball 0.05 mm away: (0.03, 0, 0.04) |
// | projector_k1    |                                 | the projector's k1 = 0                |
// | blur            | gamma 1.2, blur 1 px            | gamma 1.2, no blur                    |
// | second_bounce   | light over a second surface     | none                                  |
const std::vector<std::string>& right_cases();
const std::vector<std::string>& wrong_cases();

/// Writes twin.toml and real/ of a case into a fresh scratch folder and returns the folder. Needs POV-Ray
/// (FT_NEED_POVRAY).
std::filesystem::path write_case(const std::string& name, std::uint64_t seed = 1);

}  // namespace fringetwin::testing
