// SPDX-License-Identifier: Apache-2.0
// Takes the folder that a run writes into (--out): refuses it before the work when it cannot be written, and
// keeps it from looking complete while it is not.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "twin/base/not_copyable.hpp"

namespace fringetwin {

/// Throws UserError(usage) unless `dir` is a folder that can be written, or one that can be made. It makes
/// nothing: a run that fails leaves nothing behind.
void check_out_folder(const std::filesystem::path& dir);

/// Takes `dir`, which exists, for this process until it ends, or for the FoldersOfCall of this thread;
/// returns false while another process or another call has it. A folder that cannot be locked (of some
/// shares) belongs to everybody.
bool hold_folder(const std::filesystem::path& dir);

/// Gives back at its end the folders that its thread has taken while it lived: for calls in a process that
/// outlives them, as Python's. One within another leaves them to the outer one.
class FoldersOfCall : NotCopyable {
 public:
  FoldersOfCall();
  ~FoldersOfCall();
};

enum class Writers { one, several };  ///< that may write into a folder at the same time

/// Makes `dir` and removes the files (relative to it) that an earlier run wrote last, which a reader takes
/// for the sign that all the others are there. With Writers::one it waits until hold_folder() has taken the
/// folder, and warns that it waits: two runs must not mix their files. Throws UserError(usage), Cancelled.
void begin_output(const std::filesystem::path& dir, const std::vector<std::string>& last_files,
                  Writers writers = Writers::one);

}  // namespace fringetwin
