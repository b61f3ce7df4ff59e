# SPDX-License-Identifier: Apache-2.0
# House rules as functions: one library per folder, tests beside their source.

add_library(fringetwin_options INTERFACE)
target_compile_features(fringetwin_options INTERFACE cxx_std_20)
target_compile_options(fringetwin_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  $<$<NOT:$<BOOL:${FRINGETWIN_ASAN}>>:-Werror> # the sanitizers make g++ 12 see uninitialised variables that are none
  -Wno-restrict) # g++ 12 warns falsely on std::string + (GCC bug 105329)
# x86-64-v3 is not assumed: the binary must run on any amd64 machine. No -ffast-math: NaN marks
# invalid pixels everywhere.
target_include_directories(fringetwin_options INTERFACE ${CMAKE_SOURCE_DIR})
if(FRINGETWIN_ASAN)
  # global, so that every object of ours agrees on it
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -O1)
  add_link_options(-fsanitize=address,undefined)
endif()
find_package(OpenMP REQUIRED)
add_custom_target(unit_tests) # what the sanitizer run builds

# fringetwin_library(NAME SOURCES a.cpp ... PUBLIC libs PRIVATE libs)
# -> library fringetwin_NAME, alias fringetwin::NAME
function(fringetwin_library name)
  cmake_parse_arguments(A "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(fringetwin_${name} STATIC ${A_SOURCES})
  add_library(fringetwin::${name} ALIAS fringetwin_${name})
  target_link_libraries(fringetwin_${name} PUBLIC ${A_PUBLIC} PRIVATE fringetwin_options ${A_PRIVATE})
  target_include_directories(fringetwin_${name} PUBLIC ${CMAKE_SOURCE_DIR})
endfunction()

# fringetwin_test(NAME SOURCES a_test.cpp ... LINK libs LABELS unit|accuracy|real-data|e2e|device|slow)
# One executable and one CTest test per name. CTest reports an executable as skipped when its last line names a
# skipped case: gtest lists failed cases after the skipped ones, so a failure is never reported as a skip.
function(fringetwin_test name)
  if(NOT FRINGETWIN_TESTS)
    return()
  endif()
  cmake_parse_arguments(A "" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  add_executable(${name} ${A_SOURCES})
  target_link_libraries(${name} PRIVATE fringetwin_options ${A_LINK} GTest::gmock GTest::gtest_main)
  target_compile_options(${name} PRIVATE -O1) # half the compile time; the code under test keeps -O3
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if("unit" IN_LIST A_LABELS)
    add_dependencies(unit_tests ${name})
  endif()
  add_test(NAME ${name} COMMAND ${name})
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 300)
  endif()
  if(FRINGETWIN_ASAN)
    math(EXPR A_TIMEOUT "4 * ${A_TIMEOUT}")
  endif()
  set_tests_properties(${name} PROPERTIES LABELS "${A_LABELS}" TIMEOUT ${A_TIMEOUT}
    SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\] [^\n]*[\n]*$"
    ENVIRONMENT "FRINGETWIN_BINARY=${CMAKE_BINARY_DIR}/fringetwin;FRINGETWIN_SOURCE=${CMAKE_SOURCE_DIR}")
endfunction()
