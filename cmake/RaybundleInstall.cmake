# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# What `cmake --install` puts in place, so that find_package(Raybundle) gives consumers raybundle::calibrate and the
# other modules. The modules' own libraries and headers are installed where they are declared (RaybundleModule).
include(CMakePackageConfigHelpers)

set(package_folder lib/cmake/Raybundle)
install(EXPORT RaybundleTargets NAMESPACE raybundle:: DESTINATION ${package_folder})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/RaybundleConfig.cmake.in
  ${PROJECT_BINARY_DIR}/RaybundleConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/RaybundleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/RaybundleConfig.cmake ${PROJECT_BINARY_DIR}/RaybundleConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/RaybundleDependencies.cmake ${CMAKE_CURRENT_LIST_DIR}/FindAprilTag.cmake
  ${CMAKE_CURRENT_LIST_DIR}/FindMrcal.cmake ${CMAKE_CURRENT_LIST_DIR}/FindGeographicLib.cmake
  DESTINATION ${package_folder})

install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION share/doc/raybundle)
