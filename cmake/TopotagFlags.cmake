# Compiler cache, build type, and the flags that everything built in this tree shares:
# warnings as errors, sanitizers, hardening. They live on one interface target and reach
# tests and tools through the library; none of them leaks into an installed package, except
# the sanitizer's link flag, without which a sanitized library cannot be linked at all.

option(TOPOTAG_WERROR "Treat compiler warnings as errors" OFF)
set(TOPOTAG_SANITIZE "" CACHE STRING "Sanitizer: empty, address (with undefined) or thread")
set_property(CACHE TOPOTAG_SANITIZE PROPERTY STRINGS "" address thread)

if(CMAKE_SOURCE_DIR STREQUAL PROJECT_SOURCE_DIR)
  get_property(topotag_multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
  if(NOT topotag_multi_config AND NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
  endif()
  find_program(TOPOTAG_CCACHE ccache)
  mark_as_advanced(TOPOTAG_CCACHE)
  if(TOPOTAG_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${TOPOTAG_CCACHE})
  endif()
endif()

if(TOPOTAG_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "TOPOTAG_FUZZ needs clang: libFuzzer comes with it (CMAKE_CXX_COMPILER=clang++)")
  endif()
  set(TOPOTAG_SANITIZE address)
endif()
if(TOPOTAG_SANITIZE STREQUAL "address")
  # A cast of a value that an integer cannot hold is undefined, too, but not among "undefined".
  set(TOPOTAG_SANITIZE_LINK -fsanitize=address,undefined,float-cast-overflow)
elseif(TOPOTAG_SANITIZE STREQUAL "thread")
  set(TOPOTAG_SANITIZE_LINK -fsanitize=thread)
elseif(TOPOTAG_SANITIZE STREQUAL "")
  set(TOPOTAG_SANITIZE_LINK "")
else()
  message(FATAL_ERROR "TOPOTAG_SANITIZE is \"${TOPOTAG_SANITIZE}\"; it must be address or thread")
endif()

add_library(topotag_flags INTERFACE)
if(TOPOTAG_WERROR)
  target_compile_options(topotag_flags INTERFACE -Werror)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/TopotagHardening.cmake)
# As in the library: what tests draw and compare is the same on processors that could fuse.
target_compile_options(topotag_flags INTERFACE -ffp-contract=off)
if(TOPOTAG_SANITIZE_LINK)
  target_compile_options(topotag_flags INTERFACE
    ${TOPOTAG_SANITIZE_LINK} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(topotag_flags INTERFACE ${TOPOTAG_SANITIZE_LINK})
  if(TOPOTAG_FUZZ)
    # What libFuzzer's coverage is counted by; its main comes with the targets alone.
    target_compile_options(topotag_flags INTERFACE -fsanitize=fuzzer-no-link)
  endif()
endif()
