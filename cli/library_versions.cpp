// SPDX-License-Identifier: Apache-2.0
#include "cli/library_versions.hpp"

#include <OpenEXR/openexr_base.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <png.h>
#include <sqlite3.h>
#include <zlib.h>

#include <nlopt.hpp>
#include <opencv2/core/utility.hpp>

namespace fringetwin::cli {
namespace {

std::string openexr_version() {
  int major = 0, minor = 0, patch = 0;
  const char* more = nullptr;
  exr_get_library_version(&major, &minor, &patch, &more);
  return fmt::format("{}.{}.{}", major, minor, patch);
}

}  // namespace

std::vector<std::pair<std::string, std::string>> library_versions() {
  return {
      {"libpng", png_get_libpng_ver(nullptr)},
      {"NLopt",
       fmt::format("{}.{}.{}", nlopt::version_major(), nlopt::version_minor(), nlopt::version_bugfix())},
      {"OpenCV", cv::getVersionString()},
      {"OpenEXR", openexr_version()},
      {"OpenSSL", OpenSSL_version(OPENSSL_VERSION_STRING)},
      {"SQLite", sqlite3_libversion()},
      {"zlib", zlibVersion()},
  };
}

}  // namespace fringetwin::cli
