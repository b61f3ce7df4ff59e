# SPDX-License-Identifier: Apache-2.0
# House rules as functions: one library per folder, tests beside their source.

add_library(fringetwin_options INTERFACE)
target_compile_features(fringetwin_options INTERFACE cxx_std_20)
target_compile_options(fringetwin_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  $<$<NOT:$<BOOL:${FRINGETWIN_ASAN}>>:-Werror> # the sanitizers make g++ 12 see uninitialised variables that are none
  # g++ 12 warns falsely on std::string + and on strings in vectors (GCC bugs 105329, 105651)
  -Wno-restrict -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread
  $<$<BOOL:${FRINGETWIN_UNITY}>:-Wno-use-after-free -Wno-maybe-uninitialized>) # and on Eigen's temporaries, once several files are compiled as one
# No path of the machine that built it is in the program: an internal fault names its place from the root of the sources.
target_compile_options(fringetwin_options INTERFACE $<BUILD_INTERFACE:-fmacro-prefix-map=${CMAKE_SOURCE_DIR}/=>)
# x86-64-v3 is not assumed: the binary must run on any amd64 machine. No -ffast-math: NaN marks
# invalid pixels everywhere.
target_include_directories(fringetwin_options INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
# OpenMP for all of them: a precompiled header serves only files of the same flags.
target_link_libraries(fringetwin_options INTERFACE fmt::fmt OpenMP::OpenMP_CXX)
if(NOT FRINGETWIN_ASAN)
  # The program reads files of strangers (docs/SECURITY.md): what a hole in a reader could be used for. Debian's g++ makes
  # programs independent of their position by itself; others are told to. Fortified functions need an optimised build.
  # The libraries are linked into programs and into the Python module (python/), which nobody interposes functions of.
  target_compile_options(fringetwin_options INTERFACE -fstack-protector-strong -fPIC -fno-semantic-interposition
    $<$<NOT:$<CONFIG:Debug>>:-U_FORTIFY_SOURCE$<SEMICOLON>-D_FORTIFY_SOURCE=3>)
  target_link_options(fringetwin_options INTERFACE -Wl,-z,relro,-z,now
    $<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie>)
endif()
if(FRINGETWIN_ASAN)
  # Global, so that every object of ours agrees on it. Line numbers without variables, and without the checks made at
  # every pointer: two fifths of the compile time of Eigen's, Ceres' and PCL's templates. AddressSanitizer sees most of
  # what null, object-size and pointer-overflow would; twin/ reads foreign bytes and checks alignment and
  # pointer-overflow; wrong downcasts are given up.
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -O1 -g1
    -fno-sanitize=null,alignment,object-size,pointer-overflow,vptr)
  add_link_options(-fsanitize=address,undefined)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    # g++'s names of warnings; what clang wants alike in all users of a precompiled header; ccache compares that by its content
    add_compile_options(-Wno-unknown-warning-option -Wno-pass-failed -pthread "SHELL:-Xclang -fno-pch-timestamp")
  endif()
endif()
if(FRINGETWIN_FUZZ) # for one program, tests/fuzz: others lack what the code then calls
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    add_compile_options(-fsanitize=fuzzer-no-link)
  else()
    add_compile_options(-fsanitize-coverage=trace-pc)
  endif()
endif()
# Of the files of tests, which take half and a third of the compile time so; the code under test keeps its own.
set(FRINGETWIN_TEST_SPEED -O1)
if(FRINGETWIN_ASAN)
  set(FRINGETWIN_TEST_SPEED -O0)
endif()
add_custom_target(unit_tests)  # `make test` runs them with the sanitizers
add_custom_target(whole_tests) # and all others but the slow ones as released

