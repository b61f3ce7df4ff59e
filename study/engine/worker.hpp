// SPDX-License-Identifier: Apache-2.0
// A process that runs points for another one: lines of JSON in and out. A crash takes one point along, not
// the study.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "study/run/point_runner.hpp"

namespace fringetwin::study {

/// What a worker says: it is ready, it cannot work at all, or what became of a point.
struct WorkerAnswer {
  enum class Kind { ready, unfit, outcome };
  Kind kind = Kind::ready;
  std::string text;   ///< ready: the device; unfit: the sentence
  int exit_code = 0;  ///< unfit
  PointOutcome outcome;
};

struct WorkerTask {
  PointTask task;
  std::string device;  ///< a part of a Vulkan device's name
};

// Each of these makes or reads one line, without its end. What reads them throws nlohmann's exceptions, and
// parse_point() std::out_of_range.
std::string task_line(const PointTask& task, const std::string& device);
WorkerTask parse_task(const std::string& line);
std::string point_line(const PlannedPoint& planned);
PlannedPoint parse_point(const std::string& line);
std::string outcome_line(const PointOutcome& outcome);
WorkerAnswer parse_answer(const std::string& line);
/// Returns the outcome whose line this was before it was parsed.
PointOutcome outcome_of(const nlohmann::ordered_json& line);

/// Is the worker: reads the task, then points from stdin, and writes answers to stdout, until stdin ends.
/// Ends with the process that started it.
int run_worker();

}  // namespace fringetwin::study
