# The project's own three commands: fs_library, fs_program, fs_test. Warnings are errors everywhere.
option(FUSION_SLAM_BUILD_TESTS "Build the GoogleTest suites" ON)
option(FUSION_SLAM_SANITIZE "AddressSanitizer and UndefinedBehaviorSanitizer" OFF)
option(FUSION_SLAM_FUZZ "Build the libFuzzer targets below tests/fuzz, with FUSION_SLAM_SANITIZE (clang only)" OFF)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")
set(CMAKE_CXX_FLAGS_DEBUG "-O1 -g1 -D_GLIBCXX_ASSERTIONS")

find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()

add_library(fs_options INTERFACE)
target_compile_options(fs_options INTERFACE -Wall -Wextra -Werror)
target_include_directories(fs_options INTERFACE ${PROJECT_SOURCE_DIR})
# Two results may not depend on which instructions the compiler chose to fuse.
target_compile_options(fs_options INTERFACE -ffp-contract=off)
if(FUSION_SLAM_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()
if(FUSION_SLAM_FUZZ)  # the same objects serve the sanitized tests and the fuzzers
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

# fs_library(NAME SOURCES a.cpp ... [LINK lib ...])
function(fs_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC fs_options ${ARG_LINK})
endfunction()

# fs_program(NAME SOURCES main.cpp ... [LINK lib ...]): installed to libexec/fusion-slam, started by ./fusion-slam
function(fs_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE fs_options ${ARG_LINK})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/fusion-slam)
  set_property(GLOBAL APPEND PROPERTY FS_PROGRAMS ${name})
endfunction()

# fs_test(NAME SOURCES x_test.cpp ... [LINK lib ...]): one GoogleTest program, one ctest entry
function(fs_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE fs_options ${ARG_LINK} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    FS_SOURCE_DIR="${PROJECT_SOURCE_DIR}" FS_BINARY_DIR="${PROJECT_BINARY_DIR}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/tests)
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT 600)
endfunction()
