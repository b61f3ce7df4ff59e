# SPDX-License-Identifier: Apache-2.0
# The Debian package of the program (`make package`): what cmake/install.cmake installs, with the dependencies that
# dpkg-shlibdeps finds in the program and its modules, and those below that are started or loaded by name.
set(FRINGETWIN_MAINTAINER "fringetwin maintainers <maintainers@fringetwin.example>" CACHE STRING "who answers for the package")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fringetwin)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${FRINGETWIN_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "digital twin of fringe-projection rigs, checked against real captures")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Renders with Vulkan what the cameras of a calibrated fringe-projection rig
should have recorded, sends simulated and real images through the same
measurement code, and reports where the twin and the rig agree: gray levels,
absolute phase and fitted geometry, each with its uncertainty.
.
Virtual experiments, calibration, photometry and recording are in it, too.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS ${CMAKE_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# volk opens libvulkan by name; reports have their plots from gnuplot; any driver will do.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libvulkan1, mesa-vulkan-drivers | vulkan-icd, gnuplot-nox | gnuplot")
if(FRINGETWIN_HAS_PYTHON)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1") # the module is of one version of Python
  string(APPEND CPACK_DEBIAN_PACKAGE_DEPENDS ", python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor}), python3-numpy")
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
