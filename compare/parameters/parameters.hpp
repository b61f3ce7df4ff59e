// SPDX-License-Identifier: Apache-2.0
// Lists what a twin can be wrong about as parameters, in groups: those of `--refine` and of the search for
// causes.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "compare/parameters/parameter.hpp"
#include "compare/parameters/parameter_groups.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns all parameters of a group that this twin has; none where it lacks what they describe (a response
/// given as a table, objects that cannot light each other ...). `use_steps`: the phase steps that are
/// compared; empty: all.
std::vector<Parameter> parameters_of(const Twin& twin, const std::string& group,
                                     const std::vector<int>& use_steps = {});

/// Returns the same as `--refine` fits them: it renders motions, of which the search takes the first order,
/// and has r^4 and r^6 of a vignetting besides.
std::vector<Parameter> refinable_parameters_of(const Twin& twin, const std::string& group,
                                               const std::vector<int>& use_steps = {});

/// Returns the parameter of one part of a harmonic of all fringes, as the group harmonics has it.
Parameter harmonic_parameter(const Twin& twin, int order, double Harmonic::*part);

/// Returns the twin with two parts of a halo of its projector that have no light, a near and a far one, so
/// that their shares and then their widths can be fitted; the twin as it is where it has a halo or none can
/// be rendered. The images of a code are then made as with a halo, from a table at points.
Twin with_empty_halo(const Twin& twin);
/// Returns the values with a little light in the parts of a halo that have none: where a fit begins whose
/// widths are to be told. A blur that is fitted, too, and the part next to it are half as wide then.
Eigen::VectorXd with_light_in_halo(const std::vector<Parameter>& parameters, Eigen::VectorXd values);
/// Takes the parts of a halo that have no light from the projector: of one that with_empty_halo() gave.
void drop_empty_halo(Twin& twin);

/// Returns the twin with these values in place of the start values; parameters change it one after the other,
/// those that change no twin leave it (Sensitivity::predicted() knows them).
Twin with_values(const Twin& twin, const std::vector<Parameter>& parameters, const Eigen::VectorXd& values);
Eigen::VectorXd start_values(const std::vector<Parameter>& parameters);

}  // namespace fringetwin::compare
