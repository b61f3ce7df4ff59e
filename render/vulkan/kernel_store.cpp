// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/kernel_store.hpp"

#include <system_error>

namespace fringetwin::render {

void KernelStore::make(const Key& key, Slot& slot) {
  const std::lock_guard lock(slot.making);
  if (!slot.kernel) slot.kernel = make_(key);
}

ComputePipeline& KernelStore::get(const Key& key) {
  Slot& slot = slots_[key];
  make(key, slot);
  return *slot.kernel;
}

void KernelStore::foresee(const std::vector<Key>& keys) {
  stop();
  std::vector<std::pair<Key, Slot*>> missing;
  for (const Key& key : keys)
    if (Slot& slot = slots_[key]; !slot.kernel) missing.emplace_back(key, &slot);
  if (missing.empty()) return;
  const auto work = [this, missing = std::move(missing)](const std::stop_token& stop) {
    for (const auto& [key, slot] : missing) {
      if (stop.stop_requested()) return;
      try {
        make(key, *slot);
      } catch (...) {
        return;  // get() meets it again, if the kernel is needed at all
      }
    }
  };
  try {
    worker_ = std::jthread(work);
  } catch (const std::system_error&) {
    // Without a thread the kernels are made when they are needed.
  }
}

void KernelStore::stop() { worker_ = {}; }

void KernelStore::clear() {
  stop();
  slots_.clear();
}

}  // namespace fringetwin::render
