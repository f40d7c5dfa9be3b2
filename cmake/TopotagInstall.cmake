# Installs the libraries, the public headers, the CMake package and the pkg-config file.
# The package is relocatable: nothing in it names the prefix.

include(CMakePackageConfigHelpers)

set(topotag_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/topotag)
set(topotag_io_headers camera_file.h generator.h image_file.h)

set_target_properties(topotag PROPERTIES
  VERSION ${PROJECT_VERSION}
  SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
target_link_options(topotag INTERFACE $<INSTALL_INTERFACE:${TOPOTAG_SANITIZE_LINK}>)
install(TARGETS topotag EXPORT topotagTargets)
install(EXPORT topotagTargets NAMESPACE topotag:: DESTINATION ${topotag_cmake_dir})

if(TARGET topotag_io)
  set_target_properties(topotag_io PROPERTIES
    EXPORT_NAME io
    VERSION ${PROJECT_VERSION}
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH $ORIGIN)
  install(TARGETS topotag_io EXPORT topotagIoTargets)
  install(EXPORT topotagIoTargets NAMESPACE topotag:: DESTINATION ${topotag_cmake_dir})
else()
  list(TRANSFORM topotag_io_headers REPLACE "(.+)" "PATTERN;\\1;EXCLUDE" OUTPUT_VARIABLE no_io)
endif()

if(BUILD_SHARED_LIBS AND TARGET topotag_cli)
  file(RELATIVE_PATH topotag_bin_to_lib
    /prefix/${CMAKE_INSTALL_BINDIR} /prefix/${CMAKE_INSTALL_LIBDIR})
  set_target_properties(topotag_cli PROPERTIES INSTALL_RPATH $ORIGIN/${topotag_bin_to_lib})
endif()

set(no_opencl "")
if(NOT TOPOTAG_HAVE_OPENCL)
  set(no_opencl PATTERN opencl.h EXCLUDE)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/topotag
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING ${no_io} ${no_opencl} PATTERN "*.h")

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/topotagConfig.cmake.in
  ${PROJECT_BINARY_DIR}/cmake/topotagConfig.cmake
  INSTALL_DESTINATION ${topotag_cmake_dir}
  NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(
  ${PROJECT_BINARY_DIR}/cmake/topotagConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES
  ${PROJECT_BINARY_DIR}/cmake/topotagConfig.cmake
  ${PROJECT_BINARY_DIR}/cmake/topotagConfigVersion.cmake
  DESTINATION ${topotag_cmake_dir})

# pkg-config: the prefix is found from the file's own place, so that the tree can be moved.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" OR IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  set(topotag_pc_prefix ${CMAKE_INSTALL_PREFIX})
  set(topotag_pc_libdir ${CMAKE_INSTALL_FULL_LIBDIR})
  set(topotag_pc_includedir ${CMAKE_INSTALL_FULL_INCLUDEDIR})
else()
  file(RELATIVE_PATH topotag_pc_up /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  string(REGEX REPLACE "/$" "" topotag_pc_up "${topotag_pc_up}")
  set(topotag_pc_prefix "\${pcfiledir}/${topotag_pc_up}")
  set(topotag_pc_libdir "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  set(topotag_pc_includedir "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
set(topotag_pc_private "")
set(topotag_pc_requires "")
if(NOT BUILD_SHARED_LIBS)
  set(topotag_pc_requires "Requires.private: libhwy")
  if(TOPOTAG_HAVE_OPENCL)
    string(APPEND topotag_pc_requires ", OpenCL")
  endif()
  set(topotag_pc_private -lpthread ${TOPOTAG_SANITIZE_LINK})
  # A linker driven by a C compiler does not add the C++ runtime by itself.
  foreach(library IN LISTS CMAKE_CXX_IMPLICIT_LINK_LIBRARIES)
    if(library MATCHES "^(stdc\\+\\+|c\\+\\+|m)$")
      list(APPEND topotag_pc_private -l${library})
    endif()
  endforeach()
endif()
list(JOIN topotag_pc_private " " topotag_pc_private)
configure_file(${PROJECT_SOURCE_DIR}/cmake/topotag.pc.in
  ${PROJECT_BINARY_DIR}/cmake/topotag.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/cmake/topotag.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
