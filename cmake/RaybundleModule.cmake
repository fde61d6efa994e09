# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# How every target of the project is compiled; PRIVATE, so that consumers keep their own flags.
add_library(raybundle_flags INTERFACE)
target_compile_features(raybundle_flags INTERFACE cxx_std_20)
target_compile_options(raybundle_flags INTERFACE -Wall -Wextra -Wconversion -Wno-sign-conversion -Werror)
# GCC 12 sees overlaps in `"text" + std::string` that are not there (GCC bug 105651), and overflows where it reads the
# strings' header precompiled.
target_compile_options(raybundle_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(NOT CMAKE_DISABLE_PRECOMPILE_HEADERS)
  set(overflows -Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread)
  target_compile_options(raybundle_flags INTERFACE "$<$<CXX_COMPILER_ID:GNU>:${overflows}>")
endif()
# Clang has no `#pragma GCC ivdep`, which only helps.
target_compile_options(raybundle_flags INTERFACE $<$<CXX_COMPILER_ID:Clang>:-Wno-unknown-pragmas>)
# Results have the same bits on every processor: none fuses a multiplication and an addition where another cannot. Nobody
# asks mathematical functions for errno, or for floating-point traps, and without them square roots and choices are single
# instructions, of several numbers at once.
target_compile_options(raybundle_flags INTERFACE -ffp-contract=off -fno-math-errno -fno-trapping-math)

# Reading Eigen takes longer than compiling most files that include it, so it is read once for all libraries. Every file
# includes what it uses all the same: the presets other than release read each header where it stands.
file(CONFIGURE OUTPUT no_source.cpp CONTENT "")  # a library has to have one
add_library(raybundle_precompiled OBJECT ${PROJECT_BINARY_DIR}/no_source.cpp)
target_link_libraries(raybundle_precompiled PRIVATE raybundle_flags Eigen3::Eigen)
set_target_properties(raybundle_precompiled PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_precompile_headers(raybundle_precompiled PRIVATE <Eigen/Dense>
  <algorithm> <array> <cmath> <functional> <map> <optional> <set> <span> <string> <vector>)

# raybundle_module(<name> PUBLIC <libraries in our headers> PRIVATE <libraries in our sources>)
# One library for the folder that calls it: headers in include/, sources in src/, alias raybundle::<name>.
function(raybundle_module name)
  cmake_parse_arguments(arg "" "" "PUBLIC;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS src/*.cpp)
  set(library raybundle_${name})
  if(sources)
    set(scope PUBLIC)
    add_library(${library} STATIC ${sources})
    set_target_properties(${library} PROPERTIES POSITION_INDEPENDENT_CODE ON)
    target_link_libraries(${library} PRIVATE $<BUILD_INTERFACE:raybundle_flags> ${arg_PRIVATE})
    target_precompile_headers(${library} REUSE_FROM raybundle_precompiled)
  else()
    set(scope INTERFACE)
    add_library(${library} INTERFACE)
  endif()
  add_library(raybundle::${name} ALIAS ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(${library} ${scope} cxx_std_20)
  target_include_directories(${library} ${scope}
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
  target_link_libraries(${library} ${scope} ${arg_PUBLIC})
  install(TARGETS ${library} EXPORT RaybundleTargets)
  install(DIRECTORY include/ DESTINATION include)
endfunction()
