// SPDX-License-Identifier: Apache-2.0
// fringetwin: data on stdout, narration on stderr, exit codes of docs/CONVENTIONS.md.
#include <malloc.h>

#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "cli/commands.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace {

constexpr int kExitCancelled = 130;  // 128 + SIGINT, as a shell reports it

int report(const std::string& sentence, int code) {
  std::fprintf(stderr, "fringetwin: error: %s\n", sentence.c_str());
  return code;
}

int run(const fringetwin::cli::Invocation& invocation) {
  using fringetwin::ExitCode;
  try {
    return invocation.run();
  } catch (const fringetwin::UserError& e) {
    return report(e.what(), static_cast<int>(e.code()));
  } catch (const fringetwin::Cancelled& e) {
    return report(e.what(), kExitCancelled);
  } catch (const std::filesystem::filesystem_error& e) {
    return report(std::string(e.what()) + "; check that the folder exists and can be written",
                  static_cast<int>(ExitCode::input));
  } catch (const std::bad_alloc&) {
    return report("not enough memory for this twin; render fewer pixels or patterns at a time",
                  static_cast<int>(ExitCode::internal));
  } catch (const std::exception& e) {
    return report(std::string("internal: ") + e.what() + "; please report this with the command line",
                  static_cast<int>(ExitCode::internal));
  }
}

}  // namespace

// NOLINTNEXTLINE(bugprone-exception-escape): registering the options throws at a fault of ours only
int main(int argc, char** argv) {
  // Images are made and dropped by the dozen: their memory is kept, or the kernel would clear each page anew.
  mallopt(M_MMAP_THRESHOLD, 1 << 25);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  std::setlocale(LC_ALL, "C");
  fringetwin::install_cancel_handler();

  CLI::App app{"fringetwin: a digital twin of fringe-projection rigs, checked against real captures."};
  app.require_subcommand(1);
  app.fallthrough();  // -q is understood after the subcommand, too
  app.set_version_flag("--version", fringetwin::cli::version_string());
  app.footer(
      "Exit codes: 0 pass, 1 limits not met, 2 usage or configuration, 3 input data, 4 device,\n"
      "5 no convergence, 70 internal, 130 cancelled.");
  bool quiet = false;
  app.add_flag("-q,--quiet", quiet, "No narration on stderr (warnings and errors stay)");

  fringetwin::cli::Invocation invocation;
  invocation.argv.assign(argv, argv + argc);
  using namespace fringetwin::cli;
  for (auto* add : {add_cosim, add_render, add_measure, add_compare, add_diff, add_import, add_calibrate,
                    add_photometry, add_capture, add_needs, add_pareto, add_study, add_info})
    add(app, invocation);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    const int code = app.exit(e);  // prints help, version, or the error and a hint
    return code == 0 ? 0 : static_cast<int>(fringetwin::ExitCode::usage);
  }
  fringetwin::set_quiet(quiet);
  return run(invocation);
}
