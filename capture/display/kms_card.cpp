// SPDX-License-Identifier: Apache-2.0
#include "capture/display/kms_card.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "twin/base/errors.hpp"

namespace fringetwin::capture {
namespace {

UserError cannot_open(const std::string& path, int error) {
  std::string cards;
  for (const std::string& card : kms_cards()) cards += " " + card;
  if (error == EACCES || error == EPERM)
    return {ExitCode::device, path, "you may not open this graphics card",
            "add your user to the group 'video' and log in again"};
  return {ExitCode::device, path, fmt::format("cannot be opened ({})", std::strerror(error)),
          cards.empty() ? "this machine has no graphics card: use the display 'window'"
                        : "the graphics cards:" + cards};
}

// Bits of the CRTCs that any encoder of the connector can take.
std::uint32_t possible_crtcs(int fd, const drmModeConnector& connector) {
  std::uint32_t bits = 0;
  for (int i = 0; i < connector.count_encoders; ++i)
    if (const DrmEncoder encoder{drmModeGetEncoder(fd, connector.encoders[i])})
      bits |= encoder->possible_crtcs;
  return bits;
}

std::uint32_t current_crtc(int fd, const drmModeConnector& connector) {
  const DrmEncoder encoder{drmModeGetEncoder(fd, connector.encoder_id)};
  return encoder ? encoder->crtc_id : 0;
}

}  // namespace

std::vector<std::string> kms_cards() {
  std::vector<std::string> cards;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/dri", none))
    if (entry.path().filename().string().starts_with("card")) cards.push_back(entry.path().string());
  std::ranges::sort(cards);
  return cards;
}

DeviceFault kms_fault(int error, const std::string& where, const std::string& doing) {
  const auto sentence = [&](const std::string& what) {
    return fmt::format("{}: {}: {}", where, doing, what);
  };
  switch (error) {
    case ENODEV:
    case ENXIO:
      return {DeviceFault::Kind::gone, sentence("the graphics card is gone")};
    case EACCES:
    case EPERM:
      return {DeviceFault::Kind::stream,
              sentence("another program has taken the display; switch back to this text console and resume")};
    case EBUSY:
      return {DeviceFault::Kind::stream, sentence("the display still waits for the pattern before")};
    case ETIMEDOUT:
      return {DeviceFault::Kind::timeout, sentence("the display did not answer")};
    default:
      return {DeviceFault::Kind::stream, sentence(std::strerror(error))};
  }
}

double mode_period_ns(const drmModeModeInfo& mode) {
  if (mode.clock == 0) return mode.vrefresh ? 1e9 / mode.vrefresh : 0.0;  // a virtual display's
  return 1e6 * mode.htotal * mode.vtotal / mode.clock;
}

std::shared_ptr<KmsCard> KmsCard::open(const std::string& path) {
  static std::map<std::string, std::weak_ptr<KmsCard>> cards;
  std::weak_ptr<KmsCard>& known = cards[path];
  if (auto card = known.lock()) return card;
  std::shared_ptr<KmsCard> card(new KmsCard(path));
  known = card;
  return card;
}

KmsCard::KmsCard(const std::string& path) : path_(path), fd_(::open(path.c_str(), O_RDWR | O_CLOEXEC)) {
  if (fd_ < 0) throw cannot_open(path, errno);
  std::uint64_t dumb = 0;
  const bool usable = drmGetCap(fd_, DRM_CAP_DUMB_BUFFER, &dumb) == 0 && dumb != 0 &&
                      DrmResources(drmModeGetResources(fd_)) != nullptr;
  if (usable) return;
  ::close(fd_);
  throw UserError(ExitCode::device, path, "is no graphics card with displays that a program can set",
                  "use another card or the display 'window'");
}

KmsCard::~KmsCard() { ::close(fd_); }

std::string KmsCard::driver() const {
  const std::unique_ptr<drmVersion, FreedBy<drmFreeVersion>> version(drmGetVersion(fd_));
  if (!version) return "unknown";
  return fmt::format("{} {}.{}.{} {}", version->name, version->version_major, version->version_minor,
                     version->version_patchlevel, version->date);
}

bool KmsCard::monotonic() const {
  std::uint64_t monotonic = 0;
  return drmGetCap(fd_, DRM_CAP_TIMESTAMP_MONOTONIC, &monotonic) == 0 && monotonic != 0;
}

std::vector<KmsHead> KmsCard::heads() const {
  std::vector<KmsHead> heads;
  const DrmResources resources(drmModeGetResources(fd_));
  for (int i = 0; resources && i < resources->count_connectors; ++i) {
    const DrmConnector connector(drmModeGetConnector(fd_, resources->connectors[i]));
    if (!connector) continue;
    KmsHead head;
    head.connector = connector->connector_id;
    const char* type = drmModeGetConnectorTypeName(connector->connector_type);
    head.facts.name = fmt::format("{}-{}", type ? type : "Unknown", connector->connector_type_id);
    head.facts.connected = connector->connection == DRM_MODE_CONNECTED;
    for (int k = 0; k < connector->count_modes; ++k) {
      const drmModeModeInfo& mode = connector->modes[k];
      const double period_ns = mode_period_ns(mode);
      constexpr std::uint32_t kOdd = DRM_MODE_FLAG_INTERLACE | DRM_MODE_FLAG_DBLSCAN;
      head.modes.push_back(mode);
      head.facts.modes.push_back({mode.hdisplay, mode.vdisplay, period_ns > 0.0 ? 1e9 / period_ns : 0.0,
                                  (mode.type & DRM_MODE_TYPE_PREFERRED) != 0, (mode.flags & kOdd) == 0});
    }
    heads.push_back(std::move(head));
  }
  return heads;
}

// Who opens a card first has the right without asking.
void KmsCard::become_master() {
  if (drmIsMaster(fd_) || drmSetMaster(fd_) == 0) return;
  throw UserError(ExitCode::device, path_, "another program holds this card (a desktop session, most likely)",
                  "switch to a text console (Ctrl+Alt+F3) and run there, or use the display 'window'");
}

std::uint32_t KmsCard::take_crtc(std::uint32_t connector_id) {
  const DrmResources resources(drmModeGetResources(fd_));
  const DrmConnector connector(drmModeGetConnectorCurrent(fd_, connector_id));
  if (!resources || !connector)
    throw UserError(ExitCode::device, path_, "the connector vanished", "plug the projector in and try again");
  std::set<std::uint32_t> used;
  for (int i = 0; i < resources->count_connectors; ++i) {
    const DrmConnector other(drmModeGetConnectorCurrent(fd_, resources->connectors[i]));
    if (other && other->connector_id != connector_id) used.insert(current_crtc(fd_, *other));
  }
  const std::uint32_t bits = possible_crtcs(fd_, *connector), current = current_crtc(fd_, *connector);
  std::uint32_t best = 0;
  int best_rank = -1;
  for (int i = 0; i < std::min(resources->count_crtcs, 32); ++i) {
    const std::uint32_t crtc = resources->crtcs[i];
    if (!(bits >> i & 1U) || taken_crtcs_.count(crtc)) continue;
    const int rank = crtc == current ? 2 : used.count(crtc) ? 0 : 1;
    if (rank > best_rank) best = crtc, best_rank = rank;
  }
  if (!best)
    throw UserError(ExitCode::device, path_, "the card cannot drive one more display",
                    "use a connector of another card");
  taken_crtcs_.insert(best);
  return best;
}

std::uint64_t KmsCard::flip(std::uint32_t crtc, std::uint32_t buffer) {
  const std::uint64_t flip = ++last_flip_;
  if (drmModePageFlip(fd_, crtc, buffer, DRM_MODE_PAGE_FLIP_EVENT, &flips_[flip]) == 0) return flip;
  const int error = errno;
  flips_.erase(flip);
  throw kms_fault(error, path_, "page flip");
}

void KmsCard::on_flip(int, unsigned sequence, unsigned s, unsigned us, unsigned, void* done) {
  *static_cast<std::optional<FlipDone>*>(done) = {
      sequence, static_cast<TimeNs>(s) * 1'000'000'000 + static_cast<TimeNs>(us) * 1'000, steady_now_ns()};
}

void KmsCard::read_events(std::chrono::milliseconds timeout) {
  pollfd waiting{fd_, POLLIN, 0};
  const int ready = ::poll(&waiting, 1, static_cast<int>(std::max<long>(timeout.count(), 0)));
  if (ready < 0 && errno != EINTR) throw kms_fault(errno, path_, "waiting for a page flip");
  if (ready <= 0) return;
  if (!(waiting.revents & POLLIN)) throw kms_fault(ENODEV, path_, "waiting for a page flip");
  drmEventContext context{};
  context.version = 3;  // the first with page_flip_handler2
  context.page_flip_handler2 = on_flip;
  if (drmHandleEvent(fd_, &context) != 0) throw kms_fault(errno, path_, "reading a page flip's event");
}

FlipDone KmsCard::wait(std::uint64_t flip, std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (!flips_.at(flip)) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0)  // its place stays: the event may still come
      throw kms_fault(ETIMEDOUT, path_, fmt::format("no page flip within {} ms", timeout.count()));
    read_events(left);
  }
  const FlipDone done = *flips_.at(flip);
  flips_.erase(flip);
  return done;
}

