// SPDX-License-Identifier: Apache-2.0
// Errors a user can mend, and the exit codes of the program (docs/CONVENTIONS.md, "Exit codes").
#pragma once
#include <stdexcept>
#include <string>

namespace fringetwin {

/// Exit codes of the command line (contract).
enum class ExitCode : int {
  ok = 0,
  limits_not_met = 1,
  usage = 2,   ///< usage or configuration (twin.toml, options)
  input = 3,   ///< input data (images, meshes, capture sets)
  device = 4,  ///< no or failing Vulkan device
  no_convergence = 5,
  internal = 70,
};

/// A fault in what the user gave us: where it is, what it is, what to do.
/// what() returns the one sentence shown to the user.
class UserError : public std::runtime_error {
 public:
  UserError(ExitCode code, const std::string& where, const std::string& what, const std::string& hint = "")
      : std::runtime_error((where.empty() ? "" : where + ": ") + what + (hint.empty() ? "" : "; " + hint)),
        code_(code) {}
  ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// A key, or the path of one, that does not exist: wrong whatever its value is.
class UnknownKey : public UserError {
 public:
  UnknownKey(ExitCode code, const std::string& where, const std::string& what, const std::string& hint)
      : UserError(code, where, what, hint) {}
};

/// Thrown by long work when the user pressed Ctrl-C (exit code 130).
class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("cancelled by the user") {}
};

namespace detail {
[[noreturn]] void check_failed(const char* expression, const char* file, int line,
                               const std::string& message);
}

}  // namespace fringetwin

/// A programming fault: stays on in Release; ends in exit code 70.
#define FT_CHECK(condition, message)                                                                 \
  do {                                                                                               \
    if (!(condition)) ::fringetwin::detail::check_failed(#condition, __FILE__, __LINE__, (message)); \
  } while (false)
