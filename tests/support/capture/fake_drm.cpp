// SPDX-License-Identifier: Apache-2.0
// Objects that libdrm would allocate are static here: one test, one card, one thread.
#include "tests/support/capture/fake_drm.hpp"

#include <xf86drm.h>
#include <xf86drmMode.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>

#include "tests/support/twin/child_process.hpp"

namespace {

using fringetwin::testing::FakeDrm;

FakeDrm fake;
std::optional<std::uint64_t> pending_sequence;
void* pending_data = nullptr;
std::uint32_t connector_ids[] = {31}, crtc_ids[] = {41}, encoder_ids[] = {51};
drmModeModeInfo modes[2];
drmModeRes resources;
drmModeConnector connector;
drmModeEncoder encoder;
std::vector<std::uint32_t> ids;
std::vector<std::uint64_t> values;
drmModeObjectProperties object_properties;
drmModePropertyRes property;
drm_mode_property_enum choices[3];
drmModePropertyBlobRes blob;

drmModeModeInfo mode(std::uint16_t width, std::uint16_t height, std::uint32_t clock, std::uint16_t htotal,
                     std::uint16_t vtotal) {
  drmModeModeInfo info{};
  info.hdisplay = width;
  info.vdisplay = height;
  info.clock = clock;
  info.htotal = htotal;
  info.vtotal = vtotal;
  return info;
}

int failed(int error) {
  errno = error;
  return error ? -1 : 0;
}

std::int64_t stamp_ns(std::uint64_t sequence) {
  return static_cast<std::int64_t>(sequence - 0xffff'0000) * FakeDrm::period_ns;
}

bool of_crtc(std::uint32_t id) { return id == FakeDrm::gamma || id == FakeDrm::ctm; }

void add_choice(std::uint64_t value, const char* name) {
  drm_mode_property_enum& choice = choices[property.count_enums++];
  choice.value = value;
  std::strcpy(choice.name, name);
}

drmModeConnector* describe_connector() {
  connector = {};
  connector.connector_id = connector_ids[0];
  connector.connector_type = DRM_MODE_CONNECTOR_HDMIA;
  connector.connector_type_id = 1;
  connector.connection = fake.connected ? DRM_MODE_CONNECTED : DRM_MODE_DISCONNECTED;
  modes[0] = mode(1920, 1080, 148500, 2200, 1125);
  modes[0].type = DRM_MODE_TYPE_PREFERRED;
  modes[1] = mode(1280, 720, 74250, 1650, 750);
  connector.modes = modes;
  connector.count_modes = 2;
  connector.encoders = encoder_ids;
  connector.count_encoders = 1;
  connector.encoder_id = encoder_ids[0];
  static std::uint32_t props[] = {FakeDrm::dpms};
  static std::uint64_t prop_values[1];
  prop_values[0] = fake.properties.at(FakeDrm::dpms);
  connector.props = props;
  connector.prop_values = prop_values;
  connector.count_props = 1;
  return &connector;
}

int set_property(std::uint32_t id, std::uint64_t value) {
  if (static_cast<int>(id) == fake.refuse_property) return failed(EINVAL);
  fake.properties.at(id) = value;
  return 0;
}

}  // namespace

namespace fringetwin::testing {

FakeDrm& new_fake_drm(std::string* path) {
  static const ScratchFolder folder;
  fake = {};
  pending_sequence.reset();
  *path = folder.write("card0", std::string(4 << 20, '\0')).string();  // memory to map
  return fake;
}

}  // namespace fringetwin::testing

extern "C" {

int drmGetCap(int, uint64_t, uint64_t* value) {
  *value = 1;
  return 0;
}
drmVersionPtr drmGetVersion(int) { return nullptr; }
int drmIsMaster(int) { return !fake.other_master; }
int drmSetMaster(int) { return failed(fake.other_master ? EBUSY : 0); }
drmModeResPtr drmModeGetResources(int) {
  resources = {};
  resources.connectors = connector_ids;
  resources.count_connectors = 1;
  resources.crtcs = crtc_ids;
  resources.count_crtcs = 1;
  return &resources;
}
void drmModeFreeResources(drmModeResPtr) {}
drmModeConnectorPtr drmModeGetConnector(int, uint32_t) { return describe_connector(); }
drmModeConnectorPtr drmModeGetConnectorCurrent(int, uint32_t) { return describe_connector(); }
void drmModeFreeConnector(drmModeConnectorPtr) {}
drmModeEncoderPtr drmModeGetEncoder(int, uint32_t) {
  encoder = {};
  encoder.encoder_id = encoder_ids[0];
  encoder.crtc_id = crtc_ids[0];
  encoder.possible_crtcs = 1;
  return &encoder;
}
void drmModeFreeEncoder(drmModeEncoderPtr) {}
drmModeCrtcPtr drmModeGetCrtc(int, uint32_t) {
  auto* copy = new drmModeCrtc{};  // kept by who saves it
  copy->crtc_id = crtc_ids[0];
  copy->buffer_id = fake.buffer;
  copy->mode_valid = 1;
  copy->mode = mode(static_cast<std::uint16_t>(fake.width), static_cast<std::uint16_t>(fake.height), 0, 0, 0);
  copy->gamma_size = 4;
  return copy;
}
void drmModeFreeCrtc(drmModeCrtcPtr pointer) { delete pointer; }
int drmModeSetCrtc(int, uint32_t, uint32_t buffer, uint32_t, uint32_t, uint32_t*, int, drmModeModeInfoPtr m) {
  if (fake.mode_error && buffer != FakeDrm::console) return failed(fake.mode_error);
  fake.buffer = buffer;
  fake.width = m ? m->hdisplay : 0;
  fake.height = m ? m->vdisplay : 0;
  return 0;
}
int drmModeSetCursor(int, uint32_t, uint32_t, uint32_t, uint32_t) { return failed(ENXIO); }

int drmCrtcGetSequence(int, uint32_t, uint64_t* sequence, uint64_t* ns) {
  if (!fake.counts_refreshes) return failed(EOPNOTSUPP);
  *sequence = fake.sequence;
  *ns = static_cast<std::uint64_t>(stamp_ns(fake.sequence));
  return 0;
}
int drmModePageFlip(int, uint32_t, uint32_t buffer, uint32_t, void* data) {
  if (fake.flip_error) return failed(fake.flip_error);
  fake.buffer = buffer;
  fake.sequence += 1 + fake.late;
  pending_sequence = fake.sequence;
  pending_data = data;
  return 0;
}
int drmHandleEvent(int fd, drmEventContextPtr context) {
  if (!fake.answers || !pending_sequence) return 0;
  const auto us = static_cast<std::uint64_t>(stamp_ns(*pending_sequence) / 1000);
  const auto sequence = static_cast<unsigned>(fake.counts_refreshes ? *pending_sequence : 0);
  pending_sequence.reset();
  context->page_flip_handler2(fd, sequence, static_cast<unsigned>(us / 1'000'000),
                              static_cast<unsigned>(us % 1'000'000), crtc_ids[0], pending_data);
  return 0;
}

int drmIoctl(int, unsigned long request, void* argument) {
  if (request == DRM_IOCTL_MODE_CREATE_DUMB) {
    auto* dumb = static_cast<drm_mode_create_dumb*>(argument);
    dumb->handle = static_cast<std::uint32_t>(100 + ++fake.dumb_buffers);
    dumb->pitch = 4 * dumb->width;
    dumb->size = std::uint64_t{dumb->pitch} * dumb->height;
  }
  return 0;  // mapped at offset 0
}
int drmModeDestroyDumbBuffer(int, uint32_t) {
  --fake.dumb_buffers;
  return 0;
}
int drmModeAddFB(int, uint32_t, uint32_t, uint8_t, uint8_t, uint32_t, uint32_t handle, uint32_t* id) {
  *id = handle + 100;
  fake.buffers[*id];
  return 0;
}
int drmModeRmFB(int, uint32_t id) {
  fake.buffers.erase(id);
  return 0;
}

drmModeObjectPropertiesPtr drmModeObjectGetProperties(int, uint32_t, uint32_t type) {
  ids.clear();
  values.clear();
  for (const auto& [id, value] : fake.properties) {
    if (of_crtc(id) != (type == DRM_MODE_OBJECT_CRTC) || (id == FakeDrm::gamma && !fake.has_gamma_blob))
      continue;
    ids.push_back(id);
    values.push_back(value);
  }
  object_properties = {static_cast<std::uint32_t>(ids.size()), ids.data(), values.data()};
  return &object_properties;
}
void drmModeFreeObjectProperties(drmModeObjectPropertiesPtr) {}
drmModePropertyPtr drmModeGetProperty(int, uint32_t id) {
  property = {};
  property.prop_id = id;
  property.enums = choices;
  const std::map<std::uint32_t, const char*> names{{FakeDrm::broadcast, "Broadcast RGB"},
                                                   {FakeDrm::dpms, "DPMS"},
                                                   {FakeDrm::scaling, "scaling mode"},
                                                   {FakeDrm::gamma, "GAMMA_LUT"},
                                                   {FakeDrm::ctm, "CTM"}};
  std::strcpy(property.name, names.at(id));
  if (id == FakeDrm::broadcast)
    add_choice(0, "Automatic"), add_choice(1, "Full"), add_choice(2, "Limited 16:235");
  if (id == FakeDrm::scaling) add_choice(1, "Full"), add_choice(2, "Center"), add_choice(3, "Full aspect");
  return &property;
}
void drmModeFreeProperty(drmModePropertyPtr) {}
int drmModeObjectSetProperty(int, uint32_t, uint32_t, uint32_t id, uint64_t value) {
  return set_property(id, value);
}
int drmModeConnectorSetProperty(int, uint32_t, uint32_t id, uint64_t value) {
  return set_property(id, value);
}
drmModePropertyBlobPtr drmModeGetPropertyBlob(int, uint32_t id) {
  auto& bytes = fake.blobs.at(id);
  blob = {id, static_cast<std::uint32_t>(bytes.size()), bytes.data()};
  return &blob;
}
void drmModeFreePropertyBlob(drmModePropertyBlobPtr) {}
int drmModeCreatePropertyBlob(int, const void* data, size_t size, uint32_t* id) {
  *id = 78;
  const auto* bytes = static_cast<const std::uint8_t*>(data);
  fake.blobs[*id].assign(bytes, bytes + size);
  return 0;
}
int drmModeDestroyPropertyBlob(int, uint32_t) { return 0; }  // its user keeps it
int drmModeCrtcGetGamma(int, uint32_t, uint32_t size, uint16_t* red, uint16_t* green, uint16_t* blue) {
  for (auto* channel : {red, green, blue}) std::copy_n(fake.table.begin(), size, channel);
  return 0;
}
int drmModeCrtcSetGamma(int, uint32_t, uint32_t size, uint16_t* red, uint16_t*, uint16_t*) {
  fake.table.assign(red, red + size);
  return 0;
}
}  // extern "C"
