// SPDX-License-Identifier: Apache-2.0
#include "tests/support/capture/fake_gige.hpp"

#include <arpa/inet.h>
#include <arv.h>
#include <ifaddrs.h>
#include <net/if.h>

#include <array>
#include <atomic>
#include <mutex>
#include <random>
#include <thread>

#include "capture/device/pfnc_format.hpp"
#include "tests/support/twin/child_process.hpp"

namespace fringetwin::testing {
namespace {

using namespace fringetwin::capture;

/// Trigger sources in its description.
constexpr std::uint32_t kLine0 = 0, kSoftware = 1;

ImageU16 noise(const GigeFrame& frame) {
  std::mt19937 random(static_cast<unsigned>(frame.block_id));
  ImageU16 dn(frame.width, frame.height);
  for (std::uint16_t& value : dn.data)
    value = static_cast<std::uint16_t>(random() & ((1u << frame.bit_depth) - 1u));
  return dn;
}

/// Aravis' description of its camera with all formats that we know, and features that it lacks.
std::string description() {
  ArvFakeCamera* plain = arv_fake_camera_new("plain");
  std::size_t size = 0;
  const char* text = arv_fake_camera_get_genicam_xml(plain, &size);
  std::string xml(text, size);
  g_object_unref(plain);
  std::string entries;
  for (const PfncFormat& format : pfnc_formats())
    if (xml.find("\"" + std::string(format.name) + "\"") == std::string::npos)
      entries += "<EnumEntry Name=\"" + std::string(format.name) + "\" NameSpace=\"Standard\"><Value>" +
                 std::to_string(format.code) + "</Value></EnumEntry>\n";
  const auto formats = xml.find("<Enumeration Name=\"PixelFormat\"");
  xml.insert(xml.find("<pValue>", formats), entries);
  return xml;
}

}  // namespace

struct FakeGige::World {
  std::string serial, host;
  ScratchFolder folder;
  std::filesystem::path xml;
  ArvGvFakeCamera* camera = nullptr;
  double lost_share = 0.0;
  unsigned period_us = 2000;

  mutable std::mutex mutex;
  Picture picture = noise;
  std::map<std::uint64_t, ImageU16> sent;
  TimeNs stamp_ns = 0;  ///< of the next frame; 0: the time of day
  std::atomic<unsigned> n_made = 0;

  ArvFakeCamera* inner() const { return arv_gv_fake_camera_get_fake_camera(camera); }
  std::uint32_t read(std::uint32_t address) const {
    guint32 value = 0;
    arv_fake_camera_read_register(inner(), address, &value);
    return value;
  }
  static void fill(ArvBuffer* buffer, void* data, guint32, guint32, ArvPixelFormat pixel_format) {
    static_cast<World*>(data)->fill_buffer(buffer, pixel_format);
  }
  void fill_buffer(ArvBuffer* buffer, std::uint32_t code) {
    std::size_t received = 0;  // nothing yet: it is about to be sent
    const void* bytes = arv_buffer_get_data(buffer, &received);
    const std::size_t size = arv_fake_camera_get_payload(inner());
    const PfncFormat* format = pfnc_format_of_code(code);
    const std::lock_guard lock(mutex);
    if (format == nullptr) return;
    const GigeFrame frame{arv_buffer_get_frame_id(buffer),
                          static_cast<int>(read(ARV_FAKE_CAMERA_REGISTER_WIDTH)),
                          static_cast<int>(read(ARV_FAKE_CAMERA_REGISTER_HEIGHT)), format->bit_depth};
    const PfncLayout layout{.format = format, .width = frame.width, .height = frame.height};
    if (size < layout.used_bytes()) return;
    ImageU16 dn = picture(frame);
    pack_pfnc(dn, layout, {static_cast<std::byte*>(const_cast<void*>(bytes)), size});
    sent[frame.block_id] = std::move(dn);
    if (stamp_ns != 0) arv_buffer_set_timestamp(buffer, static_cast<guint64>(stamp_ns));
    ++n_made;
  }
  void start() {
    camera = arv_gv_fake_camera_new_full(host.c_str(), serial.c_str(), xml.c_str());
    arv_fake_camera_set_fill_pattern(inner(), fill, this);
    g_object_set(camera, "gvsp-lost-ratio", lost_share, nullptr);
    set_period();
  }
  void set_period() {
    arv_fake_camera_write_register(inner(), ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, period_us);
    arv_fake_camera_set_trigger_frequency(inner(), 1e6 / period_us);  // it looks for triggers that often
  }
  void end() {
    if (camera != nullptr) g_object_unref(camera);
    camera = nullptr;
  }
};

std::string other_interface_address() {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return "";
  std::string found;
  for (const ifaddrs* one = all; one != nullptr && found.empty(); one = one->ifa_next) {
    const bool is_up = (one->ifa_flags & IFF_UP) != 0 && (one->ifa_flags & IFF_LOOPBACK) == 0;
    if (!is_up || one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size()) != nullptr) found = text.data();
  }
  ::freeifaddrs(all);
  return found;
}

FakeGige::FakeGige(std::string serial, std::string address) : world_(std::make_unique<World>()) {
  world_->serial = std::move(serial);
  world_->host = std::move(address);
  world_->xml = world_->folder.write("camera.xml", description());
  world_->start();
}
FakeGige::~FakeGige() { world_->end(); }

bool FakeGige::running() const {
  return world_->camera != nullptr && arv_gv_fake_camera_is_running(world_->camera) != 0;
}
void FakeGige::lose(double share) {
  world_->lost_share = share;
  g_object_set(world_->camera, "gvsp-lost-ratio", share, nullptr);
}
void FakeGige::show(Picture picture) {
  const std::lock_guard lock(world_->mutex);
  world_->picture = std::move(picture);
}
void FakeGige::set_period_us(unsigned period_us) {
  world_->period_us = period_us;
  world_->set_period();
}
bool FakeGige::awaits_pulse() const {
  return world_->read(ARV_FAKE_CAMERA_REGISTER_ACQUISITION) != 0 &&
         world_->read(ARV_FAKE_CAMERA_REGISTER_TRIGGER_MODE) == 1 &&
         world_->read(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE) == kLine0;
}
// Aravis' camera knows no pulses but those of its software trigger: it has that source for as long as one
// frame takes.
bool FakeGige::pulse(TimeNs camera_ns) {
  if (!awaits_pulse()) return false;
  {
    const std::lock_guard lock(world_->mutex);
    world_->stamp_ns = camera_ns;
  }
  const unsigned before = world_->n_made;
  const auto write = [this](std::uint32_t address, std::uint32_t value) {
    arv_fake_camera_write_register(world_->inner(), address, value);
  };
  write(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, kSoftware);
  write(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOFTWARE, 1);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  while (world_->n_made == before && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  write(ARV_FAKE_CAMERA_REGISTER_TRIGGER_SOURCE, kLine0);
  return world_->n_made != before;
}
void FakeGige::kill() { world_->end(); }
void FakeGige::revive() { world_->start(); }

ImageU16 FakeGige::sent(std::uint64_t block_id) const {
  const std::lock_guard lock(world_->mutex);
  const auto found = world_->sent.find(block_id);
  return found == world_->sent.end() ? ImageU16() : found->second;
}
std::size_t FakeGige::n_sent() const {
  const std::lock_guard lock(world_->mutex);
  return world_->sent.size();
}

}  // namespace fringetwin::testing
