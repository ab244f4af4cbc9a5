# SPDX-License-Identifier: Apache-2.0
# Language level, warnings and sanitizers for all targets. The reasons stand in docs/decisions/0001-build.md.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
set(CMAKE_C_FLAGS_RELEASE "-O2")
set(CMAKE_CXX_FLAGS_DEBUG "-O0 -g")

set(SOAK_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread")
option(SOAK_SANITIZE_ALL "Sanitize the pure rooms too, not only what handles bytes, files, threads and devices" OFF)
option(SOAK_UNITY "Compile each room in batches of sources: the quickest way to all programs, the slowest to one changed file" ON)

# Warnings and the language, for every target.
add_library(soak_options INTERFACE)
target_include_directories(soak_options INTERFACE ${CMAKE_SOURCE_DIR})
# Contraction of a*b+c differs between instruction sets: without this flag no two machines agree to the last bit.
target_compile_options(soak_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Werror -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 reports overlaps in std::string concatenation that do not exist.
  target_compile_options(soak_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>)
  # g++ collects its garbage from 128 MB on, again and again: left to grow to 1 GB it compiles a batch in 9/10 of the time.
  target_compile_options(soak_options INTERFACE $<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=1000000>)
endif()

# What a sanitized target is compiled with. All programs of such a tree are linked with the sanitizers' runtime.
add_library(soak_sanitized INTERFACE)
if(SOAK_SANITIZE)
  target_compile_options(soak_sanitized INTERFACE -fsanitize=${SOAK_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -O1 -g1)
  # Checks of each pointer before it is followed cost 30 % of the compilation, those of its arithmetic as much again, and at
  # each start of a program. AddressSanitizer reports null pointers and what lies beyond an object all the same; alignment
  # and pointer arithmetic are checked in C, for microcontrollers, and in rooms that read bytes of wires and files.
  target_compile_options(soak_sanitized INTERFACE -fno-sanitize=null
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<NOT:$<BOOL:$<TARGET_PROPERTY:SOAK_CHECK_ALIGNMENT>>>>:-fno-sanitize=alignment,pointer-overflow>)
  target_link_options(soak_options INTERFACE -fsanitize=${SOAK_SANITIZE})
  # Eigen would align memory by itself under AddressSanitizer, and memory passes between sanitized rooms and others.
  target_compile_definitions(soak_sanitized INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(soak_sanitized INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-maybe-uninitialized>)
  endif()
endif()

find_program(SOAK_CCACHE ccache)
# Debian's own interpreter: it has the modules that the tests need, whatever else stands first in PATH.
if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python3 REQUIRED COMPONENTS Interpreter)
