# Writes a C++ file that holds the OpenCL sources byte for byte:
#   cmake -DOUTPUT=FILE -DKERNELS=a.cl;b.cl -P EmbedKernels.cmake
# The order of the list is the order in which the device compiles them.

set(arrays "")
set(table "")
foreach(path IN LISTS KERNELS)
  get_filename_component(name ${path} NAME)
  string(MAKE_C_IDENTIFIER ${name} identifier)
  file(READ ${path} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  string(APPEND arrays "const unsigned char k_${identifier}[] = {${bytes}};\n")
  string(APPEND table "    {\"${name}\", reinterpret_cast<const char*>(k_${identifier}),\n"
    "     sizeof(k_${identifier})},\n")
endforeach()
file(WRITE ${OUTPUT}
"#include \"kernels/embedded.h\"

namespace topotag::opencl {
namespace {

${arrays}
const KernelFile kFiles[] = {
${table}};

}  // namespace

const KernelFile* const kKernelFiles = kFiles;
const size_t kKernelFileCount = sizeof(kFiles) / sizeof(kFiles[0]);

}  // namespace topotag::opencl
")
