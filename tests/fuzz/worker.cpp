// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/worker.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <omp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <new>
#include <stdexcept>
#include <thread>

#include "tests/fuzz/coverage.hpp"
#include "tests/fuzz/mutate.hpp"
#include "twin/base/not_copyable.hpp"
#include "twin/base/progress.hpp"
#include "twin/base/sha256.hpp"

#if defined(__SANITIZE_ADDRESS__)
// A single allocation beyond the promise is a fault; freed memory is not kept for long, it would count as
// used.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "detect_leaks=0:max_allocation_size_mb=2048:quarantine_size_mb=32:handle_abort=0:exitcode=99";
}
#endif

namespace fringetwin::fuzz {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kLook = std::chrono::milliseconds(20);  ///< between two looks of the supervisor
constexpr off_t kLongestLog = 1 << 20;
constexpr int kLeastChanges = 50;     ///< also where the seeds take all the time
constexpr double kLongestWall = 3.0;  ///< times the seconds of computing

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// What the process tells its supervisor; it is there after the process has died.
struct Shared {
  std::atomic<std::size_t> runs = 0, kept = 0, size = 0;
  std::atomic<bool> reading = false;
  std::array<char, kLargestInput + 4096> input{};
};

/// Memory of two processes.
class SharedMemory : NotCopyable {
 public:
  SharedMemory() {
    void* memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no memory to share");
    shared_ = new (memory) Shared;
  }
  ~SharedMemory() { ::munmap(shared_, sizeof(Shared)); }
  Shared* operator->() const { return shared_; }
  Shared& operator*() const { return *shared_; }

 private:
  Shared* shared_ = nullptr;
};

// ---- in the process

double computing_seconds(pid_t process) {
  clockid_t clock{};
  timespec time{};
  if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &time) != 0) return 0.0;
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::size_t largest_memory_so_far() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

class Fuzzer {
 public:
  Fuzzer(const WorkerPlan& plan, Shared& shared)
      : plan_(plan), shared_(shared), random_(plan.seed), start_(Clock::now()) {}

  void run() {
    if (plan_.replayed) return read(*plan_.replayed);
    corpus_ = seeds_of(*plan_.target);
    if (!plan_.corpus.empty()) {
      const std::set<fs::path> files{fs::directory_iterator(plan_.corpus), fs::directory_iterator()};
      for (const fs::path& file : files) corpus_.push_back(get_file(file));
    }
    expect_good(corpus_.front());
    std::erase_if(corpus_, [&](const std::string& input) { return plan_.known.contains(input); });
    for (std::size_t i = 0; i < corpus_.size() && !is_over(); ++i) {
      read(corpus_[i]);
      found_new_code();
    }
    for (int n = 0; n < kLeastChanges || !is_over(); ++n) {
      const std::string input = changed();
      read(input);
      if (found_new_code()) keep(input);
    }
  }

 private:
  /// Of computing, so that other work on the machine leaves no fewer changes; with an end for what waits.
  bool is_over() const {
    return computing_seconds(::getpid()) >= plan_.seconds || since(start_) >= kLongestWall * plan_.seconds;
  }

  /// An input of the corpus after one to six changes, more often few.
  std::string changed() {
    std::string input = random_.of(corpus_);
    std::size_t changes = 1;
    while (changes < 6 && random_.one_in(2)) ++changes;
    for (; changes > 0; --changes) input = change(input);
    return input;
  }

  std::string change(const std::string& input) {
    const Target& target = *plan_.target;
    if (target.mutate && random_.one_in(2)) return target.mutate(input, random_);
    switch (random_.below(8)) {
      case 0:
        return splice(input, random_.of(corpus_), random_);
      case 1:
      case 2:
        return insert_word(input, target.words, random_);
      default:
        return mutate_bytes(input, random_);
    }
  }

  /// A target that refuses even this one would find nothing.
  void expect_good(const std::string& input) const {
    try {
      plan_.target->read(input);
    } catch (const UserError& error) {
      throw std::runtime_error(std::string("a good input is refused: ") + error.what());
    }
  }

  void read(const std::string& whole) {
    const std::string input = whole.substr(0, shared_.input.size());
    std::memcpy(shared_.input.data(), input.data(), input.size());
    shared_.size = input.size();
    ++shared_.runs;
    if (shared_.runs % 256 == 0 && ::lseek(STDERR_FILENO, 0, SEEK_END) > kLongestLog)
      (void)!::ftruncate(STDERR_FILENO, 0);
    begin_coverage();
    shared_.reading = true;
    read_checked(*plan_.target, input);
    shared_.reading = false;
    if (largest_memory_so_far() > kLargestMemory) {
      fmt::print(stderr, "\nfinding: {} MB of memory\n", largest_memory_so_far() >> 20);
      std::_Exit(98);
    }
  }

