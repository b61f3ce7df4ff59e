// SPDX-License-Identifier: Apache-2.0
// Starts a worker process, sends it lines, takes its answers, and notices its end.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

#include "twin/base/not_copyable.hpp"

namespace fringetwin::study {

class WorkerProcess : NotCopyable {
 public:
  /// `environment`: "NAME=value", over that of this process. Throws UserError(device) when the system
  /// gives no process.
  WorkerProcess(const std::vector<std::string>& command, const std::vector<std::string>& environment);
  /// Kills it if it is there.
  ~WorkerProcess();

  /// To be polled for reading.
  int answers_fd() const { return talk_; }
  int errors_fd() const { return errors_; }

  /// False when it is gone.
  bool send(const std::string& line);
  /// No more lines will be sent: it ends by itself.
  void stop();
  /// Whole lines that came; *ended once there will be no more.
  std::vector<std::string> answers(bool* ended);
  std::vector<std::string> errors();

  /// After the end of the answers: waits, and says how it ended, e.g. "was killed by signal 11
  /// (Segmentation fault)".
  std::string end();

 private:
  pid_t pid_ = -1;
  int talk_ = -1, errors_ = -1;
  std::string answers_buffer_, errors_buffer_;
};

}  // namespace fringetwin::study
