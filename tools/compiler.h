#ifndef TOPOTAG_TOOLS_COMPILER_H_
#define TOPOTAG_TOOLS_COMPILER_H_

namespace topotag {

/// Name and version of the compiler of this build.
#if defined(__clang__)
inline constexpr char kCompiler[] = "Clang " __clang_version__;
#elif defined(__GNUC__)
inline constexpr char kCompiler[] = "GCC " __VERSION__;
#else
inline constexpr char kCompiler[] = "unknown";
#endif

}  // namespace topotag

#endif  // TOPOTAG_TOOLS_COMPILER_H_
