// SPDX-License-Identifier: Apache-2.0
// The module on Aravis.
#include "capture/genicam/genicam_module.hpp"

#include <arv.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "twin/base/not_copyable.hpp"

namespace fringetwin::capture {
namespace {

template <class T>
struct Unref {
  void operator()(T* object) const { g_object_unref(object); }
};
template <class T>
using Ref = std::unique_ptr<T, Unref<T>>;

/// The error that a call may leave behind.
class Error : NotCopyable {
 public:
  ~Error() { g_clear_error(&error_); }
  GError** out() { return &error_; }
  bool none() const { return error_ == nullptr; }
  std::string text() const { return error_ != nullptr ? error_->message : "no reason given"; }
  bool tell(std::string* fault) const {
    if (!none()) *fault = text();
    return none();
  }

 private:
  GError* error_ = nullptr;
};

std::string text_or_empty(const char* text) { return text != nullptr ? text : ""; }

void add_names(ArvGc* genicam, const char* name, std::vector<std::string>* names, int depth) {
  constexpr int kDeepest = 16;  // a description may contain itself
  ArvGcNode* node = arv_gc_get_node(genicam, name);
  if (node == nullptr || depth > kDeepest) return;
  if (!ARV_IS_GC_CATEGORY(node)) {
    if (std::ranges::find(*names, name) == names->end()) names->emplace_back(name);
    return;
  }
  for (const GSList* entry = arv_gc_category_get_features(ARV_GC_CATEGORY(node)); entry != nullptr;
       entry = entry->next)
    add_names(genicam, static_cast<const char*>(entry->data), names, depth + 1);
}

// A limit that the camera's description lacks, or that cannot be read, is as wide as its type.
template <class Value>
double limit(Value (*get)(ArvGcInteger*, GError**), ArvGcInteger* node) {
  Error error;
  const auto value = static_cast<double>(get(node, error.out()));
  return error.none() ? value : 0.0;
}
double limit(double (*get)(ArvGcFloat*, GError**), ArvGcFloat* node) {
  Error error;
  const double value = get(node, error.out());
  return error.none() ? value : 0.0;
}

void describe_choices(ArvGcEnumeration* node, GenicamFeature* feature) {
  Error error;
  guint n = 0;
  const char** names = arv_gc_enumeration_dup_available_string_values(node, &n, error.out());
  for (guint i = 0; names != nullptr && i < n; ++i) feature->choices.emplace_back(names[i]);
  g_free(names);
}

void describe_kind(ArvGcNode* node, GenicamFeature* feature) {
  using Kind = GenicamFeature::Kind;
  if (ARV_IS_GC_COMMAND(node)) {
    feature->kind = Kind::command;
  } else if (ARV_IS_GC_ENUMERATION(node)) {  // before integers: it is one, too
    feature->kind = Kind::choice;
    describe_choices(ARV_GC_ENUMERATION(node), feature);
  } else if (ARV_IS_GC_BOOLEAN(node)) {
    feature->kind = Kind::boolean;
  } else if (ARV_IS_GC_FLOAT(node)) {
    feature->kind = Kind::number;
    feature->min = limit(arv_gc_float_get_min, ARV_GC_FLOAT(node));
    feature->max = limit(arv_gc_float_get_max, ARV_GC_FLOAT(node));
    const double step = limit(arv_gc_float_get_inc, ARV_GC_FLOAT(node));
    feature->step = step > 1e-300 ? step : 0.0;  // none is told as the least number there is
    feature->unit = text_or_empty(arv_gc_float_get_unit(ARV_GC_FLOAT(node)));
  } else if (ARV_IS_GC_INTEGER(node)) {
    feature->kind = Kind::integer;
    feature->min = limit(arv_gc_integer_get_min, ARV_GC_INTEGER(node));
    feature->max = limit(arv_gc_integer_get_max, ARV_GC_INTEGER(node));
    feature->step = std::max(limit(arv_gc_integer_get_inc, ARV_GC_INTEGER(node)), 1.0);
    feature->unit = text_or_empty(arv_gc_integer_get_unit(ARV_GC_INTEGER(node)));
  } else if (ARV_IS_GC_STRING(node)) {
    feature->kind = Kind::text;
  }
}

/// A float's value with all of its digits; Aravis' own text has six.
std::string value_text(ArvGcFeatureNode* node, GError** error) {
  if (ARV_IS_GC_FLOAT(node)) return fmt::format("{}", arv_gc_float_get_value(ARV_GC_FLOAT(node), error));
  return text_or_empty(arv_gc_feature_node_get_value_as_string(node, error));
}

GenicamBuffer::State state_of(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return GenicamBuffer::State::whole;
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return GenicamBuffer::State::wrong_length;
    case ARV_BUFFER_STATUS_ABORTED:
      return GenicamBuffer::State::aborted;
    default:
      return GenicamBuffer::State::incomplete;
  }
}

bool is_image(ArvBuffer* buffer) {
  const ArvBufferPayloadType type = arv_buffer_get_payload_type(buffer);
  return type == ARV_BUFFER_PAYLOAD_TYPE_IMAGE || type == ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA;
}

GenicamBuffer to_buffer(ArvBuffer* from) {
  GenicamBuffer buffer;
  const ArvBufferStatus status = arv_buffer_get_status(from);
  buffer.state = state_of(status);
  buffer.status = static_cast<int>(status);
  buffer.block_id = arv_buffer_get_frame_id(from);
  buffer.camera_ns = static_cast<TimeNs>(arv_buffer_get_timestamp(from));
  // Aravis stamps with the time of day.
  const gint64 ago_us = g_get_real_time() - static_cast<gint64>(arv_buffer_get_system_timestamp(from) / 1000);
  buffer.came_ns = (g_get_monotonic_time() - std::max<gint64>(ago_us, 0)) * 1000;  // CLOCK_MONOTONIC
  if (buffer.state != GenicamBuffer::State::whole) return buffer;
  if (!is_image(from)) {
    buffer.state = GenicamBuffer::State::wrong_length;
    return buffer;
  }
  buffer.pixel_format = arv_buffer_get_image_pixel_format(from);
  buffer.width = arv_buffer_get_image_width(from);
  buffer.height = arv_buffer_get_image_height(from);
  int frame_padding = 0;
  arv_buffer_get_image_padding(from, &buffer.line_padding, &frame_padding);
  std::size_t size = 0;
  const void* data = arv_buffer_get_image_data(from, &size);
  buffer.bytes = {static_cast<const std::byte*>(data), data != nullptr ? size : 0};
  return buffer;
}

class AravisDevice final : public GenicamDevice, NotCopyable {
 public:
  explicit AravisDevice(ArvDevice* device) : device_(device) {
    g_signal_connect(device, "control-lost", G_CALLBACK(&AravisDevice::on_lost), &lost_);
  }
  ~AravisDevice() override {
    stream_off();
    g_signal_handlers_disconnect_by_data(device_.get(), &lost_);
  }