# What nearly every file includes, compiled once per kind of flags (g++ takes a precompiled header only with the
# flags it was made with): saves about half the compile time of a small file.
set(FRINGETWIN_HEADERS_SOURCE ${CMAKE_CURRENT_LIST_DIR}/headers.cpp)
function(fringetwin_precompile name kind)
  if(kind STREQUAL cli) # one target, its own headers
    target_precompile_headers(${name} PRIVATE <CLI/CLI.hpp> <fmt/format.h> <nlohmann/json.hpp> <Eigen/Core> <Eigen/Geometry> <filesystem>
      <functional> <map> <memory> <optional> <string> <variant> <vector>)
    return()
  endif()
  set(headers fringetwin_headers_${kind})
  set(libraries fringetwin_options Eigen3::Eigen)
  set(list <fmt/format.h> <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream>
    <functional> <limits> <map> <memory> <optional> <sstream> <string> <string_view> <variant> <vector>)
  if(kind STREQUAL test)
    list(APPEND libraries GTest::gmock GTest::gtest_main)
    list(APPEND list <gmock/gmock.h> <gtest/gtest.h>)
  endif()
  if(NOT TARGET ${headers})
    add_library(${headers} OBJECT ${FRINGETWIN_HEADERS_SOURCE})
    target_link_libraries(${headers} PRIVATE ${libraries})
    if(kind STREQUAL test)
      target_compile_options(${headers} PRIVATE ${FRINGETWIN_TEST_SPEED})
    endif()
    target_precompile_headers(${headers} PRIVATE ${list})
  endif()
  target_precompile_headers(${name} REUSE_FROM ${headers})
endfunction()

# fringetwin_library(NAME SOURCES a.cpp ... PUBLIC libs PRIVATE libs)
# -> library fringetwin_NAME, alias fringetwin::NAME
function(fringetwin_library name)
  cmake_parse_arguments(A "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(fringetwin_${name} STATIC ${A_SOURCES})
  add_library(fringetwin::${name} ALIAS fringetwin_${name})
  target_link_libraries(fringetwin_${name} PUBLIC ${A_PUBLIC} PRIVATE fringetwin_options ${A_PRIVATE})
  target_include_directories(fringetwin_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/fringetwin>)
  fringetwin_precompile(fringetwin_${name} library)
  fringetwin_unity(fringetwin_${name})
endfunction()

# FRINGETWIN_UNITY (CMakeLists.txt): several files at a time, so that their headers are read and their templates made once.
function(fringetwin_unity target)
  if(FRINGETWIN_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 32)
  endif()
endfunction()

# For files whose private names clash with their neighbours' in a unity build.
function(fringetwin_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# For test files that compute much themselves: optimised where the others are not (FRINGETWIN_TEST_SPEED).
function(fringetwin_test_computes)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -O1 SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# fringetwin_tests(GROUP SOURCES a_test.cpp ... LINK libs LABELS unit|accuracy|real-data|e2e|device|slow [TIMEOUT s])
# One executable build/tests/GROUP_tests; each of its files is one CTest test, GROUP/a. A test file has a namespace of
# its own, named like the file, so that several can be compiled as one (FRINGETWIN_UNITY). What they share is in
# fringetwin::testing (tests/support/); GoogleTest's own names are therefore spelt ::testing::.
function(fringetwin_tests group)
  if(NOT FRINGETWIN_TESTS)
    return()
  endif()
  string(REPLACE "/" "_" name ${group}_tests)
  cmake_parse_arguments(A "" "TIMEOUT" "SOURCES;LINK;LABELS" ${ARGN})
  add_executable(${name} ${A_SOURCES})
  target_link_libraries(${name} PRIVATE fringetwin_options ${A_LINK} GTest::gmock GTest::gtest_main)
  target_compile_options(${name} PRIVATE ${FRINGETWIN_TEST_SPEED})
  fringetwin_precompile(${name} test)
  fringetwin_unity(${name})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if("unit" IN_LIST A_LABELS)
    add_dependencies(unit_tests ${name})
  elseif(NOT "slow" IN_LIST A_LABELS)
    add_dependencies(whole_tests ${name})
  endif()
  set(all "")
  set(others "")
  foreach(source ${A_SOURCES})
    if(source MATCHES "_test\\.cpp$")
      fringetwin_suites(suites ${source})
      foreach(suite ${suites})
        if("${suite}" IN_LIST all)
          message(FATAL_ERROR "${source}: test suite ${suite} is another file's of ${name}; name it otherwise")
        endif()
        list(APPEND all "${suite}")
        string(APPEND others ":${suite}.*:*/${suite}.*")
      endforeach()
      list(TRANSFORM suites REPLACE "(.+)" "\\1.*:*/\\1.*")
      list(JOIN suites ":" filter)
      get_filename_component(test ${source} NAME) # of its sub-room nothing is seen in the test's name
      string(REGEX REPLACE "_test\\.cpp$" "" test ${test})
      fringetwin_add_test(${group}/${test} ${name} "${filter}" "${A_LABELS}" "${A_TIMEOUT}")
      set_tests_properties(${group}/${test} PROPERTIES FAIL_REGULAR_EXPRESSION "Running 0 tests")
    endif()
  endforeach()
  # what the search for suites may have overlooked
  fringetwin_add_test(${group}/others ${name} "*-${others}" "${A_LABELS}" "${A_TIMEOUT}")
endfunction()

# fringetwin_skipped(GROUP/a LABEL REASON): the test that is not built here says why.
function(fringetwin_skipped test label reason)
  if(FRINGETWIN_TESTS)
    add_test(NAME ${test} COMMAND ${CMAKE_COMMAND} -E echo "SKIPPED: ${reason}")
    set_tests_properties(${test} PROPERTIES LABELS ${label} SKIP_REGULAR_EXPRESSION "SKIPPED")
  endif()
endfunction()

# The names of the test suites in a source file.
function(fringetwin_suites out source)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${source})
  file(STRINGS ${source} suites REGEX "^(TEST|TEST_F|TEST_P|RC_GTEST_PROP)\\(")
  list(TRANSFORM suites REPLACE "^[A-Z_]+\\(([A-Za-z0-9_]+).*" "\\1")
  list(REMOVE_DUPLICATES suites)
  if(NOT suites)
    message(FATAL_ERROR "${source} has no test")
  endif()
  set(${out} ${suites} PARENT_SCOPE)
endfunction()

# CTest reports an executable as skipped when its last line names a skipped case: gtest lists failed cases after the
# skipped ones, so a failure is never reported as a skip.
function(fringetwin_add_test test executable filter labels timeout)
  add_test(NAME ${test} COMMAND ${executable} --gtest_filter=${filter})
  if(NOT timeout)
    set(timeout 300)
  endif()
  if(FRINGETWIN_ASAN)
    math(EXPR timeout "4 * ${timeout}")
  endif()
  set_tests_properties(${test} PROPERTIES LABELS "${labels}" TIMEOUT ${timeout}
    SKIP_REGULAR_EXPRESSION "\\[  SKIPPED \\] [^\n]*[\n]*$"
    ENVIRONMENT "FRINGETWIN_CACHE=${CMAKE_BINARY_DIR}/test-cache;FRINGETWIN_BINARY=${CMAKE_BINARY_DIR}/fringetwin;FRINGETWIN_SOURCE=${CMAKE_SOURCE_DIR}")
endfunction()

# fringetwin_code_digest(a.cpp files...): FRINGETWIN_CODE_DIGEST in a.cpp is a digest of the files.
function(fringetwin_code_digest source)
  set(all "")
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${file})
    file(SHA256 ${CMAKE_CURRENT_SOURCE_DIR}/${file} digest)
    string(APPEND all ${digest})
  endforeach()
  string(SHA256 all "${all}")
  set_source_files_properties(${source} PROPERTIES COMPILE_DEFINITIONS FRINGETWIN_CODE_DIGEST="${all}")
