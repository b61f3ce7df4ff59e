// SPDX-License-Identifier: Apache-2.0
// Which parameters the words of `--refine` mean, and which words cannot stand together.
#pragma once
#include <string>
#include <vector>

#include "compare/parameters/parameter.hpp"

namespace fringetwin::compare {

/// Returns whether a word of `--refine` means this parameter: its group, its name, or what stands before a
/// dot; a motion's group or name alone.
bool is_asked_by(const std::string& asked, const Parameter& parameter);
/// Returns whether this word is among those asked for.
bool is_asked(const std::vector<std::string>& asked, const char* word);
/// Returns whether a part of the projector's halo is asked for, of which the images of a code tell more.
bool asks_for_halo(const std::vector<std::string>& asked);

/// Returns the words that `--refine` takes, for messages: groups, "texture", "offset", "gain", "black".
std::string refine_names();

/// Returns the parameters that these words mean, in the order of the groups, compared on these phase steps
/// (empty: all). Throws UserError(usage) for a word that means nothing here, and for words of which the
/// images cannot tell what each means apart.
std::vector<Parameter> chosen_parameters(const Twin& twin, const std::vector<std::string>& asked,
                                         const std::vector<int>& use_steps = {});

/// Returns the same for a twin as it is written, which gets an empty halo where a part of one is asked for;
/// without words all parameters that there are.
std::vector<Parameter> refinable_parameters(const Twin& twin, const std::vector<std::string>& asked,
                                            const std::vector<int>& use_steps = {});

/// Returns whether a parameter that these words mean says where something is.
bool asks_for_places(const Twin& twin, const std::vector<std::string>& asked,
                     const std::vector<int>& use_steps);

/// Checks what was asked for: throws UserError(usage) for an unknown name, for what this twin does not have
/// and for gain with albedo: what needs no image to be refused.
void check_refine(const Twin& twin, const std::vector<std::string>& asked);

}  // namespace fringetwin::compare
