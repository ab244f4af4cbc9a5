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

# soak_room(ROOM [TARGET name] DEPENDS libs...): static library soak_ROOM from all sources of the current folder.
function(soak_room room)
  cmake_parse_arguments(arg "" "TARGET" "DEPENDS;EXCLUDE" ${ARGN})
  if(NOT arg_TARGET)
    set(arg_TARGET soak_${room})
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/main_[a-z_]+\\.cpp$")
  if(arg_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX "${arg_EXCLUDE}")
  endif()
  add_library(${arg_TARGET} STATIC ${sources})
  target_link_libraries(${arg_TARGET} PUBLIC soak_options ${arg_DEPENDS})
  soak_launcher(${arg_TARGET} ${room})
endfunction()

# soak_program(NAME ROOM SOURCE DEPENDS libs...): a program whose main stands in SOURCE.
function(soak_program name room source)
  cmake_parse_arguments(arg "" "" "DEPENDS" ${ARGN})
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE soak_options ${arg_DEPENDS})
  soak_launcher(${name} ${room})
endfunction()
