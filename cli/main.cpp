// SPDX-License-Identifier: Apache-2.0
// fringetwin: data on stdout, narration on stderr, exit codes of docs/CONVENTIONS.md.
#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <opencv2/core.hpp>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "cli/commands.hpp"
#include "cli/exit_guard.hpp"
#include "cli/manual/argument_fault.hpp"
#include "cli/manual/command_text.hpp"
#include "cli/manual/help_page.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/plain_text.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/safe_file.hpp"

namespace {

using fringetwin::ExitCode;
using fringetwin::UserError;

constexpr int kExitCancelled = 130;  // 128 + SIGINT, as a shell reports it

int report(const std::string& sentence, int code) {
  static const std::string kBefore = "fringetwin: error: ";
  const std::string shown =
      fringetwin::plain_sentence(sentence, fringetwin::kLongestSentence - kBefore.size());
  std::fprintf(stderr, "%s%s\n", kBefore.c_str(), shown.c_str());
  return code;
}

/// A closed standard stream leaves its number to the next file that is opened, and what is printed would land
/// in that.
void open_standard_streams() {
  int file = 0;
  do file = ::open("/dev/null", O_RDWR);
  while (file >= 0 && file <= STDERR_FILENO);
  if (file > STDERR_FILENO) ::close(file);
}

int report(const std::string& sentence, ExitCode code) { return report(sentence, static_cast<int>(code)); }

constexpr const char* kNotEnough = "not enough memory";
constexpr const char* kWantLess =
    "; render fewer pixels or patterns at a time, use fewer threads (OMP_NUM_THREADS), or allow more "
    "(ulimit -v)";

std::terminate_handler terminate_as_before = nullptr;

[[noreturn]] void end_without_memory() {
  static std::atomic_flag told;
  while (told.test_and_set()) ::pause();  // another thread ends the program
  std::fprintf(stderr, "fringetwin: error: %s%s\n", kNotEnough, kWantLess);  // takes no memory
  std::_Exit(static_cast<int>(ExitCode::input));
}

/// The same as fringetwin::want_of_memory, which knows no OpenCV.
const char* want_of_memory(const std::exception& fault) {
  if (const auto* opencv = dynamic_cast<const cv::Exception*>(&fault))
    return opencv->code == cv::Error::StsNoMem ? "OpenCV" : nullptr;
  return fringetwin::want_of_memory(fault);
}

/// Memory may also run out on a thread, where nobody could catch it.
[[noreturn]] void on_terminate() {
  try {
    if (const std::exception_ptr fault = std::current_exception()) std::rethrow_exception(fault);
  } catch (const std::bad_alloc&) {
    end_without_memory();
  } catch (const std::exception& fault) {
    if (want_of_memory(fault)) end_without_memory();
  } catch (...) {
    // a fault of ours, told as ever
  }
  terminate_as_before();
  std::abort();
}

/// Names of files and options become part of results, which are UTF-8; nothing is named by an empty text.
void check_arguments(const std::vector<std::string>& argv) {
  for (const std::string& argument : argv)
    if (argument.empty())
      throw UserError(ExitCode::usage, "\"\"", "one of the arguments is empty",
                      "is it a variable of the shell that is not set?");
    else if (!fringetwin::is_utf8(argument))
      throw UserError(ExitCode::usage, argument, "is no UTF-8 text", "rename the file or folder");
}

/// What was printed has left the program: a full disk shows when the last of it is written.
void check_output() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw UserError(
        ExitCode::input, "standard output",
        errno != 0 ? "cannot be written (" + std::string(std::strerror(errno)) + ")" : "cannot be written",
        "make room, or print elsewhere");
}

int report_fault(const std::exception& fault) {
  if (const char* whose = want_of_memory(fault))
    return report(kNotEnough + (*whose == '\0' ? "" : " (" + std::string(whose) + ")") + kWantLess,
                  ExitCode::input);
  if (dynamic_cast<const std::filesystem::filesystem_error*>(&fault))
    return report(std::string(fault.what()) + "; check that the folder exists and can be written",
                  ExitCode::input);
  if (dynamic_cast<const std::system_error*>(&fault))  // no room where output goes
    return report(std::string(fault.what()) + "; free disk space, or raise the limits of this session",
                  ExitCode::input);
  return report(std::string("internal: ") + fault.what() + "; please report this with the command line",
                ExitCode::internal);
}

