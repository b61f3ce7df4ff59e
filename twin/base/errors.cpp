// SPDX-License-Identifier: Apache-2.0
#include "twin/base/errors.hpp"

namespace fringetwin::detail {

void check_failed(const char* expression, const char* file, int line, const std::string& message) {
  throw std::logic_error(std::string(file) + ":" + std::to_string(line) + ": check failed: " + expression +
                         (message.empty() ? "" : ": " + message));
}

}  // namespace fringetwin::detail
