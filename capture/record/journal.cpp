// SPDX-License-Identifier: Apache-2.0
#include "capture/record/journal.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "twin/base/errors.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/file/json_values.hpp"
#include "twin/image/image_io.hpp"

namespace fringetwin::capture {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::json;
constexpr const char* kJournalSchema = "fringetwin-capture-journal/1";
const FileUse kJournalUse{.kind = FileKind::table, .what = "journal"};

Json to_json(const StepRecord& record) {
  Json frames = Json::array();
  for (const FrameRecord& f : record.frames)
    frames.push_back({f.camera, f.sequence, f.timestamp_ns, f.flags, f.use, f.shown.at_ns, f.shown.sequence,
                      f.shown.timed});
  return {{"step", record.step},
          {"pattern", record.pattern},
          {"shown", {record.shown.at_ns, record.shown.sequence, record.shown.timed}},
          {"sha256", record.sha256},
          {"frames", frames},
          {"lost", record.lost_frames},
          {"repeated", record.repeated_frames},
          {"corrupt", record.corrupt_frames},
          {"attempts", record.attempts},
          {"skew_ms", record.skew_ms}};
}

StepRecord from_json(const Json& json) {
  StepRecord record;
  record.step = whole_number<int>(json.at("step"));
  json.at("pattern").get_to(record.pattern);
  const Json& shown = json.at("shown");
  record.shown = {whole_number<TimeNs>(shown.at(0)), whole_number<std::uint64_t>(shown.at(1)),
                  shown.at(2).get<bool>()};
  json.at("sha256").get_to(record.sha256);
  for (const Json& f : json.at("frames"))
    record.frames.push_back(
        {f.at(0).get<std::string>(),
         whole_number<std::uint32_t>(f.at(1)),
         whole_number<TimeNs>(f.at(2)),
         whole_number<std::uint32_t>(f.at(3)),
         f.at(4).get<std::string>(),
         {whole_number<TimeNs>(f.at(5)), whole_number<std::uint64_t>(f.at(6)), f.at(7).get<bool>()}});
  record.lost_frames = whole_number<std::uint32_t>(json.at("lost"));
  record.repeated_frames = whole_number<int>(json.at("repeated"));
  record.corrupt_frames = whole_number<int>(json.at("corrupt"));
  record.attempts = whole_number<int>(json.at("attempts"));
  json.at("skew_ms").get_to(record.skew_ms);
  return record;
}

[[noreturn]] void damaged(const fs::path& file, int line) {
  throw UserError(ExitCode::input, fmt::format("{}:{}", file.string(), line), "is damaged",
                  "begin anew in another folder, or with --overwrite");
}

void check_identity(const fs::path& file, const Json& header,
                    const std::map<std::string, std::string>& identity) {
  const auto begun = header.at("identity").get<std::map<std::string, std::string>>();
  for (const auto& [key, value] : identity) {
    const auto it = begun.find(key);
    const std::string before = it == begun.end() ? "nothing" : it->second;
    if (before != value)
      throw UserError(ExitCode::usage, file.string(),
                      fmt::format("the recording was begun with {} = {}, now it is {}", key, before, value),
                      "resume with the options it was begun with");
  }
  for (const auto& [key, before] : begun)
    if (!identity.contains(key))
      throw UserError(ExitCode::usage, file.string(),
                      fmt::format("the recording was begun with {} = {}, now it is nothing", key, before),
                      "resume with the twin and the options it was begun with");
}

void write_all(int file, const std::string& text, const fs::path& name) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = ::write(file, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0)
      throw UserError(ExitCode::device, name.string(),
                      fmt::format("cannot be written ({})", std::strerror(errno)),
                      "make room and go on with --resume");
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

Journal Journal::begin(const fs::path& dir, const std::map<std::string, std::string>& identity) {
  Journal journal(dir / kJournalName);
  write_text_file(journal.file_, Json{{"schema", kJournalSchema}, {"identity", identity}}.dump() + "\n");
  return journal;
}

Journal Journal::resume(const fs::path& dir, const std::map<std::string, std::string>& identity) {
  Journal journal(dir / kJournalName);
  if (std::error_code error; !fs::exists(journal.file_, error))
    throw UserError(ExitCode::input, journal.file_.string(), "no such file, so there is nothing to resume",
                    "record without --resume");
  std::istringstream stream(read_whole_text(journal.file_, kJournalUse));
  std::string line;
  std::uintmax_t good_bytes = 0;
  for (int number = 1; std::getline(stream, line); ++number) {
    const bool whole = !stream.eof();  // else there was no newline at its end
    if (!whole && number > 1) break;
    try {
      const Json json = parse_json<Json>(line);
      if (number == 1) {
        if (!whole || json.at("schema") != kJournalSchema) damaged(journal.file_, 1);
        check_identity(journal.file_, json, identity);
      } else {
        journal.records_.push_back(from_json(json));
      }
    } catch (const Json::exception&) {
      damaged(journal.file_, number);
    } catch (const std::out_of_range&) {
      damaged(journal.file_, number);
    }
    good_bytes += line.size() + 1;
  }
  if (good_bytes == 0) damaged(journal.file_, 1);
  fs::resize_file(journal.file_, good_bytes);
  return journal;
}

std::map<std::string, std::string> Journal::identity(const fs::path& dir) {
  const fs::path file = dir / kJournalName;
  if (std::error_code error; !fs::exists(file, error)) return {};
  const std::string text = read_whole_text(file, kJournalUse);
  if (text.empty()) return {};
  try {
    const Json header = parse_json<Json>(text.substr(0, text.find('\n')));
    return header.at("identity").get<std::map<std::string, std::string>>();
  } catch (const Json::exception&) {
    damaged(file, 1);
  } catch (const std::out_of_range&) {
    damaged(file, 1);
  }
}

void Journal::append(const StepRecord& record) {
  const int file = ::open(file_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
  if (file < 0)
    throw UserError(ExitCode::device, file_.string(),
                    fmt::format("cannot be opened ({})", std::strerror(errno)));
  try {
    write_all(file, to_json(record).dump() + "\n", file_);
    if (::fdatasync(file) != 0)
      throw UserError(ExitCode::device, file_.string(),
                      fmt::format("cannot be brought to the disk ({})", std::strerror(errno)));
  } catch (...) {
    ::close(file);
    throw;
  }
  ::close(file);
  records_.push_back(record);
}

void Journal::remove() {
  std::error_code ignored;
  fs::remove(file_, ignored);
}

}  // namespace fringetwin::capture
