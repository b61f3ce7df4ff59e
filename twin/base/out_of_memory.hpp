// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

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
const char* want_of_memory(const std::exception& fault);

}  // namespace fringetwin
