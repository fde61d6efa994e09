# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# mrcal ships no config file of its own. Defines mrcal::mrcal.
find_path(Mrcal_INCLUDE_DIR mrcal/mrcal.h)
find_library(Mrcal_LIBRARY mrcal)
mark_as_advanced(Mrcal_INCLUDE_DIR Mrcal_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Mrcal REQUIRED_VARS Mrcal_LIBRARY Mrcal_INCLUDE_DIR)

if(Mrcal_FOUND AND NOT TARGET mrcal::mrcal)
  add_library(mrcal::mrcal UNKNOWN IMPORTED)
  set_target_properties(mrcal::mrcal PROPERTIES
    IMPORTED_LOCATION ${Mrcal_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${Mrcal_INCLUDE_DIR})
endif()
