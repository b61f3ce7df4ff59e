// SPDX-License-Identifier: Apache-2.0
#include "study/slurm/slurm_batch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <random>
#include <stdexcept>

#include "report/json.hpp"
#include "twin/base/safe_file.hpp"
#include "twin/base/time_and_host.hpp"
#include "twin/file/json_values.hpp"
#include "twin/image/image_io.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::study {
namespace fs = std::filesystem;
namespace {

constexpr const char* kRoundSchema = "fringetwin-slurm-round/1";
/// No comma: scancel takes names that are joined by it for several jobs.
constexpr const char* kJobNameLetters = "abcdefghijklmnopqrstuvwxyz0123456789-";

/// Returns what `take` makes of the JSON in a file; nullopt when there is no such file. Throws
/// UserError(input) for JSON that is broken or too much (docs/FORMATS.md, "Limits") and for values of the
/// wrong type.
template <class Take>
auto from_json(const fs::path& file, const std::string& hint, const Take& take)
    -> std::optional<decltype(take(report::Json()))> {
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  const std::string text = read_whole_text(file, {.what = "file of a Slurm job"});
  std::string why;
  try {
    return take(parse_json<report::Json>(text));
  } catch (const report::Json::exception&) {
  } catch (const std::out_of_range& excess) {
    why = fmt::format(" ({})", excess.what());
  }
  throw UserError(ExitCode::input, file.string(), "is damaged" + why, hint);
}

/// Returns whether a point can have caused a task to end in this state of Slurm. NODE_FAIL, PREEMPTED,
/// CANCELLED and unknown states say nothing about a point.
bool a_point_can_cause(const std::string& state) {
  return state.starts_with("FAILED") || state.starts_with("OUT_OF_MEMORY") || state.starts_with("TIMEOUT");
}

/// A folder that goes when the scope ends, however it ends.
struct RemovedAtEnd {
  fs::path folder;
  ~RemovedAtEnd() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
};

std::string random_digits() {
  std::random_device random;
  return fmt::format("{:08x}{:04x}", random(), random() & 0xffffU);
}

}  // namespace

SlurmRound SlurmRound::read(const fs::path& folder) {
  const std::string remove_all = fmt::format("end its job with scancel, remove {} and run the study again",
                                             folder.parent_path().string());
  const auto begun = from_json(folder / "round.json", remove_all, [&](const report::Json& head) {
    SlurmRound round{folder, "", ""};
    if (head.value("schema", "") != kRoundSchema) return round;
    round.job_name = head.at("job_name");
    round.version = head.at("version");
    return round;
  });
  if (!begun || begun->job_name.empty() ||
      begun->job_name.find_first_not_of(kJobNameLetters) != std::string::npos)
    throw UserError(ExitCode::input, (folder / "round.json").string(), "is no round of this program",
                    "it must lie on a disk that the nodes share under the same path");
  const auto ended =
      from_json(folder / "ended.json", "remove it and run the study again", [&](const report::Json& end) {
        SlurmRound round = *begun;
        round.ended = true;
        round.cancelled = end.value("cancelled", false);
        if (!end.contains("tasks")) return round;
        for (const auto& [key, state] : end["tasks"].get_ref<const report::Json::object_t&>()) {
          const auto task = parse_number<std::size_t>(key);
          if (!task) throw std::out_of_range("a task has no number");
          round.states[*task] = state;
        }
        return round;
      });
  return ended ? *ended : *begun;
}

void SlurmRound::end(bool was_cancelled, std::map<std::size_t, std::string> last_states) {
  if (ended) return;
  ended = true;
  cancelled = was_cancelled;
  states = std::move(last_states);
  report::Json json = {{"cancelled", cancelled}, {"ended_at", utc_now()}, {"tasks", report::Json::object()}};
  for (const auto& [task, state] : states) json["tasks"][std::to_string(task)] = state;
  write_text_file(folder / "ended.json", json.dump(2) + "\n");
}