KmsBuffer::KmsBuffer(std::shared_ptr<KmsCard> card, int width, int height) : card_(std::move(card)) {
  const int fd = card_->fd();
  dumb_.width = static_cast<std::uint32_t>(width);
  dumb_.height = static_cast<std::uint32_t>(height);
  dumb_.bpp = 32;
  const auto fail = [&](const std::string& what) {
    const std::string why = std::strerror(errno);
    if (dumb_.handle) drmModeDestroyDumbBuffer(fd, dumb_.handle);
    throw UserError(ExitCode::device, card_->path(), fmt::format("{} ({})", what, why),
                    "use another card or the display 'window'");
  };
  if (drmIoctl(fd, DRM_IOCTL_MODE_CREATE_DUMB, &dumb_) != 0) fail("no memory for a frame buffer");
  drm_mode_map_dumb map{};
  map.handle = dumb_.handle;
  if (drmIoctl(fd, DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) fail("a frame buffer cannot be mapped");
  memory_ =
      ::mmap(nullptr, dumb_.size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(map.offset));
  if (memory_ == MAP_FAILED) fail("a frame buffer cannot be mapped");
  std::memset(memory_, 0, dumb_.size);
  if (drmModeAddFB(fd, dumb_.width, dumb_.height, 24, 32, dumb_.pitch, dumb_.handle, &id_) != 0) {
    ::munmap(memory_, dumb_.size);
    fail("the card takes no frame buffer of 32 bits per pixel");
  }
}

KmsBuffer::~KmsBuffer() {
  drmModeRmFB(card_->fd(), id_);
  ::munmap(memory_, dumb_.size);
  drmModeDestroyDumbBuffer(card_->fd(), dumb_.handle);
}

void KmsBuffer::write(const ImageU16& gray) {
  FT_CHECK(gray.width == static_cast<int>(dumb_.width) && gray.height == static_cast<int>(dumb_.height),
           "a pattern has the display's size");
  for (int y = 0; y < gray.height; ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(static_cast<std::uint8_t*>(memory_) +
                                                 static_cast<std::size_t>(y) * dumb_.pitch);
    for (int x = 0; x < gray.width; ++x) row[x] = gray(x, y) * 0x010101U;
  }
}

}  // namespace fringetwin::capture
