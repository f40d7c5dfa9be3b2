# ctest entries for the installed package; every step works on one installed copy.

set(install_work_dir ${CMAKE_CURRENT_BINARY_DIR}/install_check)

function(topotag_install_step step)
  add_test(NAME Install.${step}
    COMMAND ${CMAKE_COMMAND}
      -DSTEP=${step}
      -DBUILD_DIR=${PROJECT_BINARY_DIR}
      -DWORK_DIR=${install_work_dir}
      -DCXX=${CMAKE_CXX_COMPILER}
      -DGENERATOR=${CMAKE_GENERATOR}
      -DCONFIG=$<CONFIG>
      -DIO=$<BOOL:${TOPOTAG_BUILD_IO}>
      -P ${CMAKE_CURRENT_SOURCE_DIR}/install/check.cmake)
  set_tests_properties(Install.${step} PROPERTIES TIMEOUT 300 ${ARGN})
endfunction()

topotag_install_step(install FIXTURES_SETUP installed_copy)
topotag_install_step(find_package
  FIXTURES_REQUIRED installed_copy FIXTURES_SETUP installed_consumer)
topotag_install_step(links FIXTURES_REQUIRED installed_copy)
set_property(TEST Install.links APPEND PROPERTY FIXTURES_REQUIRED installed_consumer)
topotag_install_step(pkg_config FIXTURES_REQUIRED installed_copy)
if(TOPOTAG_BUILD_IO)
  topotag_install_step(io FIXTURES_REQUIRED installed_copy)
else()
  topotag_install_step(no_io FIXTURES_REQUIRED installed_copy
    PASS_REGULAR_EXPRESSION "topotag was built without its component io")
endif()
