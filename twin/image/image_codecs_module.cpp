// SPDX-License-Identifier: Apache-2.0
#include <cstring>
#include <opencv2/imgcodecs.hpp>

#include "twin/image/image_codecs.hpp"

extern "C" bool fringetwin_decode_image_1(const std::uint8_t* bytes, std::size_t size,
                                          fringetwin::DecodedImage* image) {
  cv::Mat mat;
  try {
    mat = cv::imdecode(cv::_InputArray(bytes, static_cast<int>(size)), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {  // an empty Mat says the same
  }
  if (mat.empty()) return false;
  image->width = mat.cols;
  image->height = mat.rows;
  image->channels = mat.channels();
  image->bits = mat.depth() == CV_8U ? 8 : mat.depth() == CV_16U ? 16 : 0;
  if (image->channels != 1 || image->bits == 0) return true;
  const std::size_t row = mat.elemSize() * static_cast<std::size_t>(mat.cols);
  image->values.resize(row * static_cast<std::size_t>(mat.rows));
  for (int y = 0; y < mat.rows; ++y)
    std::memcpy(&image->values[row * static_cast<std::size_t>(y)], mat.ptr(y), row);
  return true;
}
