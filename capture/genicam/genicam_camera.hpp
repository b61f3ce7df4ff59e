// SPDX-License-Identifier: Apache-2.0
// A GenICam camera (USB3 Vision, GigE Vision) as the recording sees it: set up once, then a frame for each
// software trigger or for each pulse on a line, or frames as they come.
#pragma once
#include "capture/device/pfnc_format.hpp"
#include "capture/genicam/frame_count.hpp"
#include "capture/genicam/genicam_options.hpp"
#include "capture/genicam/genicam_settings.hpp"

namespace fringetwin::capture {

class GenicamCamera final : public CameraDevice {
 public:
  /// Everything is set and read back here; throws UserError(device). `provenance`: who the camera is.
  GenicamCamera(GenicamCameraOptions options, std::unique_ptr<GenicamDevice> device,
                std::map<std::string, std::string> provenance = {});
  ~GenicamCamera() override { stop(); }

  CameraInfo info() const override;
  void start() override;
  void stop() noexcept override;
  void trigger() override;
  Frame next_frame(std::chrono::milliseconds timeout, Pixels pixels) override;
  void drain() override;
  void check_input() override;

  std::optional<ExposureRange> exposure_range() const override;
  std::optional<double> exposure_ms() const override { return exposure_ms_; }
  double set_exposure_ms(double exposure_ms) override;

 private:
  void set_up();
  void set_up_trigger();
  /// Sets the user's TriggerActivation, TriggerDelay ... for the selected kind of trigger.
  void set_trigger_controls();
  void set_up_line();
  void set_up_rate();
  Frame to_frame(const GenicamBuffer& buffer, Pixels pixels);
  UnpackedFrame unpack(const GenicamBuffer& buffer, Pixels pixels) const;
  std::optional<GenicamBuffer> await_buffer(std::chrono::milliseconds timeout);
  [[noreturn]] void throw_fault(DeviceFault::Kind otherwise, const std::string& doing);
  void note_counts();
  /// Returns what the camera says of the network's clock; "" where it does not follow one.
  std::string ptp_status() const;
  void await_shared_clock();

  GenicamCameraOptions options_;
  std::unique_ptr<GenicamDevice> device_;
  GenicamSettings settings_;
  PfncLayout layout_;
  std::string exposure_feature_;  ///< "": none
  std::optional<double> exposure_ms_, period_ms_;
  bool triggered_ = false;  ///< by this program
  std::string pulse_line_;  ///< that triggers it otherwise; "": none
  std::map<std::string, std::string> provenance_;
  std::vector<std::string> recorded_;  ///< features whose values are kept

  std::vector<std::pair<std::string, std::string>> trigger_controls_;
  std::string ptp_;  ///< ptp_status() as the stream began
  bool streaming_ = false, gone_ = false;
  bool unanswered_ = false;                ///< a trigger whose frame did not come in time
  std::optional<TimeNs> trigger_sent_ns_;  ///< its frame has not been taken yet
  BlockCount blocks_;
  TriggerClock clock_;
  TimeNs last_stamp_ns_ = 0;
  GenicamCounts counts_;  ///< of all streams before this one
};

}  // namespace fringetwin::capture
