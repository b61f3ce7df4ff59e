// SPDX-License-Identifier: Apache-2.0
// Checks a study before anything runs: reads the twin with the settings of its points, and takes the SHA-256
// of every file they name.
#pragma once
#include "study/plan/study_head.hpp"
#include "study/plan/study_point.hpp"

namespace fringetwin::study {

/// Loads the twin with the settings of the first point that can be read, and of every point that sets a
/// string, which may name a file. A key path that does not exist, and a design none of whose points can be
/// read, is a UserError(usage): points that fail alone are for the runner to record.
StudyIdentity check_study(const StudyHead& study, const PointSequence& points);

}  // namespace fringetwin::study
