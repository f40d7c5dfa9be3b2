# Hardening of what is built in this tree, as far as compiler, linker and processor have it; into the
# target topotag_flags, so that none of it leaks into an installed package. Where a sanitizer
# watches, only the guards on the stack: the rest is in its way, or hidden from it.

include(CheckCXXCompilerFlag)
include(CheckLinkerFlag)
include(CheckPIESupported)

target_compile_options(topotag_flags INTERFACE -fstack-protector-strong)
if(TOPOTAG_SANITIZE_LINK)
  return()
endif()
target_compile_options(topotag_flags INTERFACE -Wformat -Wformat-security)

# Programs that are loaded anywhere in memory: with the property POSITION_INDEPENDENT_CODE, which
# without this check is one of the compiler alone, not of the linker.
check_pie_supported(LANGUAGES CXX)

# The second is x86's, the third 64-bit Arm's: instructions that older processors skip.
foreach(flag -fstack-clash-protection -fcf-protection -mbranch-protection=standard)
  string(MAKE_C_IDENTIFIER "TOPOTAG_COMPILER_HAS${flag}" has_flag)
  check_cxx_compiler_flag(${flag} ${has_flag})
  if(${has_flag})
    target_compile_options(topotag_flags INTERFACE ${flag})
  endif()
endforeach()

# Tables of addresses are read-only once all of them are resolved, at the start; no stack is
# executable; no library is loaded that nothing calls.
foreach(flag -Wl,-z,relro -Wl,-z,now -Wl,-z,noexecstack -Wl,--as-needed)
  string(MAKE_C_IDENTIFIER "TOPOTAG_LINKER_HAS${flag}" has_flag)
  check_linker_flag(CXX ${flag} ${has_flag})
  if(${has_flag})
    target_link_options(topotag_flags INTERFACE ${flag})
  endif()
endforeach()

# Needs an optimised build. Options, not definitions: CMake puts definitions first, where the -U
# would undo them.
set(topotag_optimised $<CONFIG:Release,RelWithDebInfo,MinSizeRel>)
target_compile_options(topotag_flags INTERFACE
  $<${topotag_optimised}:-U_FORTIFY_SOURCE> $<${topotag_optimised}:-D_FORTIFY_SOURCE=2>)