  bool controlled() const override {
    return !ARV_IS_GV_DEVICE(device_.get()) || arv_gv_device_is_controller(ARV_GV_DEVICE(device_.get()));
  }
  bool lost() const override { return lost_; }
  bool answers() override {
    Error error;
    arv_device_get_integer_feature_value(device_.get(), "Width", error.out());
    return error.none();
  }

  std::vector<std::string> feature_names() override {
    std::vector<std::string> names;
    add_names(arv_device_get_genicam(device_.get()), "Root", &names, 0);
    return names;
  }
  GenicamFeature feature(const std::string& name) override {
    GenicamFeature feature;
    ArvGcNode* node = arv_device_get_feature(device_.get(), name.c_str());
    if (node == nullptr || !ARV_IS_GC_FEATURE_NODE(node)) return feature;
    Error hidden;
    if (!arv_device_is_feature_available(device_.get(), name.c_str(), hidden.out())) return feature;
    describe_kind(node, &feature);
    Error locked;
    const ArvGcAccessMode mode = arv_gc_feature_node_get_actual_access_mode(ARV_GC_FEATURE_NODE(node));
    const bool open = !arv_gc_feature_node_is_locked(ARV_GC_FEATURE_NODE(node), locked.out());
    feature.writable = mode != ARV_GC_ACCESS_MODE_RO && open;
    if (mode == ARV_GC_ACCESS_MODE_WO || feature.kind == GenicamFeature::Kind::command) return feature;
    Error error;
    feature.value = value_text(ARV_GC_FEATURE_NODE(node), error.out());
    feature.readable = error.none();
    return feature;
  }
  bool set(const std::string& name, const std::string& value, std::string* fault) override {
    ArvGcNode* node = arv_device_get_feature(device_.get(), name.c_str());
    if (node == nullptr || !ARV_IS_GC_FEATURE_NODE(node)) {
      *fault = "there is no such feature";
      return false;
    }
    Error error;
    arv_gc_feature_node_set_value_from_string(ARV_GC_FEATURE_NODE(node), value.c_str(), error.out());
    return error.tell(fault);
  }
  bool execute(const std::string& command, std::string* fault) override {
    Error error;
    arv_device_execute_command(device_.get(), command.c_str(), error.out());
    return error.tell(fault);
  }

