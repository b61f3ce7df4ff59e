# SPDX-License-Identifier: Apache-2.0
# Finds the Python that the module is for, and pybind11: FRINGETWIN_HAS_PYTHON says whether both are there.
set(Python3_EXECUTABLE /usr/bin/python3 CACHE FILEPATH "the Python that the module is for") # Debian's, whatever PATH says
find_package(Python3 3.9 COMPONENTS Interpreter Development.Module)
set(Python_EXECUTABLE ${Python3_EXECUTABLE})
set(PYTHON_EXECUTABLE ${Python3_EXECUTABLE})
find_package(pybind11 2.10 CONFIG)
set(FRINGETWIN_HAS_PYTHON OFF)
if(Python3_FOUND AND pybind11_FOUND)
  set(FRINGETWIN_HAS_PYTHON ON)
endif()
