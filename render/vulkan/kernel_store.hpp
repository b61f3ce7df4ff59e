// SPDX-License-Identifier: Apache-2.0
// Keeps the specialised kernels: each is made once, in the background ahead of its use where that is
// foreseen. Internal to render/ (includes volk).
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <tuple>
#include <vector>

#include "render/base/kernels.hpp"
#include "render/vulkan/vulkan_device.hpp"
#include "twin/base/not_copyable.hpp"

namespace fringetwin::render {

/// A store serves one thread; only the making runs beside it. Lavapipe's compiler works on one core,
/// and a mesh under the default sampling needs a second of it.
class KernelStore : NotCopyable {
 public:
  using Key = std::tuple<Kernel, bool, bool, SpecConstants>;  ///< storage geometry, double precision
  using Make = std::function<std::unique_ptr<ComputePipeline>(const Key&)>;

  explicit KernelStore(Make make) : make_(std::move(make)) {}
  ~KernelStore() { clear(); }

  /// Returns the kernel of a key; makes it, or waits while it is being made. Passes on what the making
  /// throws.
  ComputePipeline& get(const Key& key);
  /// Makes kernels in the background, in this order, those that will be needed first first.
  void foresee(const std::vector<Key>& keys);
  /// Stops the making ahead after the kernel in work; stop() waits for that one.
  void stop_soon() { worker_.request_stop(); }
  void stop();
  /// Stops and forgets all kernels.
  void clear();

 private:
  struct Slot {
    std::mutex making;
    std::unique_ptr<ComputePipeline> kernel;
  };
  void make(const Key& key, Slot& slot);

  Make make_;
  std::map<Key, Slot> slots_;  // their addresses stay
  std::jthread worker_;
};

}  // namespace fringetwin::render