  bool stream_on(unsigned buffers, std::string* fault) override {
    stream_off();
    Error error;
    const gint64 payload = arv_device_get_integer_feature_value(device_.get(), "PayloadSize", error.out());
    if (!error.tell(fault)) return false;
    stream_.reset(arv_device_create_stream(device_.get(), nullptr, nullptr, error.out()));
    if (!stream_) {
      *fault = error.text();
      return false;
    }
    for (unsigned i = 0; i < buffers; ++i)
      arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(static_cast<std::size_t>(payload)));
    return true;
  }
  void stream_off() noexcept override {
    give_back();
    if (!stream_) return;
    counts_ = read_counts();
    stream_.reset();
  }
  std::optional<GenicamBuffer> next(std::chrono::milliseconds timeout) override {
    give_back();
    if (!stream_) return std::nullopt;
    held_ = timeout.count() > 0
                ? arv_stream_timeout_pop_buffer(stream_.get(), 1000 * static_cast<guint64>(timeout.count()))
                : arv_stream_try_pop_buffer(stream_.get());
    if (held_ == nullptr) return std::nullopt;
    return to_buffer(held_);
  }
  GenicamCounts counts() override { return stream_ ? read_counts() : counts_; }

 private:
  static void on_lost(ArvDevice*, void* lost) { *static_cast<std::atomic<bool>*>(lost) = true; }
  void give_back() noexcept {
    if (held_ != nullptr && stream_) arv_stream_push_buffer(stream_.get(), held_);
    held_ = nullptr;
  }
  std::uint64_t count(const char* name) const {
    for (guint i = 0; i < arv_stream_get_n_infos(stream_.get()); ++i)
      if (std::string_view(arv_stream_get_info_name(stream_.get(), i)) == name)
        return arv_stream_get_info_uint64(stream_.get(), i);
    return 0;  // USB3 Vision knows no packets
  }
  GenicamCounts read_counts() const {
    return {count("n_underruns"), count("n_missing_packets"), count("n_resend_requests"),
            count("n_resent_packets")};
  }

  Ref<ArvDevice> device_;
  Ref<ArvStream> stream_;
  ArvBuffer* held_ = nullptr;
  GenicamCounts counts_;
  std::atomic<bool> lost_ = false;
};

class AravisModule final : public GenicamModule {
 public:
  std::string version() const override {
    return fmt::format("Aravis {}.{}.{}", arv_get_major_version(), arv_get_minor_version(),
                       arv_get_micro_version());
  }
  std::vector<GenicamListed> devices() override {
    arv_update_device_list();
    std::vector<GenicamListed> list;
    for (unsigned i = 0; i < arv_get_n_devices(); ++i)
      list.push_back({text_or_empty(arv_get_device_id(i)), text_or_empty(arv_get_device_vendor(i)),
                      text_or_empty(arv_get_device_model(i)), text_or_empty(arv_get_device_serial_nbr(i)),
                      text_or_empty(arv_get_device_protocol(i)), text_or_empty(arv_get_device_address(i))});
    return list;
  }
  std::unique_ptr<GenicamDevice> open(const std::string& id, std::string* fault) override {
    Error error;
    ArvDevice* device = arv_open_device(id.c_str(), error.out());
    if (device == nullptr) {
      *fault = error.text();
      return nullptr;
    }
    return std::make_unique<AravisDevice>(device);
  }
};

}  // namespace
}  // namespace fringetwin::capture

extern "C" fringetwin::capture::GenicamModule* fringetwin_genicam_module_1() {
  static fringetwin::capture::AravisModule module;
  return &module;
}
