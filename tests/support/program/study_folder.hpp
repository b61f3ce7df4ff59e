// SPDX-License-Identifier: Apache-2.0
// A study of the small twin in a folder of its own, and `fringetwin study` on it.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/program/cli_runner.hpp"

namespace fringetwin::testing {

/// The head of a STUDY.toml beside the small twin.
inline const std::string kSmallStudy =
    "schema = \"fringetwin-study/1\"\nname = \"small\"\ntwin = \"twin.toml\"\n";

/// 4 radii x 2 sensors; a ball of 900 mm holds the camera.
inline const std::string kRadiiAndSensors = R"(
[[vary]]
key = "object.ball.radius_mm"
values = [18, 19, 900, 20]
[[vary]]
key = "camera.left.sensor.electrons_per_dn"
values = [40.0, 10.0]
)";

/// A folder with the small twin and this STUDY.toml.
std::filesystem::path study_folder(const std::string& name, const std::string& study);

/// Returns the arguments of `fringetwin study`: DIR/STUDY.toml --out DIR/OUT and more.
std::vector<std::string> study_arguments(const std::filesystem::path& dir, const std::string& out,
                                         const std::vector<std::string>& more = {});
RunResult run_study(const std::filesystem::path& dir, const std::string& out = "out",
                    const std::vector<std::string>& more = {});

}  // namespace fringetwin::testing
