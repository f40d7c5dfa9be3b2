# Uses topotag as an outside project would.
#   cmake -DSTEP=... -DBUILD_DIR=... -DWORK_DIR=... -P check.cmake
# STEP install: installs BUILD_DIR, then moves the tree: an installed copy must be relocatable.
#   With -DIO=ON|OFF the presence of the headers of component io is checked too.
# STEP find_package, io, pkg_config: builds the consumer beside this file and runs it.
#   -DCXX=... is the compiler, -DCONFIG=... the build type, -DGENERATOR=... CMake's generator.
# STEP links: the consumer of the core is linked with nothing that only component io needs.
# STEP no_io: fails with the package's own message where component io was not built.

cmake_minimum_required(VERSION 3.20)
set(prefix "${WORK_DIR}/prefix")

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "failed (${result}): ${command}")
  endif()
endfunction()

function(build_consumer folder)
  file(REMOVE_RECURSE "${WORK_DIR}/${folder}")
  run("${CMAKE_COMMAND}" -S "${CMAKE_CURRENT_LIST_DIR}" -B "${WORK_DIR}/${folder}"
    -G "${GENERATOR}"
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DCMAKE_BUILD_TYPE=${CONFIG}" "-DCMAKE_PREFIX_PATH=${prefix}"
    -DCMAKE_FIND_USE_PACKAGE_REGISTRY=OFF ${ARGN})
  run("${CMAKE_COMMAND}" --build "${WORK_DIR}/${folder}" --config "${CONFIG}")
endfunction()

if(STEP STREQUAL "install")
  file(REMOVE_RECURSE "${prefix}" "${WORK_DIR}/staging")
  run("${CMAKE_COMMAND}" --install "${BUILD_DIR}" --config "${CONFIG}"
    --prefix "${WORK_DIR}/staging")
  file(RENAME "${WORK_DIR}/staging" "${prefix}")
  foreach(header detector.h renderer.h opencv.h)
    if(NOT EXISTS "${prefix}/include/topotag/${header}")
      message(FATAL_ERROR "${header} is not installed")
    endif()
  endforeach()
  foreach(header camera_file.h generator.h image_file.h)
    if(IO AND NOT EXISTS "${prefix}/include/topotag/${header}")
      message(FATAL_ERROR "${header} is not installed")
    elseif(NOT IO AND EXISTS "${prefix}/include/topotag/${header}")
      message(FATAL_ERROR "${header} is installed without component io")
    endif()
  endforeach()

elseif(STEP STREQUAL "find_package")
  build_consumer(find_package)
  run("${WORK_DIR}/find_package/consumer")

elseif(STEP STREQUAL "io")
  build_consumer(io -DCONSUMER_IO=ON)
  run("${WORK_DIR}/io/consumer_io" "${WORK_DIR}/io")

elseif(STEP STREQUAL "no_io")
  build_consumer(no_io -DCONSUMER_IO=ON)

elseif(STEP STREQUAL "pkg_config")
  file(GLOB_RECURSE pc "${prefix}/*/topotag.pc")
  if(NOT pc)
    message(FATAL_ERROR "topotag.pc is not installed under ${prefix}")
  endif()
  cmake_path(GET pc PARENT_PATH pc_dir)
  set(ENV{PKG_CONFIG_PATH} "${pc_dir}")
  execute_process(COMMAND pkg-config --cflags --libs --static topotag
    RESULT_VARIABLE result OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "pkg-config does not find topotag in ${pc_dir}")
  endif()
  message(STATUS "pkg-config --cflags --libs --static topotag: ${flags}")
  separate_arguments(flags UNIX_COMMAND "${flags}")
  set(program "${WORK_DIR}/pkg_config_consumer")
  file(REMOVE "${program}")
  run("${CXX}" -std=c++17 -O1 "${CMAKE_CURRENT_LIST_DIR}/main.cc" -o "${program}" ${flags})
  cmake_path(GET pc_dir PARENT_PATH lib_dir)
  set(ENV{LD_LIBRARY_PATH} "${lib_dir}")
  run("${program}")

elseif(STEP STREQUAL "links")
  execute_process(COMMAND ldd "${WORK_DIR}/find_package/consumer"
    RESULT_VARIABLE result OUTPUT_VARIABLE libraries)
  message(STATUS "the consumer is linked with\n${libraries}")
  if(NOT result EQUAL 0 OR NOT libraries MATCHES "libstdc\\+\\+|libc\\+\\+")
    message(FATAL_ERROR "ldd does not list the consumer's libraries")
  endif()
  if(libraries MATCHES "not found")
    message(FATAL_ERROR "a library of the consumer is not found")
  endif()
  if(libraries MATCHES "lib(opencv|pocl|yaml|cairo|png|jpeg|webp|topotag_io)[^ ]*")
    message(FATAL_ERROR "a consumer of the core is linked with ${CMAKE_MATCH_0}")
  endif()

else()
  message(FATAL_ERROR "unknown STEP \"${STEP}\"")
endif()