endfunction()

# GLSL -> SPIR-V -> C array NAME_spv[] in NAME_spv.h, in shaders/ of the caller's build folder.
# fringetwin_shader(NAME source.comp [defines...]) -> appends the header to ${shader_headers}
function(fringetwin_shader name source)
  set(dir ${CMAKE_CURRENT_BINARY_DIR}/shaders)
  file(MAKE_DIRECTORY ${dir})
  set(source ${CMAKE_CURRENT_SOURCE_DIR}/${source})
  set(spv ${dir}/${name}.spv)
  set(header ${dir}/${name}_spv.h)
  set(command ${GLSLANG_VALIDATOR} --quiet -V --target-env vulkan1.2 -I${CMAKE_SOURCE_DIR}/render/shaders ${ARGN})
  add_custom_command(OUTPUT ${spv} ${header}
    COMMAND ${command} --depfile ${dir}/${name}.d -o ${spv} ${source}
    COMMAND ${command} --vn ${name}_spv -o ${header} ${source}
    DEPENDS ${source}
    DEPFILE ${dir}/${name}.d
    COMMENT "Shader ${name}" VERBATIM)
  set(shader_headers ${shader_headers} ${header} PARENT_SCOPE)
  if(FRINGETWIN_TESTS)
    add_test(NAME spirv_val_${name} COMMAND ${SPIRV_VAL} --target-env vulkan1.2 ${spv})
    set_tests_properties(spirv_val_${name} PROPERTIES LABELS unit)
  endif()
endfunction()
