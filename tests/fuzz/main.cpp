// SPDX-License-Identifier: Apache-2.0
// Gives changed inputs to every reader of foreign files, and keeps what breaks one (CONTRIBUTING.md, "Files
// from strangers").
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <stdexcept>

#include "tests/fuzz/worker.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/sha256.hpp"

namespace fringetwin::fuzz {
namespace {
namespace fs = std::filesystem;

constexpr int kMostFindings = 5;  ///< of one target: the rest is found when these are mended

struct Options {
  std::string source, out = "fuzz-findings", corpus, replay;
  std::vector<std::string> targets;
  double seconds = 60.0;
  int jobs = 1;
  std::uint64_t seed = 1;
};

/// Keeps input and log; returns the file.
fs::path keep(const Options& options, const Target& target, const WorkerEnd& end) {
  fs::create_directories(options.out);
  const fs::path file =
      fs::path(options.out) / fmt::format("{}-{}", target.name, sha256_of_text(end.input).substr(0, 12));
  for (const auto& [name, bytes] : {std::pair{file.string(), end.input}, {file.string() + ".log", end.log}})
    if (FILE* out = std::fopen(name.c_str(), "wb")) {
      std::fwrite(bytes.data(), 1, bytes.size(), out);
      std::fclose(out);
    }
  return fs::absolute(file);
}

/// Whether what took too long is read in time by itself: a machine that is held up makes anything slow, and
/// the time that other guests of its processor take counts as computing here.
bool is_in_time_again(const Target& target, const WorkerEnd& end) {
  if (!end.too_long) return false;
  const bool in_time = run_worker({.target = &target, .replayed = end.input}).fault.empty() && !cancelled();
  if (in_time) fmt::print("{}: {} once, and in time when it was read again\n", target.name, end.fault);
  return in_time;
}

/// Fuzzes one target for its share of the time, anew after each finding. Returns the number of findings.
int fuzz(const Options& options, const Target& target, double seconds) {
  WorkerPlan plan{.target = &target, .seed = options.seed};
  if (!options.corpus.empty()) {
    plan.corpus = fs::path(options.corpus) / target.name;
    fs::create_directories(plan.corpus);
  }
  std::size_t runs = 0, kept = 0;
  int findings = 0;
  for (; seconds > 0.0 && findings < kMostFindings && !cancelled(); ++plan.seed) {
    plan.seconds = seconds;
    const WorkerEnd end = run_worker(plan);
    runs += end.runs;
    kept += end.kept;
    seconds -= std::max(end.seconds, 0.01);
    if (end.fault.empty()) break;
    plan.known.insert(end.input);
    if (is_in_time_again(target, end)) continue;
    ++findings;
    const fs::path file = keep(options, target, end);
    fmt::print("{}: {}\n  replay: {} --source {} --target {} --replay {}\n", target.name, end.fault,
               fs::read_symlink("/proc/self/exe").string(), options.source, target.name, file.string());
  }
  fmt::print("{:<17} {:>9} runs {:>6} with new code {:>3} findings\n", target.name, runs, kept, findings);
  std::fflush(stdout);
  return findings;
}

/// All targets, `jobs` at a time, each in processes of its own. Returns whether any has a finding.
bool fuzz_all(const Options& options, const std::vector<const Target*>& targets) {
  // All jobs have the time; where they are not all at work to the end, the readers have less of it.
  const auto jobs = static_cast<std::size_t>(options.jobs);
  const std::size_t rounds = (targets.size() + jobs - 1) / jobs;
  const double seconds = options.seconds / static_cast<double>(jobs * rounds);
  std::size_t next = 0, running = 0;
  bool any = false;
  while (next < targets.size() || running > 0) {
    if (next < targets.size() && running < jobs) {
      std::fflush(stdout);
      const pid_t process = ::fork();
      if (process < 0) throw std::runtime_error("no further process can be started");
      if (process == 0) std::_Exit(fuzz(options, *targets[next], seconds) > 0 ? 1 : 0);
      ++next;
      ++running;
      continue;
    }
    int status = 0;
    if (::wait(&status) < 0) continue;
    --running;
    any = any || status != 0;
  }
  return any;
}

bool replay(const Options& options, const Target& target) {
  const WorkerEnd end = run_worker({.target = &target, .replayed = get_file(options.replay)});
  fmt::print("{}{}: {}\n", end.log, options.replay,
             end.fault.empty() ? "read or refused as it should be" : end.fault);
  return !end.fault.empty();
}

std::vector<const Target*> chosen(const Options& options) {
  if (options.targets.empty()) return all_targets();
  std::vector<const Target*> targets;
  for (const std::string& name : options.targets) targets.push_back(find_target(name));
  return targets;
}

int run(int argc, char** argv) {
  std::vector<std::string> names;
  for (const Target* target : all_targets()) names.emplace_back(target->name);
  Options options;
  CLI::App app{"Gives changed inputs to the readers of foreign files; exit code 1 when one breaks."};
  app.add_option("--source", options.source, "The checkout, whose tests/bad_files are the seeds")->required();
  auto* target =
      app.add_option("--target", options.targets, "Only these readers")->check(CLI::IsMember(names));
  app.add_option("--seconds", options.seconds, "Of computing, all readers together")->capture_default_str();
  app.add_option("--jobs", options.jobs, "Readers at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "The same seed changes inputs in the same way")
      ->capture_default_str();
  app.add_option("--out", options.out, "Folder for inputs that break a reader")->capture_default_str();
  app.add_option("--corpus", options.corpus, "Folder that keeps inputs which ran new code, for a next time");
  app.add_option("--replay", options.replay, "Read this file alone, with --target")
      ->check(CLI::ExistingFile)
      ->needs(target);
  CLI11_PARSE(app, argc, argv);
  ::setenv("FRINGETWIN_CACHE", "", 1);
  ::setenv("FRINGETWIN_CAPTURES", "/nowhere", 1);  // large images are good, but read slowly
  install_cancel_handler();
  set_source_folder(options.source);
  const std::vector<const Target*> targets = chosen(options);
  const bool any = options.replay.empty() ? fuzz_all(options, targets) : replay(options, *targets.front());
  return cancelled() ? 130 : any ? 1 : 0;
}

}  // namespace
}  // namespace fringetwin::fuzz

int main(int argc, char** argv) {
  try {
    return fringetwin::fuzz::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_readers: %s\n", error.what());
    return 2;
  }
}
