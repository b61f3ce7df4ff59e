// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/attempt_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "report/json.hpp"
#include "study/engine/worker.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/base/time_and_host.hpp"
#include "twin/file/json_values.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

using report::json_line;

constexpr int kLastExitCode = 255;
constexpr std::size_t kMostBadLines = 50;  // of one look at the files: a stranger's may have millions

[[noreturn]] void refuse_attempt(const fs::path& file, int error) {
  throw UserError(ExitCode::input, file.string(), fmt::format("cannot be written ({})", std::strerror(error)),
                  "what is finished is safe: make room and run the study again");
}

}  // namespace

AttemptLog::AttemptLog(const fs::path& folder, std::size_t shard, const AttemptHead& head) {
  for (int n = 0; fd_ < 0; ++n) {
    file_ = folder / fmt::format("shard-{}.attempt-{}.jsonl", shard, n);
    fd_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0666);
    if (fd_ < 0 && errno != EEXIST) refuse_attempt(file_, errno);
  }
  append(json_line({{"attempt", head.job},
                    {"restart", head.restart},
                    {"host", head.host},
                    {"version", head.version},
                    {"began_at", utc_now()}}));
}

AttemptLog::~AttemptLog() { close(fd_); }

void AttemptLog::append(const std::string& line) {
  const std::string text = line + '\n';
  for (std::size_t written = 0; written < text.size();) {
    const ssize_t n = write(fd_, text.data() + written, text.size() - written);
    if (n < 0 && errno != EINTR) refuse_attempt(file_, errno);
    if (n > 0) written += static_cast<std::size_t>(n);
  }
  if (fsync(fd_) != 0) refuse_attempt(file_, errno);
}

void AttemptLog::begun(std::int64_t id) { append(json_line({{"begun", id}})); }
void AttemptLog::finished(const PointOutcome& outcome) { append(outcome_line(outcome)); }
void AttemptLog::warning(const std::string& text) { append(json_line({{"warning", text}})); }
void AttemptLog::unfit(const std::string& sentence, int exit_code) {
  append(json_line({{"unfit", sentence}, {"code", exit_code}}));
}

AttemptNews AttemptReader::read() {
  AttemptNews news;
  std::error_code ignored;
  std::map<std::pair<std::size_t, std::size_t>, fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
    std::size_t shard = 0, number = 0;
    int end = 0;
    const std::string name = entry.path().filename().string();
    if (std::sscanf(name.c_str(), "shard-%zu.attempt-%zu.jsonl%n", &shard, &number, &end) == 2 &&
        static_cast<std::size_t>(end) == name.size())
      found[{shard, number}] = entry.path();
  }
  for (const auto& [key, path] : found) read(path, &files_[key], &news);
  return news;
}

void AttemptReader::read(const fs::path& path, File* file, AttemptNews* news) {
  try {
    check_readable(path, {.kind = FileKind::table, .what = "log of an attempt"});
  } catch (const UserError& error) {  // a share may be away for a moment: the next look finds what is there
    news->warnings.push_back(error.what());
    return;
  }
  std::ifstream in(path, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(file->offset));
  for (std::string line; std::getline(in, line) && !in.eof();) {
    file->offset += line.size() + 1;
    ++file->lines;
    const auto leave_out = [&] {
      if (news->warnings.size() < kMostBadLines)
        news->warnings.push_back(
            fmt::format("{}:{}: is no line that a task writes; it is left out", path.string(), file->lines));
    };
    try {
      const auto json = parse_json<report::Json>(line);
      if (json.contains("attempt")) {
        file->head = {json["attempt"], json.at("host"), json.at("version"),
                      whole_number<int>(json.at("restart"))};
      } else if (json.contains("begun")) {
        file->in_progress.insert(whole_number<std::int64_t>(json["begun"]));
      } else if (json.contains("warning")) {
        news->warnings.push_back(json["warning"]);
      } else if (json.contains("unfit")) {
        const int code = whole_number<int>(json.at("code"));
        if (code < 1 || code > kLastExitCode) throw std::out_of_range("an exit code");
        news->unfit = {file->head.host, json["unfit"], code};
      } else {
        PointOutcome outcome = outcome_of(json);  // throws for what is none
        outcome.host = file->head.host;
        outcome.version = file->head.version;
        file->in_progress.erase(outcome.id);
        news->outcomes.push_back(std::move(outcome));
      }
    } catch (const report::Json::exception&) {
      leave_out();
    } catch (const std::out_of_range&) {
      leave_out();
    }
  }
}

std::map<std::int64_t, std::size_t> AttemptReader::broken_off() const {
  std::map<std::size_t, const File*> last;
  for (const auto& [key, file] : files_) last[key.first] = &file;  // in the order of the attempts
  std::map<std::int64_t, std::size_t> out;
  for (const auto& [shard, file] : last)
    for (const std::int64_t id : file->in_progress) out[id] = shard;
  return out;
}

}  // namespace fringetwin::study
