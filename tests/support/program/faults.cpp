// SPDX-License-Identifier: Apache-2.0
// LD_PRELOAD: one call that changes something below a folder fails, or the process dies before it.
//
// | variable    | what                                                                                   |
// |-------------|----------------------------------------------------------------------------------------|
// | FAULT_BELOW | the folder, absolute; calls on files elsewhere are left alone                          |
// | FAULT_CALLS | which calls count: some of open,write,rename,remove,mkdir,sync,close                   |
// | FAULT_AT    | the n-th of them fails, from 1                                                         |
// | FAULT_ERROR | its errno; "kill": the process dies instead                                            |
// | FAULT_LASTS | if set: all after it fail as well, as on a full disk                                   |
// | FAULT_COUNT | a file of 64 bytes, 8 counts for all processes: of the calls that count, then of each  |
// |             | kind in the order above; without it each process counts for itself                     |
// | FAULT_CLOCK | the clock of the day goes back by so many seconds at every look                        |
#undef _FORTIFY_SOURCE  // whose headers define open() themselves
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

using Count = std::atomic<long>;
constexpr std::array<const char*, 7> kCalls = {"open", "write", "rename", "remove", "mkdir", "sync", "close"};

struct Fault {
  std::string below = variable("FAULT_BELOW"), calls = "," + variable("FAULT_CALLS") + ",",
              error = variable("FAULT_ERROR");
  long at = std::atol(variable("FAULT_AT").c_str());
  bool lasts = std::getenv("FAULT_LASTS") != nullptr;
  std::array<Count, 1 + kCalls.size()> own{};
  Count* counts = own.data();

  Fault() {
    const std::string file = variable("FAULT_COUNT");
    if (file.empty()) return;
    const int fd = next<int(const char*, int, ...)>("open")(file.c_str(), O_RDWR | O_CLOEXEC);
    if (fd < 0) return;
    void* shared = ::mmap(nullptr, sizeof own, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    next<int(int)>("close")(fd);
    if (shared != MAP_FAILED) counts = static_cast<Count*>(shared);
  }
};

Fault& fault() {
  static Fault one;
  return one;
}

/// Returns true, with errno, where this call has to fail.
bool fails(const char* call, const char* path) {
  Fault& f = fault();
  if (f.below.empty() || path == nullptr) return false;
  if (std::strncmp(path, f.below.c_str(), f.below.size()) != 0) return false;
  for (std::size_t i = 0; i < kCalls.size(); ++i)
    if (std::strcmp(call, kCalls[i]) == 0) ++f.counts[i + 1];
  if (f.calls.find(std::string(",") + call + ",") == std::string::npos) return false;
  const long n = ++f.counts[0];
  if (f.at == 0 || n < f.at || (n > f.at && !f.lasts)) return false;
  if (f.error == "kill") ::kill(::getpid(), SIGKILL);
  errno = std::atoi(f.error.c_str());
  return true;
}

bool fails(const char* call, int file) {
  const int before = errno;
  char path[4096];
  const ssize_t n = ::readlink(("/proc/self/fd/" + std::to_string(file)).c_str(), path, sizeof path - 1);
  errno = before;
  if (n <= 0) return false;
  path[n] = '\0';
  return fails(call, path);
}

mode_t mode_of(int flags, va_list list) { return (flags & (O_CREAT | O_TMPFILE)) ? va_arg(list, mode_t) : 0; }

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return fails("open", path) ? -1 : next<int(const char*, int, ...)>("open")(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return fails("open", path) ? -1 : next<int(const char*, int, ...)>("open64")(path, flags, mode);
}

FILE* fopen(const char* path, const char* mode) {
  return fails("open", path) ? nullptr : next<FILE*(const char*, const char*)>("fopen")(path, mode);
}

FILE* fopen64(const char* path, const char* mode) {
  return fails("open", path) ? nullptr : next<FILE*(const char*, const char*)>("fopen64")(path, mode);
}

ssize_t write(int file, const void* data, size_t size) {
  return fails("write", file) ? -1 : next<ssize_t(int, const void*, size_t)>("write")(file, data, size);
}

ssize_t writev(int file, const iovec* parts, int n) {
  return fails("write", file) ? -1 : next<ssize_t(int, const iovec*, int)>("writev")(file, parts, n);
}

ssize_t pwrite(int file, const void* data, size_t size, off_t at) {
  return fails("write", file)
             ? -1
             : next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(file, data, size, at);
}

ssize_t pwrite64(int file, const void* data, size_t size, off64_t at) {
  return fails("write", file)
             ? -1
             : next<ssize_t(int, const void*, size_t, off64_t)>("pwrite64")(file, data, size, at);
}

size_t fwrite(const void* data, size_t size, size_t n, FILE* stream) {
  return fails("write", ::fileno(stream))
             ? 0
             : next<size_t(const void*, size_t, size_t, FILE*)>("fwrite")(data, size, n, stream);
}

int rename(const char* from, const char* to) noexcept {
  return fails("rename", to) ? -1 : next<int(const char*, const char*)>("rename")(from, to);
}

int remove(const char* path) noexcept {
  return fails("remove", path) ? -1 : next<int(const char*)>("remove")(path);
}

int unlink(const char* path) noexcept {
  return fails("remove", path) ? -1 : next<int(const char*)>("unlink")(path);
}

int mkdir(const char* path, mode_t mode) noexcept {
  return fails("mkdir", path) ? -1 : next<int(const char*, mode_t)>("mkdir")(path, mode);
}

int fsync(int file) { return fails("sync", file) ? -1 : next<int(int)>("fsync")(file); }
int fdatasync(int file) { return fails("sync", file) ? -1 : next<int(int)>("fdatasync")(file); }
int syncfs(int file) noexcept { return fails("sync", file) ? -1 : next<int(int)>("syncfs")(file); }

int close(int file) {
  if (!fails("close", file)) return next<int(int)>("close")(file);
  const int error = errno;
  next<int(int)>("close")(file);
  errno = error;
  return -1;
}

int clock_gettime(clockid_t clock, timespec* now) noexcept {
  static const long back = std::atol(variable("FAULT_CLOCK").c_str());
  static std::atomic<long> looks{0};
  const int result = next<int(clockid_t, timespec*)>("clock_gettime")(clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec -= back * ++looks;
  return result;
}

time_t time(time_t* copy) noexcept {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (copy != nullptr) *copy = now.tv_sec;
  return now.tv_sec;
}
}
