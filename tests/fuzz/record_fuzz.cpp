// SPDX-License-Identifier: Apache-2.0
// What the program itself writes and reads again: journals, results, calibrations, the shards and the
// database of a study.
#include "capture/record/journal.hpp"
#include "compare/diff.hpp"
#include "compare/verdict/calibration_covariance.hpp"
#include "study/slurm/attempt_log.hpp"
#include "study/slurm/shard.hpp"
#include "study/store/study_store.hpp"
#include "tests/fuzz/mutate.hpp"
#include "tests/fuzz/target.hpp"

namespace fringetwin::fuzz {
namespace {
namespace fs = std::filesystem;

void read_journal(const std::string& input) {
  put_file(capture::kJournalName, input);
  capture::Journal::resume(work_folder(), capture::Journal::identity(work_folder()));
}

void read_result(const std::string& input) {
  const fs::path file = put_file("input.json", input);
  read_or_refuse([&] { compare::diff_results(file, work_folder() / "result.json"); });
  compare::diff_results(file, file);
}

void read_calibration(const std::string& input) {
  static const Twin good = load_twin(work_folder() / "twin.toml");
  Twin twin = good;
  twin.calibration_uncertainty = put_file("input.json", input);
  const compare::CalibrationCovariance covariance = compare::read_calibration_covariance(twin);
  const Eigen::MatrixXd changes = compare::one_sigma_changes(covariance.matrix);
  if (changes.cols() > 0) compare::with_rig_change(twin, covariance, changes.col(0));
}

void read_shard_file(const std::string& input) {
  put_file("shard-0.jsonl", input);
  put_file("shard-0.attempt-0.jsonl", input);
  read_or_refuse([] { study::has_one_point(work_folder(), 0); });
  read_or_refuse([] {
    study::AttemptReader attempts(work_folder());
    attempts.read();
    attempts.broken_off();
  });
  study::read_shard(work_folder(), 0);
}

std::vector<std::string> shard_files() {
  study::PlannedPoint point;
  point.point = {3, {{"object.part.radius_mm", "19"}}, 7};
  point.keys = {"trace 1", "form 1"};
  point.demand = {{{12, 0.1}}, 0.5, 1.0 / 3.0};
  const study::WorkerTask task{
      {"twin.toml", {{.result = "fits.part.measured.radius_mm", .name = "radius_mm"}}}, ""};
  study::write_shard(work_folder(), 0, {task, {point, point}});
  {
    study::AttemptLog log(work_folder(), 0, {"12_3", "node7", "1.0", 0});
    log.begun(3);
    log.finished({3, false, "", {{"radius_mm", 19.0}}, 0.5, true});
    log.warning("a warning");
    log.begun(4);
  }
  std::vector<std::string> files = {get_file(work_folder() / "shard-0.jsonl"),
                                    get_file(work_folder() / "shard-0.attempt-0.jsonl")};
  fs::remove(work_folder() / "shard-0.attempt-0.jsonl");
  return files;
}

const study::StudyIdentity kStudy{"design = grid\n", {{"twin.toml", "aa"}}};

void remove_store(const fs::path& file) {
  for (const char* end : {"", "-wal", "-shm", "-journal"}) fs::remove(file.string() + end);
}

void read_store(const std::string& input) {
  const fs::path file = work_folder() / "input.db";
  remove_store(file);
  put_file("input.db", input);
  study::StudyStore store(file, kStudy, "1.0");
  store.add({{0, {{"object.part.radius_mm", "19"}}, 0}, {9, {{"object.part.radius_mm", "20"}}, 1}});
  store.pending();
  store.counts();
  study::study_csv(store.rows());
}

std::vector<std::string> stores() {
  const fs::path file = work_folder() / "seed.db";
  remove_store(file);
  {
    study::StudyStore store(file, kStudy, "1.0");
    store.add({{0, {{"object.part.radius_mm", "19"}}, 0}, {1, {{"object.part.radius_mm", "20"}}, 1}});
    store.record({{0, false, "", {{"radius_mm", 19.01}}, 0.5, true}});
  }
  return {get_file(file)};
}

}  // namespace

extern const Target journal_target, result_json_target, calibration_json_target, shard_target,
    study_store_target;

const Target journal_target = {"journal",
                               read_journal,
                               {"good/capture.journal", "journal"},
                               nullptr,
                               mutate_text,
                               {"\"identity\":", "\"schema\":\"fringetwin-capture-journal/1\"", "\"step\":0",
                                "\"frames\":[]", "\n", "{}", "[", "null"}};

const Target result_json_target = {
    "result_json",
    read_result,
    {"good/result.json", "result_json"},
    nullptr,
    mutate_text,
    {"\"schema\": \"fringetwin-result/1\"", "\"fits\": ", "\"gain\": ", "\"phase\": ", "\"coverage\": ",
     "\"verdict\": ", "\"object\": ", "\"camera\": ", "\"explained\": ", "\"provenance\": ",
     "\"inputs_sha256\": ", "[", "]", "{", "}", "null", "1e999", "\\u0000", "\\ud800"}};

const Target calibration_json_target = {
    "calibration_json",
    read_calibration,
    {"good/calibration.json", "calibration_json"},
    nullptr,
    mutate_text,
    {"\"parameters\": ", "\"matrix\": ", "\"covariance\": ", "\"devices\": ", "\"left.fx\"",
     "\"projector.t3\"", "\"left.k4\"", "[[1e308]]", "1e999"}};

const Target shard_target = {
    "shard",
    read_shard_file,
    {"shard"},
    shard_files,
    mutate_text,
    {"\"id\":", "\"begun\":", "\"numbers\":{}", "\"settings\":{}", "\"records\":[]", "\n", "null", "1e999"}};

const Target study_store_target = {"study_store",   read_store,
                                   {"study_store"}, stores,
                                   nullptr,         {"CREATE TABLE", "SQLite format 3", "points", "{}"}};

}  // namespace fringetwin::fuzz
