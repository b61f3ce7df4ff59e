# SPDX-License-Identifier: Apache-2.0
# Every outside package in one place. All come from Debian 12 (packages.txt, `make deps`).
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED) # Math: headers only
find_package(Ceres 2.1 REQUIRED)
find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc imgcodecs calib3d aruco)
find_package(PCL 1.13 REQUIRED COMPONENTS common registration sample_consensus segmentation features search kdtree)
pkg_check_modules(OpenEXR REQUIRED IMPORTED_TARGET OpenEXR>=3.1) # its CMake config wants PyImath
find_package(PNG REQUIRED)
find_package(TIFF REQUIRED)
pkg_check_modules(TurboJPEG REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(DRM REQUIRED IMPORTED_TARGET libdrm)
pkg_check_modules(SDL2 REQUIRED IMPORTED_TARGET sdl2)
find_package(X11 REQUIRED)
pkg_check_modules(ARAVIS IMPORTED_TARGET aravis-0.8>=0.8.20) # without it: no GenICam cameras
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(assimp REQUIRED)
find_package(embree 3 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(OpenMP REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(SQLite3 3.40 REQUIRED)
pkg_check_modules(NLopt REQUIRED IMPORTED_TARGET nlopt_cxx>=2.7)
find_package(Vulkan 1.3 REQUIRED)
find_package(SPIRV-Tools REQUIRED)
find_package(SPIRV-Tools-opt REQUIRED)
find_program(GLSLANG_VALIDATOR glslangValidator REQUIRED)
find_program(SPIRV_VAL spirv-val REQUIRED)
if(FRINGETWIN_TESTS)
  find_package(GTest 1.12 REQUIRED)
  find_package(rapidcheck REQUIRED)
endif()

# libmrcal ships neither a CMake config nor a .pc file.
find_path(MRCAL_INCLUDE_DIR mrcal/mrcal.h REQUIRED)
find_library(MRCAL_LIBRARY mrcal REQUIRED)
add_library(mrcal::mrcal UNKNOWN IMPORTED)
set_target_properties(mrcal::mrcal PROPERTIES
  IMPORTED_LOCATION ${MRCAL_LIBRARY}
  INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${MRCAL_INCLUDE_DIR})
