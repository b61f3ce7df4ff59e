// SPDX-License-Identifier: Apache-2.0
#include "capture/display/kms_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "twin/base/errors.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

// 60 and 59.94 Hz are two modes; what users type is rounded to 0.01 Hz at best.
constexpr double kRateToleranceHz = 0.03;

double parse_rate(const std::string& rate, const std::string& name) {
  const double hz = parse_number<double>(rate).value_or(0.0);
  if (!(hz > 0.0))
    throw UserError(ExitCode::usage, name, fmt::format("'{}' is no refresh rate", rate),
                    "write it in Hz, e.g. kms@60 or kms:/dev/dri/card0:HDMI-A-1@59.94");
  return hz;
}

}  // namespace

KmsName parse_kms_name(const std::string& text) {
  KmsName name;
  std::string rest = text;
  if (const auto at = rest.find('@'); at != std::string::npos) {
    name.refresh_hz = parse_rate(rest.substr(at + 1), text);
    rest.erase(at);
  }
  const auto card = rest.find(':');
  if (rest.substr(0, card) != "kms")
    throw UserError(ExitCode::usage, text, "is no KMS display", "write kms, or kms:/dev/dri/card0:HDMI-A-1");
  if (card == std::string::npos) return name;
  const auto connector = rest.find(':', card + 1);
  name.card = rest.substr(card + 1, connector == std::string::npos ? connector : connector - card - 1);
  if (connector != std::string::npos) name.connector = rest.substr(connector + 1);
  if (name.card.empty() || (connector != std::string::npos && name.connector.empty()))
    throw UserError(ExitCode::usage, text, "a part of the name is empty",
                    "write kms, kms:/dev/dri/card0 or kms:/dev/dri/card0:HDMI-A-1");
  return name;
}

std::string mode_list(const std::vector<KmsMode>& modes) {
  std::set<std::string> seen;
  std::string list;
  for (const KmsMode& mode : modes) {
    const std::string text =
        fmt::format("{}x{}{}@{:.2f}", mode.width, mode.height, mode.progressive ? "" : "i", mode.refresh_hz);
    if (seen.insert(text).second) list += (list.empty() ? "" : " ") + text;
  }
  return list.empty() ? "none" : list;
}

std::size_t choose_connector(const std::vector<KmsConnector>& connectors, const std::string& name,
                             const std::string& where) {
  std::string states;
  for (std::size_t i = 0; i < connectors.size(); ++i) {
    const KmsConnector& connector = connectors[i];
    if (connector.connected && (name.empty() || connector.name == name)) return i;
    states += fmt::format("{}{} {}", states.empty() ? "" : ", ", connector.name,
                          connector.connected ? "connected" : "not connected");
  }
  const std::string there = states.empty() ? "it has no connectors" : "its connectors: " + states;
  if (name.empty())
    throw UserError(ExitCode::device, where, fmt::format("no display is connected ({})", there),
                    "plug the projector in and switch it on");
  throw UserError(ExitCode::device, where, fmt::format("{} is not there or not connected ({})", name, there),
                  "name a connected one, or plug the projector in and switch it on");
}

std::size_t choose_mode(const std::vector<KmsMode>& modes, int width, int height,
                        std::optional<double> refresh_hz, const std::string& where) {
  std::optional<std::size_t> best;
  const auto rank = [&](const KmsMode& mode) {  // larger is better
    return refresh_hz ? -std::abs(mode.refresh_hz - *refresh_hz)
                      : mode.refresh_hz + (mode.preferred ? 1e6 : 0.0);
  };
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const KmsMode& mode = modes[i];
    if (mode.width != width || mode.height != height || !mode.progressive) continue;
    if (refresh_hz && std::abs(mode.refresh_hz - *refresh_hz) > kRateToleranceHz) continue;
    if (!best || rank(mode) > rank(modes[*best])) best = i;
  }
  if (best) return *best;
  const std::string rate = refresh_hz ? fmt::format(" at {:g} Hz", *refresh_hz) : "";
  throw UserError(
      ExitCode::device, where,
      fmt::format("has no mode of the projector's {}x{} pixels{}; its modes: {}", width, height, rate,
                  mode_list(modes)),
      "patterns are never scaled: choose a display with that mode or correct the twin's projector");
}

}  // namespace fringetwin::capture
