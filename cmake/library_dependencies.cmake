# SPDX-License-Identifier: Apache-2.0
# The outside packages that the libraries up to cosim/ need: of those who build them, and of those who link them
# (cmake/fringetwinConfig.cmake.in).
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED) # Math: headers only
find_package(Ceres 2.1 REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs calib3d aruco)
find_package(PCL 1.13 REQUIRED COMPONENTS common registration sample_consensus segmentation features search kdtree)
pkg_check_modules(OpenEXR REQUIRED IMPORTED_TARGET OpenEXR>=3.1) # its CMake config wants PyImath
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(OpenMP REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(Vulkan 1.3 REQUIRED)
find_package(SPIRV-Tools REQUIRED)
find_package(SPIRV-Tools-opt REQUIRED)

# libmrcal ships neither a CMake config nor a .pc file.
find_path(MRCAL_INCLUDE_DIR mrcal/mrcal.h REQUIRED)
find_library(MRCAL_LIBRARY mrcal REQUIRED)
if(NOT TARGET mrcal::mrcal) # a project may look for us twice
  add_library(mrcal::mrcal UNKNOWN IMPORTED)
  set_target_properties(mrcal::mrcal PROPERTIES
    IMPORTED_LOCATION ${MRCAL_LIBRARY}
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${MRCAL_INCLUDE_DIR})
endif()