  void keep(const std::string& input) {
    ++shared_.kept;
    corpus_.push_back(input);
    if (!plan_.corpus.empty()) {
      const fs::path file = plan_.corpus / sha256_of_text(input).substr(0, 16),
                     unfinished = file.string() + ".new";
      FILE* out = std::fopen(unfinished.c_str(), "wb");
      if (!out) return;
      std::fwrite(input.data(), 1, input.size(), out);
      std::fclose(out);
      fs::rename(unfinished, file);
    }
  }

  const WorkerPlan& plan_;
  Shared& shared_;
  Random random_;
  Clock::time_point start_;
  std::vector<std::string> corpus_;
};

/// Never returns: what the parent process has open stays as it is.
[[noreturn]] void be_worker(const WorkerPlan& plan, Shared& shared, const fs::path& log) {
  const int fd = ::open(log.c_str(), O_RDWR | O_APPEND | O_CREAT | O_TRUNC, 0600);
  ::dup2(fd, STDERR_FILENO);
  ::dup2(::open("/dev/null", O_RDWR), STDOUT_FILENO);
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  set_quiet(true);
  ::omp_set_num_threads(1);  // the other cores have targets of their own
  int status = 0;
  try {
    Fuzzer(plan, shared).run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "\nthe fuzzer itself: {}\n", error.what());
    status = 97;
  }
  std::_Exit(status);
}

// ---- in the supervisor

std::size_t memory_of(pid_t process) {
  std::size_t all = 0, resident = 0;
  if (FILE* file = std::fopen(fmt::format("/proc/{}/statm", process).c_str(), "r")) {
    if (std::fscanf(file, "%zu %zu", &all, &resident) != 2) resident = 0;
    std::fclose(file);
  }
  return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

std::string fault_of(int status, const std::string& log) {
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (const auto at = log.rfind("\nfinding: "); at != std::string::npos)
    return log.substr(at + 10, log.find('\n', at + 10) - at - 10);
  for (const char* mark : {"runtime error: ", "ERROR: AddressSanitizer: ", "the fuzzer itself: "})
    if (const auto at = log.rfind(mark); at != std::string::npos)
      return log.substr(at, std::min(log.find('\n', at), log.size()) - at);
  return WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status))
                             : fmt::format("exit status {}", WEXITSTATUS(status));
}

/// Kills the process when one input takes too long or too much; returns why, empty where it ended by itself.
std::string watch(pid_t process, const Shared& shared, int* status, bool* too_long) {
  std::size_t runs = 0;
  double computed = 0.0;
  Clock::time_point begun = Clock::now();
  while (::waitpid(process, status, WNOHANG) == 0) {
    if (shared.runs != runs || !shared.reading) {
      runs = shared.runs;
      computed = computing_seconds(process);
      begun = Clock::now();
    }
    std::string fault;
    if (computing_seconds(process) - computed > kLongestSeconds)
      fault = fmt::format("more than {} s of computing", kLongestSeconds);
    *too_long = !fault.empty();
    if (since(begun) > kLongestWait) fault = fmt::format("no end after {} s", kLongestWait);
    if (memory_of(process) > kLargestMemory)
      fault = fmt::format("more than {} MB of memory", kLargestMemory >> 20), *too_long = false;
    if (!fault.empty() || cancelled()) {
      ::kill(process, SIGKILL);
      ::waitpid(process, status, 0);
      if (fault.empty()) *status = 0;  // the user ended it
      return fault;
    }
    std::this_thread::sleep_for(kLook);
  }
  return "";
}

}  // namespace

WorkerEnd run_worker(const WorkerPlan& plan) {
  const SharedMemory shared;
  work_folder();  // made here: removed also when the process dies
  const fs::path log = work_folder() / "log";
  const Clock::time_point start = Clock::now();
  const pid_t process = ::fork();
  if (process < 0) throw std::runtime_error("no further process can be started");
  if (process == 0) be_worker(plan, *shared, log);
  int status = 0;
  WorkerEnd end;
  end.fault = watch(process, *shared, &status, &end.too_long);
  end.log = get_file(log);
  if (end.fault.empty()) end.fault = fault_of(status, end.log);
  end.runs = shared->runs;
  end.kept = shared->kept;
  end.seconds = since(start);
  if (!end.fault.empty()) end.input.assign(shared->input.data(), shared->size);
  remove_work_folder();
  return end;
}

}  // namespace fringetwin::fuzz
