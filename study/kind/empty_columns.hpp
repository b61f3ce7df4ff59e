// SPDX-License-Identifier: Apache-2.0
// Finds the columns of a study that stay empty, and says why: numbers of the theory of the noise for twins
// that it does not know, and results that no run has.
#pragma once
#include <string>
#include <vector>

#include "study/plan/study_head.hpp"
#include "study/plan/study_point.hpp"
#include "study/store/study_store.hpp"

namespace fringetwin::study {

/// Throws UserError(usage) where a record asks the theory of the noise for a number and it knows the twin of
/// none of these points. Points that are no valid twin do not count. Throws Cancelled.
void refuse_outside_noise_theory(const StudyHead& head, const PointSequence& points);

/// Returns the warnings, in whole sentences, of a study's finished rows: one of the points that have no
/// number of the theory of the noise, with the reasons, and one per recorded name that is null in all of
/// them.
std::vector<std::string> empty_column_warnings(const StudyHead& head, const std::vector<StoredPoint>& rows);

}  // namespace fringetwin::study
