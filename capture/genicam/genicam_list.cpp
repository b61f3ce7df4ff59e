// SPDX-License-Identifier: Apache-2.0
#include "capture/genicam/genicam_list.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <thread>

#include "capture/device/pfnc_format.hpp"
#include "capture/genicam/genicam_options.hpp"
#include "capture/genicam/genicam_settings.hpp"
#include "twin/base/module_loader.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {
namespace {

using namespace std::chrono_literals;

/// A camera takes control away from a program that is silent for 3 s (GigE Vision's default).
constexpr auto kHeldFor = 5s;
constexpr auto kLookAgain = 500ms;

std::string name_of(const GenicamListed& listed) {
  return kGenicamPrefix + (listed.serial.empty() ? listed.id : listed.serial);
}

std::string who(const GenicamListed& listed) {
  return fmt::format("{} {} ({}{}{})", listed.vendor, listed.model, listed.protocol,
                     listed.address.empty() ? "" : ", ", listed.address);
}

std::string formats_text(const GenicamFeature& formats) {
  std::vector<std::string> known, others;
  for (const std::string& choice : formats.choices)
    (pfnc_format_of_name(choice) != nullptr ? known : others).push_back(choice);
  return fmt::format("  {}\n", fmt::join(known, " ")) +
         (others.empty() ? "" : fmt::format("  not supported: {}\n", fmt::join(others, ", ")));
}

/// Opens a camera; one that is held by a program which has just been killed once it is free. `refusal`,
/// `hint`: what is said, before the fault and behind it, of one that cannot be opened.
std::unique_ptr<GenicamDevice> open_when_free(const std::string& name, const std::string& id,
                                              GenicamModule& module, const std::string& refusal,
                                              const std::string& hint = "") {
  const auto end = std::chrono::steady_clock::now() + kHeldFor;
  for (;;) {
    std::string fault;
    auto device = module.open(id, &fault);
    if (!device) throw UserError(ExitCode::device, name, refusal + ": " + fault, hint);
    if (device->controlled() || std::chrono::steady_clock::now() > end) return device;
    throw_if_cancelled();
    device.reset();
    std::this_thread::sleep_for(kLookAgain);
  }
}

/// Returns the address that a name is, unless a camera that was found has it; else "".
std::string unlisted_address(const std::vector<GenicamListed>& all, const std::string& name) {
  const std::string wanted = name.substr(std::string(kGenicamPrefix).size());
  in_addr ignored{};
  if (::inet_pton(AF_INET, wanted.c_str(), &ignored) != 1) return "";
  return std::ranges::find(all, wanted, &GenicamListed::address) == all.end() ? wanted : "";
}

/// Opens a network camera that looking around does not find (behind a router, where broadcasts do not reach).
/// Throws UserError(device) with the reason where none answers at that address.
std::unique_ptr<GenicamDevice> open_address(const std::string& address,
                                            std::map<std::string, std::string>* provenance,
                                            GenicamModule& module) {
  auto device =
      open_when_free(kGenicamPrefix + address, address, module,
                     "is not found among the cameras around, and does not answer at this address",
                     "look at its power, its address and the way to it; capture --list shows what is found");
  *provenance = {{"address", address}, {"protocol", "GigEVision"}, {"driver", module.version()}};
  for (const auto& [key, feature] : {std::pair{"vendor", "DeviceVendorName"},
                                     {"model", "DeviceModelName"},
                                     {"serial", "DeviceSerialNumber"}})
    (*provenance)[key] = device->feature(feature).value;
  return device;
}

}  // namespace

GenicamModule& genicam_module() {
  static const auto function = reinterpret_cast<GenicamModuleFunction>(
      find_in_module("libfringetwin_genicam.so", kGenicamModuleName,
                     {ExitCode::device, "genicam", "speaks to GenICam cameras",
                      "install Aravis (apt-get install libaravis-0.8-0); a program that was built without it "
                      "is built anew with libaravis-dev"}));
  return *function();
}

const GenicamListed& find_genicam(const std::vector<GenicamListed>& all, const std::string& name) {
  const std::string wanted = name.substr(std::string(kGenicamPrefix).size());
  std::vector<const GenicamListed*> meant;
  std::vector<std::string> names;
  for (const GenicamListed& listed : all) {
    names.push_back(name_of(listed));
    if (wanted.empty() || wanted == listed.serial || wanted == listed.id || wanted == listed.address)
      meant.push_back(&listed);
  }
  if (meant.size() == 1) return *meant.front();
  if (all.empty())
    throw UserError(
        ExitCode::device, name, "no GenICam camera is found",
        "look at its power and cable; a network camera needs an address in this machine's network, "
        "and a firewall must let UDP through");
  throw UserError(ExitCode::device, name,
                  meant.empty() ? "no such GenICam camera is found" : "means more than one camera",
                  fmt::format("there are {}", fmt::join(names, ", ")));
}

std::unique_ptr<GenicamDevice> open_genicam(const std::string& name,
                                            std::map<std::string, std::string>* provenance,
                                            GenicamModule& module) {
  const std::vector<GenicamListed> all = module.devices();
  if (const std::string address = unlisted_address(all, name); !address.empty())
    return open_address(address, provenance, module);
  const GenicamListed& listed = find_genicam(all, name);
  *provenance = {{"vendor", listed.vendor},     {"model", listed.model},     {"serial", listed.serial},
                 {"protocol", listed.protocol}, {"address", listed.address}, {"driver", module.version()}};
  return open_when_free(name, listed.id, module, "cannot be opened");
}

std::string describe(GenicamModule& module, const GenicamListed& listed) {
  std::string text = fmt::format("{}: {}\n", name_of(listed), who(listed));
  std::string fault;
  const auto device = module.open(listed.id, &fault);
  if (!device) return text + "  cannot be used: " + fault + "\n";
  if (!device->controlled()) text += "  held by another program\n";
  text += formats_text(device->feature("PixelFormat"));
  for (const char* name : {"Width", "Height", "ExposureTime", "ExposureTimeAbs", "Gain", "GainRaw",
                           "BlackLevel", "BlackLevelRaw", "AcquisitionFrameRate", "TriggerSource"})
    if (const GenicamFeature feature = device->feature(name); feature.there())
      text += fmt::format("  {}: {} (now {})\n", name, range_text(feature), feature.value);
  return text;
}

std::vector<std::string> list_genicam_cameras() {
  try {
    GenicamModule& module = genicam_module();
    std::vector<std::string> texts;
    for (const GenicamListed& listed : module.devices()) texts.push_back(describe(module, listed));
    return texts;
  } catch (const UserError& error) {
    return {std::string(error.what()) + "\n"};
  }
}

}  // namespace fringetwin::capture
