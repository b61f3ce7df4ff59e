# SPDX-License-Identifier: Apache-2.0
# The Debian packages (`make package`, docs/PACKAGES.md), one for each component of the installation: fringetwin has the
# program, libfringetwin-dev what programs of others are built with, python3-fringetwin the Python module. Each names the
# packages that dpkg-shlibdeps finds in its programs and modules, and those below that are started, loaded by name or included.
set(FRINGETWIN_MAINTAINER "fringetwin maintainers <maintainers@fringetwin.example>" CACHE STRING "who answers for the packages")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fringetwin)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${FRINGETWIN_MAINTAINER}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(about "Renders with Vulkan what the cameras of a calibrated fringe-projection rig
should have recorded, sends simulated and real images through the same
measurement code, and reports where the twin and the rig agree: gray levels,
absolute phase and fitted geometry, each with its uncertainty.
.")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME fringetwin)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
# volk opens libvulkan by name; reports have their plots from gnuplot; any driver will do.
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "libvulkan1, mesa-vulkan-drivers | vulkan-icd, gnuplot-nox | gnuplot")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS xdg-utils) # `fringetwin open`
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "digital twin of fringe-projection rigs, checked against real captures
${about}
Virtual experiments, calibration, photometry and recording are in it, too.")

# What cmake/library_dependencies.cmake looks for, package by package; compilers are the choice of who builds.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libfringetwin-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SOURCE fringetwin)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
string(JOIN ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  pkg-config "libeigen3-dev (>= 3.4)" "libboost-dev (>= 1.74)" "libceres-dev (>= 2.1)" "libopencv-dev (>= 4.6)" "libpcl-dev (>= 1.13)"
  "libopenexr-dev (>= 3.1)" libpng-dev zlib1g-dev libssl-dev "nlohmann-json3-dev (>= 3.11)" "libfmt-dev (>= 9)"
  libtomlplusplus-dev "libvulkan-dev (>= 1.3)" spirv-tools libmrcal-dev)
# Programs that are built with it open and start the same as the program.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "mesa-vulkan-drivers | vulkan-icd, gnuplot-nox | gnuplot")
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "digital twin of fringe-projection rigs, for programs of your own
${about}
This package has the static libraries, their headers and a CMake package:
find_package(fringetwin).")

if(FRINGETWIN_HAS_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-fringetwin)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SOURCE fringetwin)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1") # the module is of one version of Python
  # The module loads the program's module for TIFF, and needs the same driver and gnuplot.
  string(JOIN ", " CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "fringetwin (= ${PROJECT_VERSION})"
    "python3 (>= 3.${Python3_VERSION_MINOR})" "python3 (<< 3.${next_minor})" python3-numpy)
  # For some days before its release, 0.2.0 was a single package, with the module in it. Its files may be taken over. Breaks
  # would be wrong: it cannot tell that package from the one of the same version that the module depends on. Nothing of
  # libfringetwin-dev was ever in another package, and before 0.2.0 there was none.
  set(CPACK_DEBIAN_PYTHON_PACKAGE_REPLACES "fringetwin (<= 0.2.0)")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${CMAKE_SOURCE_DIR}/cmake/python3/postinst ${CMAKE_SOURCE_DIR}/cmake/python3/prerm)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "digital twin of fringe-projection rigs, from Python
${about}
This package has the module fringetwin: twins rendered and measured into numpy
arrays, by the same code as on the command line.")
endif()

# The version stands in CMakeLists.txt; CHANGELOG.md begins with it.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/CHANGELOG.md)
file(STRINGS ${CMAKE_SOURCE_DIR}/CHANGELOG.md section REGEX "^## " LIMIT_COUNT 1)
if(NOT section MATCHES "^## ${PROJECT_VERSION}( |$)")
  message(FATAL_ERROR "CHANGELOG.md begins with \"${section}\", CMakeLists.txt has version ${PROJECT_VERSION}: make them agree")
endif()
# What Debian's policy wants of every package.
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/cmake/debian.cmake)
set(CPACK_FRINGETWIN_SOURCE ${CMAKE_SOURCE_DIR})
include(CPack)
