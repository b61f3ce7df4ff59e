// SPDX-License-Identifier: Apache-2.0
#include "study/engine/worker.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <iostream>
#include <stdexcept>

#include "report/json.hpp"
#include "twin/base/constants.hpp"
#include "twin/base/errors.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/out_of_memory.hpp"
#include "twin/base/progress.hpp"
#include "twin/file/json_values.hpp"

namespace fringetwin::study {
namespace {

using report::Json, report::json_line;

// The answers go to what was stdout; anything a library prints must not come between them.
class Answers : NotCopyable {
 public:
  Answers() : fd_(dup(STDOUT_FILENO)) { dup2(STDERR_FILENO, STDOUT_FILENO); }
  ~Answers() { close(fd_); }
  void send(std::string line) const {
    line += '\n';
    for (std::size_t sent = 0; sent < line.size();) {
      const ssize_t n = write(fd_, line.data() + sent, line.size() - sent);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) _exit(static_cast<int>(ExitCode::internal));  // nobody is there to be told
      sent += static_cast<std::size_t>(n);
    }
  }

 private:
  int fd_;
};

/// Returns a number that the twin's own file can say (docs/FORMATS.md); throws std::out_of_range for others.
double within(const Json& value, double low, double high) {
  const double number = value.get<double>();
  if (!(number >= low && number <= high)) throw std::out_of_range("a number of a point");
  return number;
}

}  // namespace

std::string task_line(const PointTask& task, const std::string& device) {
  Json records = Json::array();
  for (const Record& r : task.records) records.push_back({r.result, r.name});
  return json_line({{"twin", task.twin.string()},
                    {"device", device},
                    {"records", records},
                    {"virtual_rig", task.virtual_rig},
                    {"calibration", task.calibration}});
}

WorkerTask parse_task(const std::string& line) {
  const Json json = parse_json<Json>(line);
  WorkerTask t{{json.at("twin").get<std::string>(), {}, json.at("virtual_rig"), json.at("calibration")},
               json.at("device")};
  for (const Json& r : json.at("records")) t.task.records.push_back({r.at(0), r.at(1)});
  return t;
}

std::string point_line(const PlannedPoint& p) {
  Json sensors = Json::array();
  for (const auto& s : p.demand.sensors) sensors.push_back(Json::array({s.bit_depth, s.gain_dn}));
  return json_line({{"id", p.point.id},
                    {"settings", p.point.settings},
                    {"seed", p.point.seed},
                    {"group", p.group},
                    {"trace", p.keys.trace},
                    {"form", p.keys.form},
                    {"sensors", sensors},
                    {"mean", p.demand.mean},
                    {"amplitude", p.demand.amplitude}});
}

PlannedPoint parse_point(const std::string& line) {
  const Json json = parse_json<Json>(line);
  PlannedPoint p{.point = {whole_number<std::int64_t>(json.at("id")), json.at("settings").get<Settings>(),
                           whole_number<std::uint64_t>(json.at("seed"))},
                 .group = whole_number<std::size_t>(json.at("group")),
                 .keys = {json.at("trace"), json.at("form")}};
  for (const Json& s : json.at("sensors"))
    p.demand.sensors.push_back({static_cast<int>(within(s.at(0), 8, 16)), within(s.at(1), 1e-9, 1e9)});
  p.demand.mean = within(json.at("mean"), 0.0, 1.0);
  p.demand.amplitude = within(json.at("amplitude"), 0.0, 1.0);
  return p;
}

std::string outcome_line(const PointOutcome& o) {
  return json_line({{"id", o.id},
                    {"failed", o.failed},
                    {"reason", o.reason},
                    {"numbers", o.numbers},  // what is not finite becomes null
                    {"seconds", o.seconds},
                    {"traced", o.traced},
                    {"gate_warnings", o.gate_warnings}});
}

PointOutcome outcome_of(const Json& line) {
  PointOutcome out{.id = whole_number<std::int64_t>(line.at("id")),
                   .failed = line.at("failed"),
                   .reason = line.at("reason")};
  for (const auto& item : line.at("numbers").items())
    out.numbers[item.key()] = item.value().is_null() ? kNaN : item.value().get<double>();
  out.seconds = line.at("seconds");
  out.traced = line.at("traced");
  if (line.contains("gate_warnings"))  // logs of attempts that an earlier version wrote have none
    out.gate_warnings = line.at("gate_warnings").get<std::vector<std::string>>();
  return out;
}

WorkerAnswer parse_answer(const std::string& line) {
  const Json json = parse_json<Json>(line);
  WorkerAnswer a;
  if (json.contains("ready")) {
    a.text = json["ready"];
  } else if (json.contains("unfit")) {
    a.kind = WorkerAnswer::Kind::unfit;
    a.text = json["unfit"];
    a.exit_code = whole_number<int>(json.at("code"));
  } else {
    a.kind = WorkerAnswer::Kind::outcome;
    a.outcome = outcome_of(json);
  }
  return a;
}

int run_worker() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // Where all processes of a job are told to go, the one that has the study decides: a worker that went first
  // would take its point along as a failed one.
  for (const int told_to_go : {SIGINT, SIGTERM, SIGHUP}) signal(told_to_go, SIG_IGN);
  set_quiet(true);
  const Answers answers;
  std::string line;
  if (!std::getline(std::cin, line)) return static_cast<int>(ExitCode::ok);
  WorkerTask task = parse_task(line);
  try {
    render::Renderer renderer(task.device);
    answers.send(json_line({{"ready", renderer.device().name}}));
    PointRunner runner(std::move(task.task), renderer);
    while (std::getline(std::cin, line)) answers.send(outcome_line(runner.run(parse_point(line))));
  } catch (const UserError& e) {
    answers.send(json_line({{"unfit", e.what()}, {"code", static_cast<int>(e.code())}}));
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    const char* whose = want_of_memory(e);
    if (!whose) throw;
    constexpr int kCode = static_cast<int>(ExitCode::input);
    const std::string sentence =
        std::string("not enough memory for a worker") + (*whose ? " (" + std::string(whose) + ")" : "");
    answers.send(json_line({{"unfit", sentence}, {"code", kCode}}));
    return kCode;
  }
  return static_cast<int>(ExitCode::ok);
}

}  // namespace fringetwin::study
