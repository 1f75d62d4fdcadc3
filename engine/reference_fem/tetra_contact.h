#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "engine/reference_fem/tetra_fem.h"

namespace hpdm {

/// A boundary face of a quadratic mesh: its three corners, counter-clockwise seen from outside, and
/// the middles of its sides 01, 12 and 20.
using TetraFace = std::array<int, 6>;

/// Lists the faces that belong to one element only. Quadratic meshes only.
std::vector<TetraFace> BoundaryFaces(const TetraMesh& mesh);

/// One of two bodies in contact, in small strain, condensed to the surface nodes of a contact zone:
///     f = S (u - u_0),
/// S the Schur complement of the stiffness with supports, u_0 the displacement by the loads alone.
class CondensedTetraBody {
 public:
  /// `problem`: springs, forces and loads with a given force; `zone`: the faces that can touch.
  /// Factorises the stiffness: half a minute for 10,000 nodes. Throws InputError if
  /// nothing holds the body. `body` must outlive it.
  CondensedTetraBody(const TetraBody& body, const TetraProblem& problem,
                     const std::vector<TetraFace>& zone);
  ~CondensedTetraBody();
  CondensedTetraBody(CondensedTetraBody&&) noexcept;

  /// Moves the body with its supports before the contact, m. Displacements stay relative to them.
  void Move(const Vector3d& way) { rest_.rowwise() += way.transpose(); }

  const TetraBody& body() const { return *body_; }
  const std::vector<int>& nodes() const { return nodes_; }         ///< Of the zone, ascending.
  const std::vector<TetraFace>& faces() const { return faces_; }   ///< By numbers in nodes().
  const Points& rest() const { return rest_; }                     ///< Of nodes(), m.
  const Eigen::MatrixXd& stiffness() const { return stiffness_; }  ///< S, N/m.
  const Eigen::VectorXd& unloaded() const { return u_0_; }         ///< u_0, m.
  /// Returns the displacements of all nodes (N x 3, m) under the loads and the zone's `forces` (N).
  Points Displacements(const Eigen::VectorXd& forces) const;

 private:
  struct Factor;
  const TetraBody* body_;
  std::vector<int> nodes_;
  std::vector<TetraFace> faces_;
  Points rest_;
  Eigen::MatrixXd stiffness_;
  Eigen::VectorXd u_0_;
  Eigen::VectorXd loads_;  // 3N, N
  std::unique_ptr<Factor> factor_;
};

struct TetraContactOptions {
  /// Penalty pressure over Young's modulus, for a penetration of one face's size.
  double penalty = 100;
  int splits = 1;           ///< Faces are integrated over 4^splits parts of three points.
  int most_rounds = 60;     ///< Searches for the facing points at the deformed shape.
  double tolerance = 1e-5;  ///< Last change of the zone over its largest displacement.
};

/// A quadrature point of the contact, on the first body's surface.
struct TetraContactPoint {
  Vector3d p_W = Vector3d::Zero();  ///< Deformed place, m.
  double area = 0;                  ///< m^2, at rest.
  double pressure = 0;              ///< Pa.
  double penetration = 0;           ///< m; of touching points.
};

struct TetraContactSolution {
  std::array<Points, 2> u;                ///< N x 3 of each body, m.
  std::vector<TetraContactPoint> points;  ///< Those that touch.
  Vector3d force_W = Vector3d::Zero();    ///< On the second body, N.
  double area = 0;                        ///< Touching, m^2.
  double largest_penetration = 0;         ///< m.
  int rounds = 0;
  bool converged = false;
};

/// Returns the equilibrium of two bodies without friction. Quadratic tetrahedra, small strain, but
/// contact at the deformed shape: each quadrature point of the first body's zone takes the closest
/// facing point of the second one's, and its mean normal there. The penalty energy
///     1/2 sum area k <-gap>^2
/// is minimised together with both elastic energies by Newton's method over the points that touch.
/// Independent of the engine's contact (engine/pairs, engine/contact): other elements, other
/// search, no rows. Set-up and tools only.
TetraContactSolution SolveTetraContact(const CondensedTetraBody& first,
                                       const CondensedTetraBody& second,
                                       const TetraContactOptions& options = {});

}  // namespace hpdm
