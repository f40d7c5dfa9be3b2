#ifndef TOPOTAG_HOST_QUADRATURE_H_
#define TOPOTAG_HOST_QUADRATURE_H_

namespace topotag {

struct QuadratureNode {
  double position;  // in [-1, 1]
  double weight;
};
// Gauss-Legendre.
inline constexpr QuadratureNode kTwoNodes[] = {{-0.5773502691896257, 1}, {0.5773502691896257, 1}};
inline constexpr QuadratureNode kFourNodes[] = {{-0.8611363115940526, 0.3478548451374538},
                                                {-0.3399810435848563, 0.6521451548625461},
                                                {0.3399810435848563, 0.6521451548625461},
                                                {0.8611363115940526, 0.3478548451374538}};
/// Of an integrand that a Gaussian blurs: on panels of this many sigmas four nodes are right
/// to 1e-6.
inline constexpr double kPanelInSigmas = 1.5;

/// The integral over [0, 1] on equal panels of four nodes each: calls use(position, weight); the
/// weights sum to 1.
template <typename Use>
void ForEachNode(int panels, Use use) {
  const double scale = 0.5 / panels;
  for (int i = 0; i < panels; ++i) {
    for (const QuadratureNode& node : kFourNodes) {
      use(scale * (2 * i + 1 + node.position), scale * node.weight);
    }
  }
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_QUADRATURE_H_
