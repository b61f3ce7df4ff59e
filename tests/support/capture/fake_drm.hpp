// SPDX-License-Identifier: Apache-2.0
// A graphics card in software in the place of libdrm's functions, with vertical blanking and every fault. For
// *_test.cpp only; a program that links it has no real card.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace fringetwin::testing {

/// One connector of 1280x720@60 and 1920x1080@60 (preferred), one CRTC, which showed a console before.
struct FakeDrm {
  // how it behaves
  bool connected = true;
  bool other_master = false;
  bool counts_refreshes = true;
  bool answers = true;         ///< sends events
  int mode_error = 0;          ///< of setting a mode
  int flip_error = 0;          ///< of the next page flips
  int refuse_property = 0;     ///< this one cannot be set
  std::uint64_t late = 0;      ///< refreshes that the next flips come too late
  bool has_gamma_blob = true;  ///< else only the table from before

  // what it is asked for
  std::uint64_t sequence = 0xffff'fffd;  ///< the last refresh, near a wrap
  std::uint32_t buffer = console;
  int width = 1920, height = 1080;
  std::map<std::uint32_t, std::uint64_t> properties{
      {broadcast, 0}, {dpms, 3}, {scaling, 1}, {gamma, 77}, {ctm, 0}};
  std::map<std::uint32_t, std::vector<std::uint8_t>> blobs{{77, {1, 2, 3, 4, 5, 6, 7, 8}}};
  std::vector<std::uint16_t> table{9, 8, 7, 6};                ///< the gamma table from before
  std::map<std::uint32_t, std::vector<std::uint8_t>> buffers;  ///< that exist, without contents
  int dumb_buffers = 0;

  static constexpr std::uint32_t console = 5, broadcast = 1, dpms = 2, scaling = 3, gamma = 10, ctm = 11;
  static constexpr std::int64_t period_ns = 16'666'667;
};

/// The card, as new; its path is for KmsCard::open.
FakeDrm& new_fake_drm(std::string* path);

}  // namespace fringetwin::testing
