// SPDX-License-Identifier: Apache-2.0
#include "twin/base/sha256.hpp"

#include <openssl/evp.h>

#include <array>
#include <fstream>
#include <vector>

#include "twin/base/errors.hpp"
#include "twin/base/progress.hpp"

namespace fringetwin {

struct Sha256::Impl {
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context{EVP_MD_CTX_new(), EVP_MD_CTX_free};
};

Sha256::Sha256() : impl_(std::make_unique<Impl>()) {
  FT_CHECK(impl_->context && EVP_DigestInit_ex(impl_->context.get(), EVP_sha256(), nullptr) == 1,
           "OpenSSL has SHA-256");
}
Sha256::~Sha256() = default;

void Sha256::add(std::span<const std::byte> bytes) {
  FT_CHECK(EVP_DigestUpdate(impl_->context.get(), bytes.data(), bytes.size()) == 1, "OpenSSL takes bytes");
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  FT_CHECK(EVP_DigestFinal_ex(impl_->context.get(), digest.data(), &length) == 1,
           "asked for the digest once");
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < length; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

std::string sha256_of_bytes(std::span<const std::byte> bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.hex();
}

std::string sha256_of_text(std::string_view text) { return sha256_of_bytes(std::as_bytes(std::span(text))); }

std::string sha256_of_file(const std::filesystem::path& file, const std::string& hint) {
  const auto refuse = [&] {
    throw UserError(ExitCode::input, file.string(), "the file cannot be read", hint);
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) refuse();  // a pipe would never end
  std::ifstream in(file, std::ios::binary);
  if (!in) refuse();
  Sha256 digest;
  std::vector<char> buffer(1 << 18);
  for (std::size_t n = 1; in; ++n) {
    if (n % 256 == 0) throw_if_cancelled();  // every 64 MiB: a stranger's capture.toml may name any file
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    digest.add(std::as_bytes(std::span(buffer.data(), static_cast<std::size_t>(in.gcount()))));
  }
  if (in.bad()) refuse();  // e.g. a folder, a disk that fails: no digest of half a file
  return digest.hex();
}

}  // namespace fringetwin
