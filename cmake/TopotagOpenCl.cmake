# The opencl backend of the library topotag.

# In the order in which they are compiled.
set(topotag_kernels
  ${PROJECT_SOURCE_DIR}/kernels/pixels.cl
  ${PROJECT_SOURCE_DIR}/kernels/threshold.cl
  ${PROJECT_SOURCE_DIR}/kernels/binarize.cl)
set(topotag_embedded ${PROJECT_BINARY_DIR}/kernels/embedded.cc)
add_custom_command(OUTPUT ${topotag_embedded}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${topotag_embedded} "-DKERNELS=${topotag_kernels}"
    -P ${PROJECT_SOURCE_DIR}/cmake/EmbedKernels.cmake
  DEPENDS ${topotag_kernels} ${PROJECT_SOURCE_DIR}/cmake/EmbedKernels.cmake
  VERBATIM)

target_sources(topotag PRIVATE
  ${topotag_embedded}
  kernels/binarizer.cc
  kernels/buffer_frames.cc
  kernels/cache_file.cc
  kernels/check.cc
  kernels/device.cc
  kernels/frame_slot.cc
  kernels/opencl.cc
  kernels/opencl_backend.cc
  kernels/program.cc)
target_compile_definitions(topotag PRIVATE TOPOTAG_HAVE_OPENCL CL_TARGET_OPENCL_VERSION=120)
target_link_libraries(topotag PRIVATE OpenCL::OpenCL)
