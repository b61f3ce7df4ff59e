// SPDX-License-Identifier: Apache-2.0
#include "capture/display/kms_display.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "capture/display/kms_card.hpp"
#include "capture/display/kms_properties.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin::capture {
namespace kms {  // types of a member, so not without a name

// What a CRTC showed, shown again at the end.
class SavedCrtc : NotCopyable {
 public:
  SavedCrtc(std::shared_ptr<KmsCard> card, std::uint32_t crtc)
      : card_(std::move(card)), crtc_(drmModeGetCrtc(card_->fd(), crtc)) {
    const DrmResources resources(drmModeGetResources(card_->fd()));
    for (int i = 0; resources && i < resources->count_connectors; ++i) {
      const DrmConnector connector(drmModeGetConnectorCurrent(card_->fd(), resources->connectors[i]));
      const DrmEncoder encoder(connector ? drmModeGetEncoder(card_->fd(), connector->encoder_id) : nullptr);
      if (encoder && encoder->crtc_id == crtc) connectors_.push_back(connector->connector_id);
    }
  }
  ~SavedCrtc() {
    if (!crtc_) return;
    const bool shown = crtc_->mode_valid && crtc_->buffer_id && !connectors_.empty();
    const int count = static_cast<int>(connectors_.size());
    if (!shown || drmModeSetCrtc(card_->fd(), crtc_->crtc_id, crtc_->buffer_id, crtc_->x, crtc_->y,
                                 connectors_.data(), count, &crtc_->mode) != 0)
      drmModeSetCrtc(card_->fd(), crtc_->crtc_id, 0, 0, 0, nullptr, 0, nullptr);
    card_->give_crtc_back(crtc_->crtc_id);
  }

 private:
  std::shared_ptr<KmsCard> card_;
  DrmCrtc crtc_;
  std::vector<std::uint32_t> connectors_;
};

struct Choice {
  std::shared_ptr<KmsCard> card;
  KmsHead head;
  drmModeModeInfo mode{};
  double refresh_hz = 0.0;
  std::uint32_t crtc = 0;
};

}  // namespace kms

namespace {

// Slower than any refresh; a flip that takes longer does not come.
constexpr std::chrono::milliseconds kFlipTimeout{2000};

// The card named, or the first with a connected display.
std::shared_ptr<KmsCard> find_card(const KmsName& name, const std::string& text) {
  if (!name.card.empty()) return KmsCard::open(name.card);
  std::string tried;
  for (const std::string& path : kms_cards()) {
    try {
      auto card = KmsCard::open(path);
      for (const KmsHead& head : card->heads())
        if (head.facts.connected) return card;
      tried += fmt::format("; {}: no display is connected", path);
    } catch (const UserError& error) {
      tried += fmt::format("; {}", error.what());
    }
  }
  throw UserError(ExitCode::device, text,
                  "no graphics card with a connected display" + (tried.empty() ? " (no cards)" : tried),
                  "plug the projector in, or use the display 'window'");
}

// Everything that can be refused without touching the display.
kms::Choice choose(const std::string& text, int width, int height) {
  const KmsName name = parse_kms_name(text);
  kms::Choice choice;
  choice.card = find_card(name, text);
  std::vector<KmsHead> heads = choice.card->heads();
  std::vector<KmsConnector> facts;
  for (const KmsHead& head : heads) facts.push_back(head.facts);
  choice.head = heads[choose_connector(facts, name.connector, choice.card->path())];
  const std::string where = choice.card->path() + ":" + choice.head.facts.name;
  const std::size_t mode = choose_mode(choice.head.facts.modes, width, height, name.refresh_hz, where);
  choice.mode = choice.head.modes[mode];
  choice.refresh_hz = choice.head.facts.modes[mode].refresh_hz;
  choice.card->become_master();
  choice.crtc = choice.card->take_crtc(choice.head.connector);
  return choice;
}

}  // namespace

// The order of the members is that of opening; the reverse is what a display survives without a flash.
struct KmsDisplay::Hardware {
  Hardware(const std::string& text, int width, int height)
      : name(text),
        chosen(choose(text, width, height)),
        buffers{std::make_unique<KmsBuffer>(chosen.card, width, height),
                std::make_unique<KmsBuffer>(chosen.card, width, height)},
        saved(chosen.card, chosen.crtc),
        properties(chosen.card, chosen.crtc, chosen.head.connector),
        flips(mode_period_ns(chosen.mode), chosen.card->monotonic()),
        where(chosen.card->path() + ":" + chosen.head.facts.name) {}

  void set_mode();
  Shown flip();
  void find_out_timing();

  std::string name;
  kms::Choice chosen;
  std::array<std::unique_ptr<KmsBuffer>, 2> buffers;
  kms::SavedCrtc saved;
  KmsProperties properties;
  PageFlips flips;
  std::string where;
  std::size_t front = 0;    ///< the buffer on display
  std::string why_untimed;  ///< empty: the driver's stamps are good
};

