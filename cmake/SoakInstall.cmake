# SPDX-License-Identifier: Apache-2.0
# What others can take from here: cmake --install BUILD --component library --prefix DIR, then find_package(soak) gives
#   soak::anfis     Takagi-Sugeno systems and their learning      #include "anfis/train/learner.h"
#   soak::signal    wavelets, Allan deviations, spectra           #include "calib/signal/allan/allan.h"
#   soak::runtime   the C99 reader of calibration files           #include "calib/runtime/soak_runtime.h"
include(CMakePackageConfigHelpers)

add_library(soak_runtime INTERFACE)
target_include_directories(soak_runtime INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/soak>)

foreach(name base linear anfis signal runtime)
  set_target_properties(soak_${name} PROPERTIES EXPORT_NAME ${name})
endforeach()
install(TARGETS soak_base soak_linear soak_anfis soak_signal soak_runtime EXPORT soak_targets ARCHIVE DESTINATION lib COMPONENT library)
install(EXPORT soak_targets NAMESPACE soak:: FILE soakTargets.cmake DESTINATION lib/cmake/soak COMPONENT library)
install(DIRECTORY base anfis DESTINATION include/soak COMPONENT library FILES_MATCHING PATTERN "*.h" PATTERN detail EXCLUDE)
install(DIRECTORY calib/signal calib/runtime DESTINATION include/soak/calib COMPONENT library
        FILES_MATCHING PATTERN "*.h" PATTERN detail EXCLUDE)

configure_package_config_file(cmake/soakConfig.cmake.in ${CMAKE_BINARY_DIR}/soakConfig.cmake INSTALL_DESTINATION lib/cmake/soak)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/soakConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/soakConfig.cmake ${CMAKE_BINARY_DIR}/soakConfigVersion.cmake DESTINATION lib/cmake/soak
        COMPONENT library)
