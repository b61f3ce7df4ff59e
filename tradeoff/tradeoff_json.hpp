// SPDX-License-Identifier: Apache-2.0
// What the JSON files and pages of the studies share; internal to study/.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/result/provenance.hpp"
#include "cosim/chain.hpp"
#include "render/renderer.hpp"
#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"
#include "twin/twin.hpp"

namespace fringetwin::study {

/// Schema, twin, provenance {argv, version, inputs_sha256, device, seed}, machine, timing_s, subset.
nlohmann::ordered_json json_head(const std::string& schema, const Twin& twin,
                                 const compare::Provenance& provenance, const render::DeviceInfo& device,
                                 const PixelSubset& subset, const std::map<std::string, double>& timing_s);
nlohmann::ordered_json json_change(const ImageChange& change);
std::string json_text(const nlohmann::ordered_json& json);

/// "2 x AMD EPYC 7763": number of CPUs this process may use and their model.
std::string machine_name();

/// Twin, command, version, device, machine, inputs.
std::string provenance_html(const Twin& twin, const compare::Provenance& provenance,
                            const render::DeviceInfo& device);

/// "1.2e-05" / "–"
std::string scientific(double value);

}  // namespace fringetwin::study
