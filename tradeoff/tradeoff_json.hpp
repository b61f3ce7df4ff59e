// SPDX-License-Identifier: Apache-2.0
// Makes the parts that the JSON files and pages of `needs` and `pareto` share; internal to tradeoff/.
#pragma once
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "compare/result/provenance.hpp"
#include "render/base/device_info.hpp"
#include "tradeoff/image_change.hpp"
#include "tradeoff/pixel_subset.hpp"
#include "twin/twin.hpp"

namespace fringetwin::tradeoff {

/// Returns the start of a file: schema, twin, provenance {argv, version, inputs_sha256, device, seed},
/// machine, timing_s, subset.
nlohmann::ordered_json json_head(const std::string& schema, const Twin& twin,
                                 const compare::Provenance& provenance, const render::DeviceInfo& device,
                                 const PixelSubset& subset, const std::map<std::string, double>& timing_s);
nlohmann::ordered_json json_change(const ImageChange& change);
std::string json_text(const nlohmann::ordered_json& json);

/// Returns e.g. "2 x AMD EPYC 7763": number of CPUs this process may use and their model.
std::string machine_name();

/// Returns the tables of twin, command, version, device, machine and inputs.
std::string provenance_html(const Twin& twin, const compare::Provenance& provenance,
                            const render::DeviceInfo& device);

/// Returns e.g. "1.2e-05", "–" for NaN, "∞".
std::string scientific(double value);

}  // namespace fringetwin::tradeoff
