# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# What the installed libraries need, by the folders that they come from: our build and the package that consumers find
# both read this list. Our build needs all of it, as do consumers who name no components. What only the program or the
# tests need is found in their folders.
set(Raybundle_COMPONENTS core runtime targets simulator)
set(Raybundle_WANTED ${Raybundle_FIND_COMPONENTS})
if(NOT Raybundle_WANTED)
  set(Raybundle_WANTED ${Raybundle_COMPONENTS})
endif()

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED)
find_package(GeographicLib REQUIRED)
if("core" IN_LIST Raybundle_WANTED)  # calib_core
  find_package(fmt REQUIRED)
  find_package(nlohmann_json REQUIRED)
  find_package(yaml-cpp REQUIRED)
  find_package(tomlplusplus QUIET)  # of raybundle::toml alone
  find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)  # SHA-256
  find_package(Mrcal ${Raybundle_MRCAL})  # optional for our build: a second opinion on calibrations
endif()
if("targets" IN_LIST Raybundle_WANTED)
  find_package(OpenCV 4.6 REQUIRED COMPONENTS core imgproc calib3d features2d aruco objdetect)
  find_package(AprilTag REQUIRED)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(cairo REQUIRED IMPORTED_TARGET cairo)
  find_package(fmt REQUIRED)
  find_package(tomlplusplus REQUIRED)
endif()
if("simulator" IN_LIST Raybundle_WANTED)  # datasets
  find_package(embree 3.13 REQUIRED)
  find_package(fmt REQUIRED)
  find_package(tomlplusplus REQUIRED)
endif()
