# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
#
# What `cmake --install` puts where, and how other projects find it.
include(CMakePackageConfigHelpers)

install(TARGETS totalforce totalforce_static EXPORT totalforce
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(DIRECTORY include/totalforce ${CMAKE_CURRENT_BINARY_DIR}/include/totalforce
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")

# What `totalforce specialise` compiles: the sources of the kernels, as they lie here.
install(DIRECTORY dynamics interface layout model number spatial include
  DESTINATION ${CMAKE_INSTALL_DATADIR}/totalforce/sources FILES_MATCHING PATTERN "*.h" PATTERN "specialised*.c")

# The static library names what it links against by plain library names, so that a consumer needs
# neither our pkg-config modules nor their CMake targets.
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/totalforce)
configure_package_config_file(totalforce-config.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/totalforce-config.cmake INSTALL_DESTINATION ${package_dir}
  PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/totalforce-config-version.cmake
  COMPATIBILITY SameMajorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/totalforce-config.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/totalforce-config-version.cmake DESTINATION ${package_dir})

# Relative to where the file lies, so that a tree that was moved or staged works.
file(RELATIVE_PATH package_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
configure_file(totalforce.pc.in totalforce.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/totalforce.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# For colcon and the tools of ROS 2: the manifest, and the marker of the package in ament's index.
install(FILES ${PROJECT_SOURCE_DIR}/package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/totalforce)
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/ament_marker "")
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ament_marker RENAME totalforce
  DESTINATION ${CMAKE_INSTALL_DATADIR}/ament_index/resource_index/packages)
