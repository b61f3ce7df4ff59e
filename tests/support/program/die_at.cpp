// SPDX-License-Identifier: Apache-2.0
// LD_PRELOAD: the process dies before its DIE_AT-th call that changes a capture set: a rename, a removal, or
// bringing the journal to the disk. Calls on other files (caches) do not count.
#include <dlfcn.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<int> calls = 0;

void count() {
  static const int last = std::getenv("DIE_AT") ? std::atoi(std::getenv("DIE_AT")) : 0;
  if (++calls == last) ::_exit(137);
}

bool is_of_a_set(const char* name) {
  return std::strstr(name, ".png") || std::strstr(name, "capture.") || std::strstr(name, "frames.csv");
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" int rename(const char* from, const char* to) noexcept {
  if (is_of_a_set(to)) count();
  return next<int(const char*, const char*)>("rename")(from, to);
}

extern "C" int remove(const char* name) noexcept {
  if (is_of_a_set(name)) count();
  return next<int(const char*)>("remove")(name);
}

extern "C" int fdatasync(int file) {
  count();
  return next<int(int)>("fdatasync")(file);
}
