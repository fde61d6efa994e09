# SPDX-FileCopyrightText: The Raybundle authors
# SPDX-License-Identifier: Apache-2.0

# Installs the build into an empty prefix, then builds and runs programs that use it by find_package(Raybundle).
# cmake -DBUILD=<build folder> -DCONSUMER=<its sources> -DWORK=<scratch folder> -DARGUMENTS=<for cmake> -P this file
function(run)
  execute_process(COMMAND ${ARGV} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(run_consumer name sources)
  run(${CMAKE_COMMAND} -S ${sources} -B ${WORK}/${name} -DCMAKE_PREFIX_PATH=${WORK}/prefix ${ARGUMENTS} ${ARGN})
  run(${CMAKE_COMMAND} --build ${WORK}/${name})
  run(${WORK}/${name}/consumer)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run_consumer(all ${CONSUMER})

# The installed program finds the library that it loads.
execute_process(COMMAND ${WORK}/prefix/bin/raybundle doctor OUTPUT_VARIABLE told COMMAND_ERROR_IS_FATAL ANY)
if(told MATCHES "libraybundle_media")
  message(FATAL_ERROR ${told})
endif()

# Whoever wants the core alone needs nothing of what reads images and renders.
set(others OpenCV embree AprilTag tomlplusplus)
list(TRANSFORM others REPLACE "(.+)" "-DCMAKE_DISABLE_FIND_PACKAGE_\\1=ON")
run_consumer(core ${CONSUMER}/core ${others})
