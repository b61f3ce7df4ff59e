// SPDX-License-Identifier: Apache-2.0
#include "capture/display/kms_properties.hpp"

#include <algorithm>
#include <optional>

namespace fringetwin::capture {
namespace {

using DrmProperty = std::unique_ptr<drmModePropertyRes, FreedBy<drmModeFreeProperty>>;
using DrmProperties = std::unique_ptr<drmModeObjectProperties, FreedBy<drmModeFreeObjectProperties>>;
using DrmBlob = std::unique_ptr<drmModePropertyBlobRes, FreedBy<drmModeFreePropertyBlob>>;

struct Property {
  DrmProperty facts;
  std::uint64_t value = 0;
};

std::optional<Property> find_property(int fd, std::uint32_t object, std::uint32_t type,
                                      const std::string& name) {
  const DrmProperties all(drmModeObjectGetProperties(fd, object, type));
  for (std::uint32_t i = 0; all && i < all->count_props; ++i) {
    DrmProperty property(drmModeGetProperty(fd, all->props[i]));
    if (property && name == property->name) return Property{std::move(property), all->prop_values[i]};
  }
  return std::nullopt;
}

std::optional<std::uint64_t> enum_value(const drmModePropertyRes& property, const std::string& name) {
  for (int i = 0; i < property.count_enums; ++i)
    if (name == property.enums[i].name) return property.enums[i].value;
  return std::nullopt;
}

}  // namespace

KmsProperties::KmsProperties(std::shared_ptr<KmsCard> card, std::uint32_t crtc, std::uint32_t connector)
    : card_(std::move(card)) {
  // As the kernel's table of properties names them; each driver has a few.
  set_choice(connector, DRM_MODE_OBJECT_CONNECTOR, "scaling mode", {"None", "Center"});
  set_choice(connector, DRM_MODE_OBJECT_CONNECTOR, "underscan", {"off"});
  set_choice(connector, DRM_MODE_OBJECT_CONNECTOR, "Broadcast RGB", {"Full"});
  set_choice(connector, DRM_MODE_OBJECT_CONNECTOR, "dithering mode", {"off"});
  set_choice(connector, DRM_MODE_OBJECT_CONNECTOR, "dither", {"off"});
  for (const char* name : {"DEGAMMA_LUT", "CTM"}) clear_blob(crtc, name);
  if (!clear_blob(crtc, "GAMMA_LUT")) make_gamma_linear(crtc);
}

KmsProperties::~KmsProperties() {
  for (auto undo = restore_.rbegin(); undo != restore_.rend(); ++undo) (*undo)();
}

void KmsProperties::note(bool done, const std::string& what) {
  std::string& list = done ? set_ : refused_;
  list += (list.empty() ? "" : ", ") + what;
}

void KmsProperties::set_choice(std::uint32_t object, std::uint32_t type, const char* name,
                               const std::vector<std::string>& choices) {
  const int fd = card_->fd();
  const auto property = find_property(fd, object, type, name);
  if (!property) return;
  const std::uint32_t id = property->facts->prop_id;
  for (const std::string& choice : choices) {
    const auto value = enum_value(*property->facts, choice);
    if (!value || (*value != property->value && drmModeObjectSetProperty(fd, object, type, id, *value) != 0))
      continue;
    if (*value != property->value)
      restore_.push_back([fd, object, type, id, old = property->value] {
        drmModeObjectSetProperty(fd, object, type, id, old);
      });
    note(true, std::string(name) + " = " + choice);
    return;
  }
  note(false, name);
}

// The kernel takes no blob for pass-through. Its contents are kept: the blob itself goes with its last user.
bool KmsProperties::clear_blob(std::uint32_t crtc, const char* name) {
  const int fd = card_->fd();
  const auto property = find_property(fd, crtc, DRM_MODE_OBJECT_CRTC, name);
  if (!property) return false;
  const std::uint32_t id = property->facts->prop_id;
  if (property->value != 0) {
    const DrmBlob blob(drmModeGetPropertyBlob(fd, static_cast<std::uint32_t>(property->value)));
    if (!blob || drmModeObjectSetProperty(fd, crtc, DRM_MODE_OBJECT_CRTC, id, 0) != 0) {
      note(false, name);
      return false;
    }
    const auto* bytes = static_cast<const std::uint8_t*>(blob->data);
    restore_.push_back([fd, crtc, id, old = std::vector<std::uint8_t>(bytes, bytes + blob->length)] {
      std::uint32_t copy = 0;
      if (drmModeCreatePropertyBlob(fd, old.data(), old.size(), &copy) != 0) return;
      drmModeObjectSetProperty(fd, crtc, DRM_MODE_OBJECT_CRTC, id, copy);
      drmModeDestroyPropertyBlob(fd, copy);
    });
  }
  note(true, std::string(name) + " off");
  return true;
}

// For drivers from before the tables were properties.
void KmsProperties::make_gamma_linear(std::uint32_t crtc) {
  const int fd = card_->fd();
  const DrmCrtc facts(drmModeGetCrtc(fd, crtc));
  if (!facts || facts->gamma_size < 2) return;
  const auto size = static_cast<std::uint32_t>(facts->gamma_size);
  std::vector<std::uint16_t> red(size), green(size), blue(size), linear(size);
  const bool known = drmModeCrtcGetGamma(fd, crtc, size, red.data(), green.data(), blue.data()) == 0;
  for (std::uint32_t i = 0; i < size; ++i)
    linear[i] = static_cast<std::uint16_t>((i * 0xffffU + (size - 1) / 2) / (size - 1));
  const bool done =
      known && drmModeCrtcSetGamma(fd, crtc, size, linear.data(), linear.data(), linear.data()) == 0;
  if (done)
    restore_.push_back(
        [=]() mutable { drmModeCrtcSetGamma(fd, crtc, size, red.data(), green.data(), blue.data()); });
  note(done, "linear gamma table");
}

}  // namespace fringetwin::capture
