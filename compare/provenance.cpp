// SPDX-License-Identifier: Apache-2.0
#include "compare/provenance.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>
#include <fstream>
#include <memory>
#include <set>

#include "twin/errors.hpp"

namespace fringetwin::compare {

std::string RenderNote::text() const {
  std::string out = samples ? fmt::format("{}, {} samples per pixel", sampler, *samples) : sampler;
  out += fmt::format(", {:.3g} rays per pixel", rays_per_pixel);
  if (double_precision) out += ", double precision";
  if (phase_error_rad && gray_error)
    out += fmt::format(", errors estimated at {:.1e} rad and {:.1e} of full scale", *phase_error_rad,
                       *gray_error);
  return out;
}

std::string sha256_of_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw UserError(ExitCode::input, file.string(), "the file cannot be read",
                    "it was an input of this run and must stay in place until the result is written");
  const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  FT_CHECK(context && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1, "OpenSSL has SHA-256");
  std::vector<char> buffer(1 << 18);
  while (in) {
    in.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    EVP_DigestUpdate(context.get(), buffer.data(), static_cast<std::size_t>(in.gcount()));
  }
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  EVP_DigestFinal_ex(context.get(), digest.data(), &length);
  static constexpr char kHex[] = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < length; ++i) {
    hex += kHex[digest[i] >> 4];
    hex += kHex[digest[i] & 15];
  }
  return hex;
}

std::map<std::string, std::string> sha256_of_files(const std::vector<std::filesystem::path>& files) {
  const std::set<std::filesystem::path> unique(files.begin(), files.end());
  std::map<std::string, std::string> digests;
  for (const auto& file : unique) digests[file.string()] = sha256_of_file(file);
  return digests;
}

}  // namespace fringetwin::compare
