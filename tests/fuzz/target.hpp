// SPDX-License-Identifier: Apache-2.0
// A fuzz target: a reader of the program, what good inputs of it look like, and how its inputs are changed.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/random.hpp"
#include "twin/base/errors.hpp"

namespace fringetwin::fuzz {

/// Changes an input, knowing what it is made of. It may return it as it was, where it is not of that make.
using Mutator = std::string (*)(const std::string& input, Random& random);

struct Target {
  const char* name;
  /// Gives the input to the reader. UserError is right; whatever else it throws is a finding.
  void (*read)(const std::string& input);
  /// Good inputs: files below tests/bad_files, "good/part.ply", or a folder of it, "ply", whose files are
  /// taken whole ...
  std::vector<std::string> seed_files = {};
  /// ... and others that code makes.
  std::vector<std::string> (*seeds)() = nullptr;
  Mutator mutate = nullptr;
  std::vector<std::string> words = {};  ///< that the format knows
};

/// Returns all targets. A new one: its file NAME_fuzz.cpp, a line in targets.cpp, one in CMakeLists.txt.
const std::vector<const Target*>& all_targets();
/// Returns the target of that name; nullptr where there is none.
const Target* find_target(const std::string& name);

/// Reads an input with a target. Does not return, after a word on stderr, where the reader throws what is no
/// UserError, or one that blames neither the command line nor the input.
void read_checked(const Target& target, const std::string& input);

/// Calls a reader whose refusal shall not keep the next one from its turn.
template <class Read>
void read_or_refuse(Read read) {
  try {
    read();
  } catch (const UserError& error) {
    if (error.code() != ExitCode::usage && error.code() != ExitCode::input) throw;
  }
}

/// The checkout, where tests/bad_files lies; set before any seed is asked for.
void set_source_folder(const std::filesystem::path& source);
const std::filesystem::path& source_folder();
/// Returns the seeds of a target, a good one first; always in the same order.
std::vector<std::string> seeds_of(const Target& target);

/// The folder in which this process gives files to readers, with the good files beside; made when first asked
/// for, in memory where the machine has such a file system.
const std::filesystem::path& work_folder();
/// Removes it.
void remove_work_folder();
/// Writes WORK_FOLDER/name.
std::filesystem::path put_file(const std::string& name, const std::string& bytes);
std::string get_file(const std::filesystem::path& file);

}  // namespace fringetwin::fuzz
