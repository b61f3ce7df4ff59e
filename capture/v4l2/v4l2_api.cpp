// SPDX-License-Identifier: Apache-2.0
#include "capture/v4l2/v4l2_api.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "twin/base/progress.hpp"
#include "twin/number/parse_number.hpp"

namespace fringetwin::capture {
namespace {

constexpr std::int64_t kPollMs = 100;  // how soon Ctrl-C is noticed at the latest: frames may take minutes

template <class Call>
auto uninterrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

class KernelV4l2 final : public V4l2Api {
 public:
  std::vector<std::string> device_paths() override {
    const std::string prefix = "video";
    std::vector<std::pair<unsigned, std::string>> found;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator("/dev", none)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(prefix)) continue;
      if (const std::optional<unsigned> number = parse_number<unsigned>(name.substr(prefix.size())))
        found.emplace_back(*number, entry.path().string());
    }
    std::ranges::sort(found);
    std::vector<std::string> paths;
    for (auto& [number, path] : found) paths.push_back(std::move(path));
    return paths;
  }

  int open(const std::string& path) override {
    const int fd = uninterrupted([&] { return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); });
    return fd < 0 ? -errno : fd;
  }

  void close(int fd) override { ::close(fd); }

  int ioctl(int fd, unsigned long request, void* argument) override {
    return uninterrupted([&] { return ::ioctl(fd, request, argument); }) < 0 ? -errno : 0;
  }

  void* map(int fd, std::size_t length, std::uint32_t offset) override {
    void* address =
        ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
    return address == MAP_FAILED ? nullptr : address;
  }

  void unmap(void* address, std::size_t length) override { ::munmap(address, length); }

  int poll(int fd, short events, std::chrono::milliseconds timeout) override {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    const bool was_cancelled = cancelled();  // what tidies up afterwards is not stopped by it
    for (;;) {
      const auto left =
          std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
      pollfd entry{fd, events, 0};
      const int n = ::poll(&entry, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, kPollMs)));
      if (n > 0) return entry.revents;
      if (n == 0 && left.count() <= kPollMs) return 0;
      if (n < 0 && errno != EINTR) return -errno;
      if (!was_cancelled) throw_if_cancelled();
    }
  }
};

}  // namespace

std::shared_ptr<V4l2Api> kernel_v4l2() { return std::make_shared<KernelV4l2>(); }

}  // namespace fringetwin::capture
