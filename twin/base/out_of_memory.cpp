// SPDX-License-Identifier: Apache-2.0
#include "twin/base/out_of_memory.hpp"

#include <system_error>

namespace fringetwin {

const char* want_of_memory(const std::exception& fault) {
  if (const auto* system = dynamic_cast<const std::system_error*>(&fault))  // no thread is "again"
    return system->code() == std::errc::not_enough_memory ||
                   system->code() == std::errc::resource_unavailable_try_again
               ? system->what()
               : nullptr;
  if (dynamic_cast<const std::length_error*>(&fault)) return "a size that no memory has";  // a container's
  if (dynamic_cast<const OutOfMemory*>(&fault)) return fault.what();
  if (dynamic_cast<const std::bad_alloc*>(&fault)) return "";
  return nullptr;
}

}  // namespace fringetwin