void KmsDisplay::Hardware::set_mode() {
  const int fd = chosen.card->fd();
  if (drmModeSetCrtc(fd, chosen.crtc, buffers[front]->id(), 0, 0, &chosen.head.connector, 1, &chosen.mode) !=
      0)
    throw UserError(ExitCode::device, where,
                    fmt::format("the mode {}x{} at {:.2f} Hz cannot be set ({})", chosen.mode.hdisplay,
                                chosen.mode.vdisplay, chosen.refresh_hz, std::strerror(errno)),
                    "close what else uses the card, or try another mode or cable");
  drmModeSetCursor(fd, chosen.crtc, 0, 0, 0);  // fails where there is none
  const DrmConnector connector(drmModeGetConnectorCurrent(fd, chosen.head.connector));
  for (int i = 0; connector && i < connector->count_props; ++i) {
    const std::unique_ptr<drmModePropertyRes, FreedBy<drmModeFreeProperty>> property(
        drmModeGetProperty(fd, connector->props[i]));
    if (property && std::strcmp(property->name, "DPMS") == 0 && connector->prop_values[i] != DRM_MODE_DPMS_ON)
      drmModeConnectorSetProperty(fd, chosen.head.connector, property->prop_id, DRM_MODE_DPMS_ON);
  }
}

// Shows the buffer at the back.
Shown KmsDisplay::Hardware::flip() {
  PageFlip flip;
  Refresh before;
  std::uint64_t stamp_ns = 0;
  if (drmCrtcGetSequence(chosen.card->fd(), chosen.crtc, &before.sequence, &stamp_ns) == 0) {
    before.at_ns = static_cast<TimeNs>(stamp_ns);
    flip.before = before;
  }
  const FlipDone done =
      chosen.card->wait(chosen.card->flip(chosen.crtc, buffers[1 - front]->id()), kFlipTimeout);
  front = 1 - front;
  flip.sequence = done.sequence;
  flip.at_ns = done.at_ns;
  flip.received_ns = done.received_ns;
  return flips.add(flip);
}

// Two black flips: the first may meet a counter that the new mode has reset.
void KmsDisplay::Hardware::find_out_timing() {
  try {
    flip();
    if (!flip().timed) why_untimed = flips.why_untimed();
  } catch (const DeviceFault& fault) {
    throw UserError(ExitCode::device, where, fmt::format("shows no second picture ({})", fault.what()),
                    "close what else uses the card, or use the display 'window'");
  }
  flips = PageFlips(mode_period_ns(chosen.mode), chosen.card->monotonic());
}

KmsDisplay::KmsDisplay(const std::string& name, int width, int height)
    : hardware_(std::make_unique<Hardware>(name, width, height)) {
  Hardware& h = *hardware_;
  h.set_mode();
  h.find_out_timing();
  if (!h.why_untimed.empty())
    say(fmt::format("{}: when a pattern comes on is not known exactly ({})", h.where, h.why_untimed));
  if (!h.properties.refused().empty())
    warn(fmt::format("{}: the driver keeps its setting of {}; check that patterns arrive unchanged", h.where,
                     h.properties.refused()));
}

KmsDisplay::~KmsDisplay() = default;

DisplayInfo KmsDisplay::info() const {
  const Hardware& h = *hardware_;
  DisplayInfo info{h.name, h.chosen.mode.hdisplay, h.chosen.mode.vdisplay, 8, h.why_untimed.empty(), {}};
  info.provenance = {{"driver", h.chosen.card->driver()},
                     {"card", h.chosen.card->path()},
                     {"connector", h.chosen.head.facts.name},
                     {"mode", fmt::format("{}x{}", h.chosen.mode.hdisplay, h.chosen.mode.vdisplay)},
                     {"refresh_hz", fmt::format("{:.4f}", h.chosen.refresh_hz)},
                     {"timing", h.why_untimed.empty() ? "vertical blanking" : h.why_untimed}};
  if (h.chosen.refresh_hz > 0.0) info.frame_ms = 1000.0 / h.chosen.refresh_hz;
  if (!h.properties.set().empty()) info.provenance["set"] = h.properties.set();
  if (!h.properties.refused().empty()) info.provenance["not_set"] = h.properties.refused();
  return info;
}

void KmsDisplay::check() {
  const Hardware& h = *hardware_;
  const DrmConnector connector(drmModeGetConnectorCurrent(h.chosen.card->fd(), h.chosen.head.connector));
  if (!connector || connector->connection == DRM_MODE_DISCONNECTED)
    throw DeviceFault(DeviceFault::Kind::gone, fmt::format("{}: the display was unplugged", h.where));
}

Shown KmsDisplay::show(const Pattern&, const ImageF& levels) {
  Hardware& h = *hardware_;
  check();
  h.buffers[1 - h.front]->write(quantise_levels(levels, 8));
  return h.flip();
}

const PageFlips& KmsDisplay::flips() const { return hardware_->flips; }

}  // namespace fringetwin::capture
