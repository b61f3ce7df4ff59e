// SPDX-License-Identifier: Apache-2.0
// A Slurm of one node with two cores, with its own key, configuration, ports and folder: Debian's daemons,
// run as this user, gone with this process however it ends.
#pragma once
#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>

namespace fringetwin::testing {

class SlurmCluster {
 public:
  /// Throws std::runtime_error with what is missing or what the daemons say.
  explicit SlurmCluster(std::filesystem::path folder);
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// Returns the file that SLURM_CONF must name.
  std::filesystem::path configuration() const { return folder_ / "slurm.conf"; }
  /// Returns the same with a controller's port at which nobody listens.
  std::filesystem::path dead_configuration() const { return folder_ / "dead.conf"; }
  /// Output of one of Slurm's commands, in a shell.
  std::string command(const std::string& line) const;

 private:
  void write_configuration();
  void stop();
  std::filesystem::path folder_;
  pid_t keeper_ = -1;
  int lifeline_ = -1;
};

}  // namespace fringetwin::testing
