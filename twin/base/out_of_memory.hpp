// SPDX-License-Identifier: Apache-2.0
#pragma once
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

}  // namespace fringetwin
