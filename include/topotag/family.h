#ifndef TOPOTAG_FAMILY_H_
#define TOPOTAG_FAMILY_H_

#include <cstdint>
#include <string>
#include <vector>

namespace topotag {

/// An n x n TopoTag family, n = 3 .. 8. Every ID below size() is valid: no bit is spent on
/// error detection.
class Family {
 public:
  static constexpr int kMinN = 3;
  static constexpr int kMaxN = 8;

  /// @throws Error (kInvalidArgument) unless 3 <= n <= 8.
  explicit Family(int n);
  /// "3x3" .. "8x8".
  /// @throws Error (kInvalidArgument) that lists the families.
  static Family Parse(const std::string& name);
  /// Comma-separated names without repetition, e.g. "3x3,4x4".
  static std::vector<Family> ParseList(const std::string& names);

  int n() const { return n_; }
  std::string name() const;
  int bits() const { return n_ * n_ - 2; }
  uint64_t size() const { return uint64_t{1} << bits(); }  ///< number of IDs
  int node_count() const { return n_ * n_ - 1; }  ///< black nodes, the baseline node counted once
  int vertex_count() const { return n_ * n_; }
  int white_side() const { return 4 * n_ + 1; }  ///< side of the white area, in units

 private:
  int n_;
};

inline constexpr int kMaxVertices = Family::kMaxN * Family::kMaxN;

inline bool operator==(Family a, Family b) { return a.n() == b.n(); }
inline bool operator<(Family a, Family b) { return a.n() < b.n(); }

}  // namespace topotag

#endif  // TOPOTAG_FAMILY_H_
