# One INTERFACE target carries every flag for this project's own code.
option(HYSTCAN_WERROR "Treat warnings as errors" OFF)
set(HYSTCAN_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined or thread")
option(HYSTCAN_FUZZ "Build the fuzz targets with libFuzzer, and the rooms for it (needs clang)" OFF)

option(HYSTCAN_UNITY "Compile several sources of a room as one, which spares reading the same headers for each" ON)
option(HYSTCAN_COVERAGE "Count in the rooms what runs and which conditions decide (needs clang 18 or newer)" OFF)
set(HYSTCAN_ALONE "" CACHE STRING "Rooms whose sources are compiled one by one all the same, e.g. control;can")

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)  # the Python module is a shared library of the same rooms
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # The result of a compilation does not depend on the folder of the tree, nor on LC_ALL, which debhelper sets.
  # Precompiled headers need the sloppiness.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env --unset=LC_ALL CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1
    CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()

add_library(hystcan_flags INTERFACE)
target_compile_features(hystcan_flags INTERFACE cxx_std_20)
target_include_directories(hystcan_flags INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
set(own_flags -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual -fno-math-errno -fno-semantic-interposition)
# The same seed gives the same bits on every processor. The x86-64 baseline cannot fuse a multiplication with an addition.
if(NOT CMAKE_SYSTEM_PROCESSOR STREQUAL x86_64 OR CMAKE_CXX_FLAGS MATCHES "-m(arch|fma)")
  list(APPEND own_flags -ffp-contract=off)
endif()
# On arm64, GCC reports every pair that C++17 passes in other registers than GCC 9 did.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL aarch64 AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  list(APPEND own_flags -Wno-psabi)
endif()
if(HYSTCAN_WERROR)
  list(APPEND own_flags -Werror)
endif()
target_compile_options(hystcan_flags INTERFACE "$<BUILD_INTERFACE:${own_flags}>")
# GCC 12 reports overlapping copies in std::string's operator+ that do not exist (GCC bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(hystcan_flags INTERFACE $<BUILD_INTERFACE:-Wno-restrict>)
endif()

if(HYSTCAN_SANITIZE)
  add_compile_options(-fsanitize=${HYSTCAN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${HYSTCAN_SANITIZE})
  if(HYSTCAN_SANITIZE MATCHES thread AND CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-Wno-tsan)  # the thread sanitizer does not follow Asio's fences; our data does not need them
  endif()
endif()

if(HYSTCAN_COVERAGE)
  add_link_options(-fprofile-instr-generate)
endif()

# add_room(NAME SOURCES...): adds the static library hystcan_NAME of one room.
function(add_room name)
  add_library(hystcan_${name} STATIC ${ARGN})
  target_link_libraries(hystcan_${name} PUBLIC hystcan_flags)
  set_target_properties(hystcan_${name} PROPERTIES UNITY_BUILD ${HYSTCAN_UNITY} UNITY_BUILD_BATCH_SIZE 16)
  if(name IN_LIST HYSTCAN_ALONE)
    set_target_properties(hystcan_${name} PROPERTIES UNITY_BUILD OFF)
  endif()
  if(HYSTCAN_FUZZ)
    target_compile_options(hystcan_${name} PRIVATE -fsanitize=fuzzer-no-link)
  endif()
  if(HYSTCAN_COVERAGE)
    target_compile_options(hystcan_${name} PRIVATE -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc)
  endif()
endfunction()

# add_to_room(NAME SOURCES...): adds sources of a sub-folder of this room.
function(add_to_room name)
  target_sources(hystcan_${name} PRIVATE ${ARGN})
endfunction()
