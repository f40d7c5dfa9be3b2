#ifndef TOPOTAG_BENCH_PAGE_H_
#define TOPOTAG_BENCH_PAGE_H_

#include <nlohmann/json.hpp>
#include <string>

namespace topotag::bench {

/// A profile as one self-contained HTML page.
/// @param profile  {"machine", "backends", "missing", "peers_used", "scenes", "stages", "pixels",
///                 "markers", "peers", "throughput", "opencl_start"}; the sections as in
///                 profile_sections.h.
std::string MakePage(const nlohmann::ordered_json& profile);

}  // namespace topotag::bench

#endif  // TOPOTAG_BENCH_PAGE_H_