int run(const fringetwin::cli::Invocation& invocation) {
  try {
    check_arguments(invocation.argv);
    const int code = invocation.run();
    check_output();
    return code;
  } catch (const UserError& e) {
    return report(e.what(), e.code());
  } catch (const fringetwin::Cancelled& e) {
    return report(e.what(), kExitCancelled);
  } catch (const std::exception& e) {
    return report_fault(e);
  }
}

/// Prints help or version.
int tell(const CLI::App& app, const CLI::ParseError& answer) {
  std::ostringstream out;
  app.exit(answer, out, out);
  std::fputs(out.str().c_str(), stdout);
  return 0;
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): registering the options throws at a fault of ours only
int main(int argc, char** argv) {
  // Images are made and dropped by the dozen: their memory is kept, or the kernel would clear each page anew.
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  std::setlocale(LC_ALL, "C");
  open_standard_streams();
  const fringetwin::cli::ExitGuard exit_guard;
  fringetwin::install_cancel_handler();
  terminate_as_before = std::set_terminate(on_terminate);

  CLI::App app{"fringetwin: a digital twin of fringe-projection rigs, checked against real captures."};
  app.require_subcommand(1);
  app.fallthrough();  // -q is understood after the subcommand, too
  app.set_version_flag("--version", fringetwin::cli::version_string())
      ->group(fringetwin::cli::kCommonOptions);
  app.formatter(fringetwin::cli::help_formatter());
  bool quiet = false;
  app.add_flag("-q,--quiet", quiet, "No narration on stderr (warnings and errors stay)")
      ->group(fringetwin::cli::kCommonOptions);
  bool verbose = false;
  app.add_flag("-v,--verbose", verbose,
               "Say on stderr, too, which stage begins, how long it took, which files are written")
      ->excludes("--quiet")
      ->group(fringetwin::cli::kCommonOptions);
  double limits = 1.0;
  app.add_option("--limits", limits,
                 "Factor on every limit of what is read from files (docs/FORMATS.md, \"Limits\"); for files "
                 "that you trust")
      ->check(CLI::Range(1.0, 1e6).description("1 ... 1e6"))
      ->type_name("FACTOR")
      ->capture_default_str()
      ->group(fringetwin::cli::kCommonOptions);

  fringetwin::cli::Invocation invocation;
  invocation.argv.assign(argv, argv + argc);
  using namespace fringetwin::cli;
  for (auto* add :
       {add_cosim,  add_render, add_measure, add_compare,   add_diff,       add_export,  add_open,
        add_index,  add_new,    add_import,  add_calibrate, add_photometry, add_capture, add_needs,
        add_pareto, add_study,  add_info,    add_help,      add_version,    add_man,     add_completions})
    add(app, invocation);
  app.footer(  // last: commands would take it over
      "Exit codes: 0 pass, 1 limits not met, 2 usage or configuration, 3 input data, 4 device, "
      "5 no convergence, 70 internal, 130 cancelled.");

  try {
    app.parse(argc, argv);
    if (const auto fault = argc > 0 ? fault_of_taken_option(app, {argv + 1, argv + argc}) : std::nullopt)
      invocation.run = [fault]() -> int { throw UserError(*fault); };
  } catch (const CLI::Success& e) {
    invocation.run = [&app, answer = CLI::ParseError(e)] { return tell(app, answer); };
  } catch (const CLI::ParseError& e) {
    invocation.run = [fault = argument_fault(app, {argv + 1, argv + argc}, e)]() -> int { throw fault; };
  }
  fringetwin::set_quiet(quiet);
  fringetwin::set_verbose(verbose);
  if (limits > 1.0) fringetwin::raise_file_limits(limits);  // not where it is "nan"
  return run(invocation);
}
