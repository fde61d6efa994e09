# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# AprilTag 3 ships no CMake package on Debian. Provides AprilTag::AprilTag for <apriltag/apriltag.h>.
find_path(AprilTag_INCLUDE_DIR apriltag/apriltag.h)
find_library(AprilTag_LIBRARY apriltag)
mark_as_advanced(AprilTag_INCLUDE_DIR AprilTag_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(AprilTag REQUIRED_VARS AprilTag_LIBRARY AprilTag_INCLUDE_DIR)

if(AprilTag_FOUND AND NOT TARGET AprilTag::AprilTag)
  add_library(AprilTag::AprilTag UNKNOWN IMPORTED)
  set_target_properties(AprilTag::AprilTag PROPERTIES
    IMPORTED_LOCATION ${AprilTag_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${AprilTag_INCLUDE_DIR})
endif()
