// SPDX-License-Identifier: Apache-2.0
// Writes a comparison or a measurement as the text of result.json, schema "fringetwin-result/1"
// (docs/formats/results.md, docs/result.schema.json).
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/result/provenance.hpp"
#include "compare/result/rows.hpp"
#include "measure/measurement.hpp"
#include "twin/twin.hpp"

namespace fringetwin::compare {

/// Returns the text of a comparison: plain numbers in the unit their key names, null where unknown or not
/// finite.
std::string comparison_json(const Twin& twin, const Comparison& comparison, const Provenance& provenance,
                            const std::map<std::string, double>& timing_s);

/// Returns the same of a measurement, with fits[].measured and, besides the contract, decode and
/// triangulation counts.
std::string measurement_json(const Twin& twin, const measure::Measurement& measurement,
                             const Provenance& provenance, const std::map<std::string, double>& timing_s);
/// The same as values, for a caller that takes numbers out of it.
nlohmann::ordered_json measurement_tree(const Twin& twin, const measure::Measurement& measurement,
                                        const Provenance& provenance,
                                        const std::map<std::string, double>& timing_s);

}  // namespace fringetwin::compare
