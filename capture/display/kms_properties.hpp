// SPDX-License-Identifier: Apache-2.0
// Turns off what stands between a frame buffer and the cable (gamma tables, colour matrices, limited range,
// scalers) while patterns are shown, and restores it afterwards.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "capture/display/kms_card.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::capture {

class KmsProperties : NotCopyable {
 public:
  KmsProperties(std::shared_ptr<KmsCard> card, std::uint32_t crtc, std::uint32_t connector);
  ~KmsProperties();

  /// E.g. "Broadcast RGB = Full, GAMMA_LUT off"; what the driver has.
  const std::string& set() const { return set_; }
  /// Returns what the driver has and would not turn off; empty if nothing.
  const std::string& refused() const { return refused_; }

 private:
  void set_choice(std::uint32_t object, std::uint32_t type, const char* name,
                  const std::vector<std::string>& choices);
  bool clear_blob(std::uint32_t crtc, const char* name);
  void make_gamma_linear(std::uint32_t crtc);
  void note(bool done, const std::string& what);

  std::shared_ptr<KmsCard> card_;
  std::vector<std::function<void()>> restore_;
  std::string set_, refused_;
};

}  // namespace fringetwin::capture
