#pragma once

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"

namespace hpdm {

/// The elastic supports K_s of viscoelastic tissue, K = K_t + K_s. The branches of the tissue have
/// the stiffness r_k K_t (maxwell_memory.h), so with c = sum_k r_k gain_k a step needs
///     (K + c K_t)^-1 = K^-1 / (1 + c) + Phi D Phi^T.
///
/// 1. The modes phi_j solve K_s phi = sigma K phi, 0 < sigma <= 1, phi_j^T K phi_j = 1. They span
///    the supports' range. So P = K^-1 K_t = 1 - Phi sigma Phi^T K has few of them, whatever n is.
///    A mode moves with the share mu = 1 - sigma of the tissue's law, all other motion with 1:
///        D_j = c sigma_j / ((1 + c mu_j) (1 + c))
/// 2. With local functions the supports act on the lattice's part U_bar = U + Y V
///    (schur_complement.h). What the local functions add to it relaxes with the tissue.
/// 3. Modes with sigma below kLeastShare count as tissue.
///
/// Built at set-up. Deformation thread; allocates nothing.
class ElasticSupports {
 public:
  static constexpr double kLeastShare = 1e-6;

  /// `lattice`: K^-1 at rest, which must outlive it; `springs`: n x n, N/m, the same along each
  /// axis; `rows`: n and the slots of local functions.
  ElasticSupports(const LatticeCompliance& lattice, const ScalarStiffness& springs,
                  Eigen::Index rows);

  /// Returns a copy for a copy of the lattice.
  ElasticSupports CopyFor(const LatticeCompliance& lattice) const {
    ElasticSupports copy(*this);
    copy.lattice_ = &lattice;
    return copy;
  }

  Eigen::Index modes() const { return shares_.size(); }
  const Eigen::VectorXd& shares() const { return shares_; }  ///< sigma.

  /// Adds to `free`, which holds c / (1 + c) `from`, what makes it c (1 + c P)^-1 P `from`. Both are
  /// (n + slots) x 3, m.
  void AddFree(double c, const Points& from, Points* free) const;
  /// Replaces U by P U.
  void TakeOut(Points* U) const;

  /// Adds the part Phi D Phi^T of the response to the problem, in which the organ is number `body`.
  void AddCompliance(int body, const ContactConstraints& contacts, double c, ContactSolver* solver);
  /// Adds the displacements of that part; AddCompliance() has seen the contacts.
  void AddDisplacements(int body, double c, const ContactSolver& solver, Points* U) const;

  /// Returns the part of a point's compliance (m/N) that stands in series with its tissue and does
  /// not relax: with C that after relaxation and R = sum_k r_k its compliance at once is
  ///     (C + R C_0) / (1 + R),   C_0 = b Phi sigma / (1 + R mu) Phi^T b^T.
  /// `response`: K^-1 b^T, 3 (n + slots) x 3.
  Matrix3d InSeries(const Eigen::Ref<const Eigen::MatrixXd>& response, double R) const;
  /// The same from the row of a point at rest, without local functions.
  Matrix3d InSeries(const SparseRow& b, double R) const;

 private:
  double Further(Eigen::Index mode, double c) const;  // D
  // Phi^T K U_bar, until the next call.
  Eigen::VectorXd& AmountsOf(const Eigen::Ref<const Eigen::VectorXd>& U) const;
  void AddModes(const Eigen::VectorXd& amounts, Points* U) const;
  Matrix3d InSeries(double R) const;  // of point_

  const LatticeCompliance* lattice_;
  Eigen::Index n_;
  std::vector<int> held_;  // control points with a spring
  Eigen::VectorXd shares_;
  Eigen::MatrixXd modes_;            // 3n x modes: Phi
  Eigen::MatrixXd loads_;            // 3 held x modes: K Phi, zero elsewhere
  Eigen::MatrixXd rows_;             // modes x 3 kMaxContacts: Phi^T b^T of the contacts
  Eigen::MatrixXd along_, moved_;    // modes x kMaxEquations
  mutable Eigen::VectorXd amounts_;  // modes
  mutable Eigen::Matrix<double, Eigen::Dynamic, 3> point_;  // modes x 3: Phi^T b^T of a point
  mutable Eigen::VectorXd U_bar_;                           // 3n
};

}  // namespace hpdm
