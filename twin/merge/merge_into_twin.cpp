// SPDX-License-Identifier: Apache-2.0
#include "twin/merge/merge_into_twin.hpp"

#include <algorithm>

#include "twin/base/errors.hpp"
#include "twin/base/paths.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/image/image_io.hpp"
#include "twin/merge/toml_merge.hpp"
#include "twin/twin.hpp"

namespace fringetwin {
namespace fs = std::filesystem;
namespace {

std::string text_of(const fs::path& file) {
  return read_whole_text(file, {.what = "TOML file", .code = ExitCode::usage});
}

/// Throws UserError(usage) with what load_twin() says of the text, in the words of the file's own name.
void check_loads(const fs::path& written, const fs::path& file) {
  try {
    (void)load_twin(written);
  } catch (const UserError& error) {
    std::string why = error.what();
    if (why.starts_with(written.string())) why.replace(0, written.string().size(), file.string());
    throw UserError(error.code(), file.string(), "would be no twin any more with these values (" + why + ")",
                    "it stays as it was");
  }
}

}  // namespace

void check_merge_into_twin(const fs::path& into, const std::vector<TomlBlock>& blocks) {
  const fs::path file = twin_file_of(into);
  std::vector<TomlBlock> tables = blocks;
  for (TomlBlock& table : tables) table.keys.clear();
  (void)merge_toml(text_of(file), tables, file.string());
}

void name_files_from(const fs::path& into, const fs::path& dir, const std::vector<std::string>& keys,
                     std::vector<TomlBlock>& blocks) {
  const fs::path folder = tidy_path(twin_file_of(into)).parent_path();
  for (TomlBlock& block : blocks)
    for (TomlKey& key : block.keys)
      if (std::ranges::find(keys, key.name) != keys.end()) {
        const fs::path name = key.value.substr(1, key.value.size() - 2);
        key.value = "\"" + (tidy_path(dir) / name).lexically_relative(folder).generic_string() + "\"";
      }
}

std::size_t merge_into_twin(const fs::path& into, const std::vector<TomlBlock>& blocks) {
  const fs::path file = twin_file_of(into);
  const std::string before = text_of(file);
  const std::string after = merge_toml(before, blocks, file.string());
  std::error_code error;
  fs::path target = fs::canonical(file, error);
  if (error) target = file;
  TemporaryFile temporary(target);
  write_text_file(temporary.path(), after);
  check_loads(temporary.path(), file);
  fs::permissions(temporary.path(), fs::status(target).permissions(), error);  // a share may have none
  temporary.commit();
  std::size_t n = 0;
  for (const TomlBlock& block : blocks) n += block.keys.size();
  return n;
}

}  // namespace fringetwin
