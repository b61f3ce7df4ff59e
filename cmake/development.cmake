# SPDX-License-Identifier: Apache-2.0
# What programs of others are built with: `cmake --install build --component development --prefix P` puts the static
# libraries up to cosim/, their headers and the CMake package there, and the sources of the Python module, to be built for
# another Python; a plain install leaves them out.
#   lib/libfringetwin_*.a, include/fringetwin, lib/cmake/fringetwin, share/fringetwin/python
include(CMakePackageConfigHelpers)
set(headers twin/twin.hpp twin/captures/capture_set.hpp twin/base/errors.hpp twin/base/progress.hpp
  render/renderer.hpp render/base/device_info.hpp measure/measurement.hpp
  cosim/cosim.hpp cosim/load.hpp cosim/shape/measured_shapes.hpp cosim/simulate.hpp cosim/write_results.hpp)
# What the Python module includes beside them.
set(headers_of_python cli/version.hpp compare/result/result_json.hpp cosim/measure_captures.hpp measure/decode/phase_exr.hpp
  measure/fit/fits.hpp twin/base/out_folder.hpp twin/base/plain_text.hpp twin/captures/stored_images.hpp)

# fringetwin_with_included(OUT headers...): these headers and all of ours that they include
function(fringetwin_with_included out)
  set(known ${ARGN})
  set(open ${ARGN})
  while(open)
    list(POP_FRONT open header)
    file(STRINGS ${CMAKE_SOURCE_DIR}/${header} lines REGEX "^#include \"")
    list(TRANSFORM lines REPLACE "^#include \"([^\"]+)\".*" "\\1")
    foreach(line ${lines})
      if(NOT line IN_LIST known)
        list(APPEND known ${line})
        list(APPEND open ${line})
      endif()
    endforeach()
  endwhile()
  set(${out} ${known} PARENT_SCOPE)
endfunction()

fringetwin_with_included(headers ${headers} ${headers_of_python})
set(development COMPONENT development EXCLUDE_FROM_ALL)
foreach(header ${headers})
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${header} DESTINATION include/fringetwin/${folder} ${development})
endforeach()
set(libraries twin render measure report calib compare cosim version options volk)
foreach(library ${libraries})
  set_target_properties(fringetwin_${library} PROPERTIES EXPORT_NAME ${library})
endforeach()
list(TRANSFORM libraries PREPEND fringetwin_)
install(TARGETS ${libraries} EXPORT fringetwin ARCHIVE DESTINATION lib ${development})
install(EXPORT fringetwin NAMESPACE fringetwin:: FILE fringetwinTargets.cmake DESTINATION lib/cmake/fringetwin ${development})
set(package ${CMAKE_CURRENT_BINARY_DIR}/fringetwinConfig.cmake)
configure_package_config_file(cmake/fringetwinConfig.cmake.in ${package} INSTALL_DESTINATION lib/cmake/fringetwin
  NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
write_basic_package_version_file(${package}Version COMPATIBILITY SameMinorVersion)
install(FILES ${package} cmake/library_dependencies.cmake DESTINATION lib/cmake/fringetwin ${development})
install(FILES ${package}Version RENAME fringetwinConfigVersion.cmake DESTINATION lib/cmake/fringetwin ${development})
install(DIRECTORY python/ DESTINATION share/fringetwin/python ${development} FILES_MATCHING PATTERN "*.?pp" PATTERN "*.py" PATTERN "*.pyi"
  PATTERN "py.typed" PATTERN "*.cmake" PATTERN "CMakeLists.txt" PATTERN "__pycache__" EXCLUDE)
