// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_controls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "twin/base/paths.hpp"
#include "twin/number/parse_number.hpp"

#ifndef V4L2_CID_HDR_SENSOR_MODE  // since Linux 6.6
#define V4L2_CID_HDR_SENSOR_MODE (V4L2_CID_CAMERA_CLASS_BASE + 36)
#endif

namespace fringetwin::capture {
namespace {

/// Returns a control's name as v4l2-ctl writes it: lower-case letters and digits, with one underscore for
/// every run of other characters.
std::string key_of(const std::string& name) {
  std::string key;
  for (const char c : lower_case(name))
    if (std::isalnum(static_cast<unsigned char>(c)) != 0)
      key += c;
    else if (!key.empty() && key.back() != '_')
      key += '_';
  if (!key.empty() && key.back() == '_') key.pop_back();
  return key;
}

/// Returns whether a control's value is one integer, not a string or a compound type.
bool is_number(std::uint32_t type) {
  return type == V4L2_CTRL_TYPE_INTEGER || type == V4L2_CTRL_TYPE_INTEGER64 ||
         type == V4L2_CTRL_TYPE_BITMASK || type == V4L2_CTRL_TYPE_BOOLEAN || type == V4L2_CTRL_TYPE_MENU ||
         type == V4L2_CTRL_TYPE_INTEGER_MENU || type == V4L2_CTRL_TYPE_BUTTON;
}

bool is_menu(std::uint32_t type) {
  return type == V4L2_CTRL_TYPE_MENU || type == V4L2_CTRL_TYPE_INTEGER_MENU;
}

std::map<std::int64_t, std::string> menu_items(const V4l2Device& device, const V4l2Control& control) {
  std::map<std::int64_t, std::string> items;
  for (std::int64_t i = control.min; i <= control.max; ++i) {
    v4l2_querymenu item{};
    item.id = control.id;
    item.index = static_cast<std::uint32_t>(i);
    if (device.call(VIDIOC_QUERYMENU, item) != 0) continue;  // menus have holes
    items[i] = control.type == V4L2_CTRL_TYPE_MENU ? text_of(item.name)
                                                   : std::to_string(static_cast<long long>(item.value));
  }
  return items;
}

/// Names a function by which a camera changes its images on its own, and the values that turn it off: the
/// first one that the device offers is set.
struct Automatic {
  std::uint32_t id;
  std::array<std::int64_t, 2> off;
};
constexpr Automatic kAutomatics[] = {
    // manual, or at least a fixed exposure time
    {V4L2_CID_EXPOSURE_AUTO, {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY}},
    {V4L2_CID_EXPOSURE_AUTO_PRIORITY, {0, 0}},
    {V4L2_CID_AUTOGAIN, {0, 0}},
    {V4L2_CID_ISO_SENSITIVITY_AUTO, {V4L2_ISO_SENSITIVITY_MANUAL, 0}},
    {V4L2_CID_AUTO_WHITE_BALANCE, {0, 0}},
    {V4L2_CID_AUTO_N_PRESET_WHITE_BALANCE, {V4L2_WHITE_BALANCE_MANUAL, 0}},
    {V4L2_CID_AUTOBRIGHTNESS, {0, 0}},
    {V4L2_CID_HUE_AUTO, {0, 0}},
    {V4L2_CID_CHROMA_AGC, {0, 0}},
    {V4L2_CID_FOCUS_AUTO, {0, 0}},
    {V4L2_CID_BACKLIGHT_COMPENSATION, {0, 0}},
    {V4L2_CID_WIDE_DYNAMIC_RANGE, {0, 0}},
    {V4L2_CID_HDR_SENSOR_MODE, {0, 0}},
    {V4L2_CID_IMAGE_STABILIZATION, {0, 0}},
    {V4L2_CID_SCENE_MODE, {V4L2_SCENE_MODE_NONE, 0}},
};

bool has_value(const V4l2Control& control, std::int64_t value) {
  if (is_menu(control.type)) return control.items.contains(value);
  return value >= control.min && value <= control.max;
}

}  // namespace

std::string V4l2Control::range() const {
  if (!items.empty()) {
    std::string text;
    for (const auto& [value, item] : items)
      text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", value, item);
    return text;
  }
  if (type == V4L2_CTRL_TYPE_BOOLEAN) return "0 = off, 1 = on";
  return fmt::format("{}...{}", min, max) + (step > 1 ? fmt::format(" in steps of {}", step) : "");
}

std::string V4l2Control::value_text(std::int64_t value) const {
  const auto item = items.find(value);
  return item == items.end() ? std::to_string(value) : fmt::format("{} ({})", value, item->second);
}

V4l2Controls::V4l2Controls(const V4l2Device& device) : device_(device) {
  v4l2_query_ext_ctrl query{};
  for (query.id = V4L2_CTRL_FLAG_NEXT_CTRL; device.call(VIDIOC_QUERY_EXT_CTRL, query) == 0;
       query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
    if ((query.flags & V4L2_CTRL_FLAG_DISABLED) != 0 || query.nr_of_dims > 0 || !is_number(query.type))
      continue;
    V4l2Control control;
    control.id = query.id;
    control.name = std::string(query.name, strnlen(query.name, sizeof query.name));
    control.key = key_of(control.name);
    control.type = query.type;
    control.min = query.minimum;
    control.max = query.maximum;
    control.step = static_cast<std::int64_t>(query.step);
    control.flags = query.flags;
    if (is_menu(control.type)) control.items = menu_items(device, control);
    controls_.push_back(std::move(control));
  }
}

const V4l2Control* V4l2Controls::find(std::uint32_t id) const {
  const auto found = std::ranges::find(controls_, id, &V4l2Control::id);
  return found == controls_.end() ? nullptr : &*found;
}

const V4l2Control& V4l2Controls::named(const std::string& name) const {
  const std::string key = key_of(name);
  std::string keys;
  for (const V4l2Control& control : controls_) {
    if (control.key == key) return control;
    if (control.writable()) keys += (keys.empty() ? "" : ", ") + control.key;
  }
  throw device_.refusal("has no control '" + name + "'",
                        keys.empty() ? "it has none at all" : "it has " + keys);
}

int V4l2Controls::read(const V4l2Control& control, std::int64_t& value) const {
  v4l2_ext_control one{};
  one.id = control.id;
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &one;
  const int result = device_.call(VIDIOC_G_EXT_CTRLS, list);
  value = control.type == V4L2_CTRL_TYPE_INTEGER64 ? one.value64 : one.value;
  return result;
}

int V4l2Controls::write(const V4l2Control& control, std::int64_t value) const {
  v4l2_ext_control one{};
  one.id = control.id;
  if (control.type == V4L2_CTRL_TYPE_INTEGER64)
    one.value64 = value;
  else
    one.value = static_cast<std::int32_t>(value);
  v4l2_ext_controls list{};
  list.which = V4L2_CTRL_WHICH_CUR_VAL;
  list.count = 1;
  list.controls = &one;
  return device_.call(VIDIOC_S_EXT_CTRLS, list);
}

std::int64_t V4l2Controls::get(const V4l2Control& control) const {
  std::int64_t value = 0;
  if (const int result = read(control, value); result != 0)
    throw device_.refusal(fmt::format("control '{}' cannot be read: {}", control.key, error_text(result)));
  return value;
}

UserError V4l2Controls::refusal(const V4l2Control& control, std::int64_t value,
                                const std::string& why) const {
  return device_.refusal(
      fmt::format("control '{}' was asked for {} {}", control.key, control.value_text(value), why),
      "it takes " + control.range());
}

void V4l2Controls::set(const V4l2Control& control, std::int64_t value) const {
  if (!control.writable()) throw refusal(control, value, "but can only be read");
  if (!has_value(control, value)) throw refusal(control, value, "which is out of range");
  if (const int result = write(control, value); result != 0)
    throw refusal(control, value, "and refused it: " + error_text(result));
  if (!control.readable()) return;
  if (const std::int64_t got = get(control); got != value)
    throw refusal(control, value, "but has " + control.value_text(got));
}

void V4l2Controls::verify(const V4l2Control& control, const std::string& value) const {
  if (!control.readable()) return;
  if (const std::int64_t asked = parse(control, value), got = get(control); got != asked)
    throw refusal(control, asked, "but has " + control.value_text(got) + " once all were set");
}

void V4l2Controls::set(const V4l2Control& control, const std::string& value) const {
  set(control, parse(control, value));
}

void V4l2Controls::push(const V4l2Control& button) const {
  if (const int result = write(button, 1); result != 0)
    throw device_.refusal(fmt::format("button '{}' failed: {}", button.key, error_text(result)));
}

std::int64_t V4l2Controls::parse(const V4l2Control& control, const std::string& text) const {
  if (const std::optional<std::int64_t> value = parse_number<std::int64_t>(text)) return *value;
  for (const auto& [item, name] : control.items)
    if (key_of(name) == key_of(text)) return item;
  const std::string word = lower_case(text);
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN && (word == "on" || word == "true")) return 1;
  if (control.type == V4L2_CTRL_TYPE_BOOLEAN && (word == "off" || word == "false")) return 0;
  throw device_.refusal(fmt::format("control '{}' cannot be '{}'", control.key, text),
                        "it takes " + control.range());
}

void V4l2Controls::turn_off_automatics(const std::set<std::uint32_t>& kept) const {
  for (const Automatic& automatic : kAutomatics) {
    const V4l2Control* control = find(automatic.id);
    if (control == nullptr || !control->writable() || kept.contains(automatic.id)) continue;
    const auto off =
        std::ranges::find_if(automatic.off, [&](std::int64_t value) { return has_value(*control, value); });
    if (off != automatic.off.end())
      set(*control, *off);
    else if (automatic.id == V4L2_CID_EXPOSURE_AUTO)  // its smallest value is fully automatic exposure
      throw device_.refusal(
          fmt::format("control '{}' cannot be turned off", control->key),
          fmt::format("it has {}; name it with --control to record all the same", control->range()));
    else  // the smallest value is the nearest to "off" that the device offers
      set(*control, control->min);
  }
}

std::map<std::string, std::string> V4l2Controls::provenance() const {
  std::map<std::string, std::string> values;
  for (const V4l2Control& control : controls_) {
    std::int64_t value = 0;
    if (control.readable() && read(control, value) == 0)
      values["control." + control.key] = control.value_text(value);
  }
  return values;
}

}  // namespace fringetwin::capture
