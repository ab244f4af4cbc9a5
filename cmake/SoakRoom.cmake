# SPDX-License-Identifier: Apache-2.0
# One target per room. Every compilation goes through tools/room_check.py, which reads the dependency file that the
# compiler has just written and fails the compilation if it names a header that cmake/rooms.toml does not allow the room.

# soak_launcher(TARGET ROOM): compile TARGET under the include rules of ROOM.
function(soak_launcher target room)
  set(launcher ${Python3_EXECUTABLE} ${CMAKE_SOURCE_DIR}/tools/room_check.py --room ${room} --)
  if(SOAK_CCACHE)
    list(APPEND launcher ${SOAK_CCACHE})
  endif()
  set_target_properties(${target} PROPERTIES C_COMPILER_LAUNCHER "${launcher}" CXX_COMPILER_LAUNCHER "${launcher}")
endfunction()

# soak_room(ROOM [TARGET name] [PURE] [BATCH n] DEPENDS libs... [ONLY regex] [EXCLUDE regex]): static library soak_ROOM from all
# sources of the current folder. PURE (numbers in, numbers out): sanitized only where SOAK_SANITIZE_ALL asks for it. BATCH: sources
# per compilation where SOAK_UNITY is on, for rooms in which reading the headers takes most of the time.
function(soak_room room)
  cmake_parse_arguments(arg "PURE" "TARGET;BATCH;EXCLUDE;ONLY" "DEPENDS" ${ARGN})
  if(NOT arg_TARGET)
    set(arg_TARGET soak_${room})
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main_[a-z_]+\\.cpp$")
  if(arg_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX "${arg_EXCLUDE}")
  endif()
  if(arg_ONLY)
    list(FILTER sources INCLUDE REGEX "${arg_ONLY}")
  endif()
  add_library(${arg_TARGET} STATIC ${sources})
  target_compile_features(${arg_TARGET} PUBLIC cxx_std_20)
  target_link_libraries(${arg_TARGET} PUBLIC ${arg_DEPENDS} PRIVATE $<BUILD_INTERFACE:soak_options>)
  target_include_directories(${arg_TARGET} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/soak>)
  if(NOT arg_PURE OR SOAK_SANITIZE_ALL)
    target_link_libraries(${arg_TARGET} PRIVATE $<BUILD_INTERFACE:soak_sanitized>)
  endif()
  if(SOAK_UNITY AND arg_BATCH)
    set_target_properties(${arg_TARGET} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${arg_BATCH})
    # In a batch g++ takes sources for headers: classes defined in a source may have members of anonymous types.
    target_compile_options(${arg_TARGET} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
  endif()
  soak_launcher(${arg_TARGET} ${room})
endfunction()

# soak_program(NAME ROOM SOURCE DEPENDS libs...): a program whose main stands in SOURCE.
function(soak_program name room source)
  cmake_parse_arguments(arg "" "" "DEPENDS" ${ARGN})
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE soak_options soak_sanitized ${arg_DEPENDS})
  soak_launcher(${name} ${room})
endfunction()
