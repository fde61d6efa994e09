# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# How every target of the project is compiled; PRIVATE, so that consumers keep their own flags.
add_library(raybundle_flags INTERFACE)
target_compile_features(raybundle_flags INTERFACE cxx_std_20)
target_compile_options(raybundle_flags INTERFACE -Wall -Wextra -Wconversion -Wno-sign-conversion -Werror)
# GCC 12 sees overlaps in `"text" + std::string` that are not there (GCC bug 105651).
target_compile_options(raybundle_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
# Clang has no `#pragma GCC ivdep`, which only helps.
target_compile_options(raybundle_flags INTERFACE $<$<CXX_COMPILER_ID:Clang>:-Wno-unknown-pragmas>)

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
