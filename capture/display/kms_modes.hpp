// SPDX-License-Identifier: Apache-2.0
// Chooses which connector and which mode of a graphics card a pattern display uses.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace fringetwin::capture {

/// "kms", "kms:/dev/dri/card0", "kms:/dev/dri/card0:HDMI-A-1", each with "@59.94" for a refresh rate.
struct KmsName {
  std::string card;       ///< empty: the first with a connected display
  std::string connector;  ///< empty: the first connected one
  std::optional<double> refresh_hz;
};
/// Throws UserError(usage).
KmsName parse_kms_name(const std::string& text);

struct KmsMode {
  int width = 0, height = 0;
  double refresh_hz = 0.0;
  bool preferred = false;
  bool progressive = true;  ///< every line once per refresh; others are never chosen
};
struct KmsConnector {
  std::string name;  ///< "HDMI-A-1"
  bool connected = false;
  std::vector<KmsMode> modes;
};

/// "1280x720@60.00 1920x1080@59.94 ...", each once.
std::string mode_list(const std::vector<KmsMode>& modes);

/// The index of the connector named, or of the first connected one. Throws UserError(device) about `where`.
std::size_t choose_connector(const std::vector<KmsConnector>& connectors, const std::string& name,
                             const std::string& where);

/// The index of the mode of exactly that size: of the rate asked for, else the preferred one, else the
/// fastest. Throws UserError(device) about `where`.
std::size_t choose_mode(const std::vector<KmsMode>& modes, int width, int height,
                        std::optional<double> refresh_hz, const std::string& where);

}  // namespace fringetwin::capture