std::string SlurmRound::last_words(std::size_t task) const {
  const fs::path log = folder / fmt::format("task-{}.log", task);
  try {
    check_readable(log, {.kind = FileKind::mesh, .what = "log"});  // what a program printed, of any length
  } catch (const UserError&) {
    return "";
  }
  std::ifstream in(log, std::ios::binary);
  constexpr std::streamoff kEnd = 1 << 16;
  in.seekg(0, std::ios::end);
  in.seekg(std::max<std::streamoff>(0, in.tellg() - kEnd));
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

std::string SlurmRound::fate() const {
  std::map<std::string, std::size_t> counts;
  std::string words;
  for (const auto& [task, state] : states) {
    if (state.starts_with("COMPLETED")) continue;
    ++counts[state];
    if (words.empty() && !last_words(task).empty())
      words = fmt::format("; the log of task {} ends: {}", task, last_words(task));
  }
  std::string text;
  for (const auto& [state, n] : counts)
    text += fmt::format("{}{} task{} {}", text.empty() ? "" : ", ", n, n == 1 ? "" : "s", state);
  return (text.empty() ? "Slurm does not say why" : text) + words;
}

SlurmBatch::SlurmBatch(fs::path folder) : folder_(std::move(folder)) { take_up_new_rounds(); }

void SlurmBatch::take_up_new_rounds() {
  for (;;) {
    const fs::path next = folder_ / fmt::format("round-{}", rounds_.size());
    if (!fs::is_directory(next)) return;
    rounds_.push_back(std::make_unique<Entry>(Entry{SlurmRound::read(next), AttemptReader(next)}));
  }
}

bool SlurmBatch::begin_round(const WorkerTask& task, const std::vector<std::vector<PlannedPoint>>& shards,
                             const std::string& version) {
  const std::string name = random_digits();
  const fs::path unfinished = folder_ / ("unfinished-" + name);
  const RemovedAtEnd what_is_left{unfinished};  // nothing, once it has its name
  fs::create_directories(unfinished);
  std::size_t points = 0;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    write_shard(unfinished, i, {task, shards[i]});
    points += shards[i].size();
  }
  const report::Json head = {{"schema", kRoundSchema}, {"job_name", "fringetwin-" + name},
                             {"version", version},     {"shards", shards.size()},
                             {"points", points},       {"made_at", utc_now()},
                             {"made_on", host_name()}};
  write_text_file(unfinished / "round.json", head.dump(2) + "\n");
  std::error_code error;
  fs::rename(unfinished, folder_ / fmt::format("round-{}", rounds_.size()), error);
  const std::size_t before = rounds_.size();
  take_up_new_rounds();
  if (error && rounds_.size() == before)
    throw UserError(ExitCode::input, folder_.string(),
                    fmt::format("cannot be written ({})", error.message()));
  return !error;
}

void SlurmBatch::drop_round() {
  fs::remove_all(rounds_.back()->round.folder);
  rounds_.pop_back();
}

AttemptNews SlurmBatch::read() {
  AttemptNews all;
  for (const auto& entry : rounds_) {
    AttemptNews news = entry->attempts.read();
    for (PointOutcome& o : news.outcomes) all.outcomes.push_back(std::move(o));
    for (std::string& w : news.warnings) all.warnings.push_back(std::move(w));
    all.unfit = std::move(news.unfit);
  }
  return all;
}

SlurmBatch::Deaths SlurmBatch::deaths() const {
  Deaths out;
  for (const auto& entry : rounds_) {
    const SlurmRound& round = entry->round;
    if (!round.ended || round.cancelled) continue;
    for (const auto& [id, shard] : entry->attempts.broken_off()) {
      const auto state = round.states.find(shard);
      if (state == round.states.end() || !a_point_can_cause(state->second)) continue;
      Death& death = out[id];
      ++death.times;
      death.alone = has_one_point(round.folder, shard);
      const std::string words = round.last_words(shard);
      death.last =
          fmt::format("its task ended {}{}", state->second, words.empty() ? "" : "; its log ends: " + words);
    }
  }
  return out;
}

std::set<std::int64_t> most_often_dead(const SlurmBatch::Deaths& deaths,
                                       const std::vector<PlannedPoint>& points, std::size_t most) {
  std::vector<std::pair<int, std::int64_t>> dead;  // times, negative: the most come first
  for (const PlannedPoint& p : points)
    if (const auto death = deaths.find(p.point.id); death != deaths.end())
      dead.emplace_back(-death->second.times, p.point.id);
  std::ranges::sort(dead);
  std::set<std::int64_t> out;
  for (std::size_t i = 0; i < std::min(most, dead.size()); ++i) out.insert(dead[i].second);
  return out;
}

}  // namespace fringetwin::study
