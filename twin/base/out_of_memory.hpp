// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

namespace fringetwin {

/// Memory that cannot be had, by someone who can say whose; exit code 3. Not a UserError, which some callers
/// take as the refusal of what they try.
class OutOfMemory : public std::bad_alloc {
 public:
  explicit OutOfMemory(const std::string& whose) : text_(whose) {}
  const char* what() const noexcept override { return text_.what(); }

 private:
  std::runtime_error text_;  // whose copies never throw
};

/// Returns whose memory, or thread, could not be had ("" where nothing is known of it), a text of the fault;
/// nullptr for a fault of any other kind. Takes no memory.
inline const char* want_of_memory(const std::exception& fault) {
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
