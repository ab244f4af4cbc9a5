# SPDX-License-Identifier: Apache-2.0
# Two Debian packages (./run package): soak, the station, and libsoak-dev, what others can take from here (SoakInstall.cmake).
install(TARGETS soak soakd soaksim soaksim-truth soaksim-campaign RUNTIME DESTINATION bin COMPONENT station)
install(PROGRAMS packaging/soak-demo DESTINATION bin COMPONENT station)
install(DIRECTORY procedures DESTINATION share/soak COMPONENT station FILES_MATCHING PATTERN "*.toml" PATTERN "*.md" PATTERN "*.sbatch")
install(FILES tools/demo.py tools/lab_session.py DESTINATION share/soak/tools COMPONENT station)
install(DIRECTORY tests/cli/blob_reader DESTINATION share/soak/tests/cli COMPONENT station FILES_MATCHING PATTERN "*.py")
install(FILES hal/sim/lab.toml DESTINATION share/soak COMPONENT station)
install(FILES packaging/grafana/soak.json DESTINATION share/soak/grafana COMPONENT station)
install(FILES packaging/systemd/soakd.service packaging/systemd/soakd-alarm.service DESTINATION lib/systemd/system COMPONENT station)
install(FILES packaging/udev/60-soak.rules DESTINATION lib/udev/rules.d COMPONENT station)
install(DIRECTORY docs DESTINATION share/doc/soak COMPONENT station)
install(FILES README.md CHANGELOG.md DESTINATION share/doc/soak COMPONENT station)
# Made from the programs' own help (tools/command_pages.py) by ./run package.
set(SOAK_COMMAND_PAGES ${CMAKE_BINARY_DIR}/command_pages)
install(DIRECTORY ${SOAK_COMMAND_PAGES}/man1 DESTINATION share/man COMPONENT station OPTIONAL)
install(FILES ${SOAK_COMMAND_PAGES}/soak.bash DESTINATION share/bash-completion/completions RENAME soak COMPONENT station OPTIONAL)
install(FILES ${SOAK_COMMAND_PAGES}/station.toml DESTINATION /etc/soak COMPONENT station OPTIONAL)
foreach(component station library)
  set(package soak)
  if(component STREQUAL library)
    set(package libsoak-dev)
  endif()
  install(FILES packaging/debian/copyright DESTINATION share/doc/${package} COMPONENT ${component})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "Soak <soak@localhost>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL station library)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_STATION_PACKAGE_NAME soak)
# What follows the project's own description, which is the synopsis of both.
set(CPACK_DEBIAN_STATION_DESCRIPTION "A daemon drives a temperature chamber over Modbus, walks inertial units through
six positions at each temperature and records them; a thermal model per sensor
is fitted with its uncertainty and exported as a calibration file per unit.
With a simulated laboratory: soak-demo.")
set(CPACK_DEBIAN_STATION_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_STATION_PACKAGE_DEPENDS "adduser, python3")
set(CPACK_DEBIAN_STATION_PACKAGE_RECOMMENDS "systemd, udev, man-db")
set(CPACK_DEBIAN_STATION_PACKAGE_SUGGESTS "rclone")
set(CPACK_DEBIAN_STATION_PACKAGE_CONTROL_EXTRA
  "${CMAKE_SOURCE_DIR}/packaging/debian/preinst;${CMAKE_SOURCE_DIR}/packaging/debian/postinst;${CMAKE_SOURCE_DIR}/packaging/debian/prerm;${CMAKE_SOURCE_DIR}/packaging/debian/postrm;${CMAKE_SOURCE_DIR}/packaging/debian/conffiles")
set(CPACK_DEBIAN_STATION_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libsoak-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "Its libraries for projects of your own: soak::anfis and soak::signal, static, and
the C99 header soak::runtime, which reads calibration files on a
microcontroller; CMake package soak.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libeigen3-dev, libexpected-dev, libfmt-dev, libnlopt-dev, nlohmann-json3-dev")
include(CPack)
