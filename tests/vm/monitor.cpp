// SPDX-License-Identifier: Apache-2.0
#include "tests/vm/monitor.hpp"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <thread>

namespace fringetwin::testing {
namespace {

constexpr const char* port = "/dev/ttyS1";
constexpr const char* prompt = "(qemu) ";

constexpr int most_looks = 500;

/// nullopt: not there, or not whole yet.
std::optional<Image<std::uint32_t>> read_dump(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string magic;
  int width = 0, height = 0, top = 0;
  in >> magic >> width >> height >> top;
  if (!in || magic != "P6" || top != 255) return {};
  in.get();
  Image<std::uint32_t> image(width, height);
  std::string bytes(3 * image.size(), '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) return {};
  for (std::size_t i = 0; i < image.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      image.data[i] = image.data[i] << 8 | static_cast<std::uint8_t>(bytes[3 * i + k]);
  return image;
}

}  // namespace

Monitor::Monitor() : fd_(::open(port, O_RDWR | O_NOCTTY | O_CLOEXEC)) {
  termios raw{};
  if (fd_ < 0 || ::tcgetattr(fd_, &raw) != 0) throw std::runtime_error("no monitor of QEMU");
  ::cfmakeraw(&raw);
  ::cfsetspeed(&raw, B115200);
  ::tcsetattr(fd_, TCSANOW, &raw);
  command("");  // the prompt that QEMU wrote before the port was open may be lost
}

Monitor::~Monitor() { ::close(fd_); }

std::string Monitor::read_answer() {
  std::string text;
  char byte = 0;
  while (::read(fd_, &byte, 1) == 1) {
    text += byte;
    const auto end_of_line = text.find('\n');  // of the command's echo
    if (end_of_line != std::string::npos && text.find(prompt, end_of_line) != std::string::npos)
      return text.substr(end_of_line + 1);
  }
  throw std::runtime_error("QEMU's monitor does not answer: " + text);
}

std::string Monitor::command(const std::string& line) {
  for (const char byte : line + "\n")
    if (::write(fd_, &byte, 1) != 1) throw std::runtime_error("QEMU's monitor takes no command");
  return read_answer();
}

Image<std::uint32_t> Monitor::screen(const std::string& device, const std::string& file) {
  const std::filesystem::path path = std::filesystem::path("/host") / file;
  std::filesystem::remove(path);
  const std::string answer = command("screendump " + file + " " + device);
  // A prompt left over from before ends the answer early: the file is what counts.
  for (int attempt = 0; attempt < most_looks; ++attempt) {
    if (const auto image = read_dump(path)) return *image;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  throw std::runtime_error("no screen dump: " + answer);
}

}  // namespace fringetwin::testing
