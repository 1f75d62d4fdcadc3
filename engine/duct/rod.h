#pragma once

#include <array>
#include <vector>

#include "engine/base/types.h"
#include "engine/duct/block_band.h"
#include "engine/duct/tube_section.h"

namespace hpdm {

/// A tube in equilibrium between two frames, exact for large rotations: Simo and Reissner's rod
/// (doi:10.1016/0045-7825(85)90050-7) on a staggered grid. It has nodes x_i and on each segment a
/// rotation R_i whose third column is the section's normal. With the lengths l at rest its energy is
///     E = sum l (EA/2 (s - 1)^2 + GA s (s - r . d)) + sum l/2 (k - k_0)^T diag(EI, EI, GJ) (k - k_0),
///     d = (x_{i+1} - x_i) / l,   s = |d|,   r = R_i e_z,
///     k = 2 tan(angle / 2) axis / l    of the rotation from one segment to the next, k_0 at rest.
/// To first order this is Reissner's GA/2 of the shear and EA/2 of the stretch along r. With these
/// themselves the sections of a tube tilt once it is stretched by more than GA / (EA - GA), a quarter,
/// and its force falls; here straight tension is stable.
/// The frames of the ends hold the first and the last node and, over half a segment, the rotations
/// there. The shape at rest may be any path.
///
/// A cut doubles a node; both parts live on. A part that no end holds is held by a weak drag alone.
/// Copies continue to the last bit. No method but the constructor allocates or throws.
class Rod {
 public:
  static constexpr int kMaxCuts = 4;
  static constexpr int kMaxIterations = 40;

  /// Place and orientation of an end.
  struct Frame {
    Vector3d p_W = Vector3d::Zero();
    Matrix3d R_W = Matrix3d::Identity();
  };
  /// Displacement (m) and spatial rotation of the first end, then of the last one.
  using EndVector = Eigen::Matrix<double, 12, 1>;
  using EndMatrix = Eigen::Matrix<double, 12, 12>;

  struct Result {
    int iterations = 0;
    bool converged = true;
    double residual = 0;  ///< Largest force on a free node, N.
  };

  /// `path_W`: the nodes at rest, at least five, m.
  Rod(const Points& path_W, const TubeSection& section);

  int nodes() const { return static_cast<int>(count_); }
  const Vector3d& node(int i) const { return stations_[ToSize(i)].x_W; }
  /// Returns the rotation of the segment after node i.
  const Matrix3d& rotation(int i) const { return stations_[ToSize(i)].R_W; }
  /// False for the gap between the two nodes of a cut.
  bool IsSegment(int i) const { return !stations_[ToSize(i)].gap; }
  /// Returns the arc length of node i at rest, m.
  double ArcLength(int i) const { return stations_[ToSize(i)].arc; }
  double rest_length() const { return rest_length_; }
  /// Returns the force in the segment after node i in its own frame, N: the third is the tension.
  Vector3d ForceIn(int i) const;
  const std::array<Frame, 2>& rest_ends() const { return rest_ends_; }
  const std::array<Frame, 2>& ends() const { return ends_; }

  /// Sets the dead force on a node, N.
  void SetForce(int node, const Vector3d& force_W) { stations_[ToSize(node)].force_W = force_W; }
  /// Holds an inner node at a place from the next Settle().
  void Hold(int node, const Vector3d& target_W);
  void Release(int node) { stations_[ToSize(node)].held = false; }
  bool IsHeld(int node) const { return stations_[ToSize(node)].held; }
  bool HoldsNode() const;
  /// Returns the force that holds a held node, N. After Settle().
  Vector3d HoldingForce(int node) const { return gradient_[X(node)]; }
  /// Multiplies the stiffness of the segment after node i in bending and torsion.
  void Stiffen(int i, double factor) { stations_[ToSize(i)].stiffer = factor; }
  bool IsStiffened(int i) const { return stations_[ToSize(i)].stiffer != 1; }
  /// Lets go of the last end.
  void FreeLastEnd() { last_free_ = true; }
  /// Doubles an inner node. False if there are kMaxCuts, or if it is next to an end or a gap.
  bool Cut(int node);
  int cuts() const { return cuts_; }

  /// Finds the equilibrium with the ends at these frames.
  Result Settle(const std::array<Frame, 2>& ends);
  /// Fills the energy's derivative by the ends (N, N m) and its condensed second derivative, after
  /// Settle().
  void Condense(EndVector* gradient, EndMatrix* stiffness);
  /// The second derivative by a held node, and by it and the ends, while the rest is in equilibrium.
  struct NodeStiffness {
    Matrix3d node = Matrix3d::Zero();  ///< N/m.
    Eigen::Matrix<double, 12, 3> ends = Eigen::Matrix<double, 12, 3>::Zero();
  };
  /// Returns that of a held node, after Condense().
  NodeStiffness StiffnessOf(int node);
  /// Returns to the shape at rest to the last bit. Only without cuts and held nodes.
  void Reset();
  double Energy() const;

 private:
  struct Station {  // a node and the segment after it
    Vector3d rest_W, x_W;
    Matrix3d rest_R_W, R_W;
    double length = 0;                      // of the segment at rest, m
    double bend_length = 0;                 // about the node, m
    double arc = 0;                         // m
    Vector3d rest_bend = Vector3d::Zero();  // 2 tan(angle / 2) axis at the node
    double stiffer = 1;
    bool gap = false;  // the segment does not exist
    bool held = false;
    Vector3d target_W = Vector3d::Zero();
    Vector3d force_W = Vector3d::Zero();
  };

  static std::size_t X(int i) { return 1 + 2 * ToSize(i); }
  static std::size_t T(int i) { return 2 + 2 * ToSize(i); }
  std::size_t blocks() const { return 2 * count_ + 1; }
  const Matrix3d& Before(std::size_t i) const {
    return i == 0 ? ends_[0].R_W : stations_[i - 1].R_W;
  }
  const Matrix3d& After(std::size_t i) const {
    return i + 1 == count_ ? ends_[1].R_W : stations_[i].R_W;
  }
  double StrainEnergy(const Vector3d& d, const Vector3d& r) const;
  Vector3d StrainForce(const Vector3d& d, const Vector3d& r) const;
  bool Bends(std::size_t i) const;
  Vector3d BendingStiffness(std::size_t i) const;
  void Mark();
  void Assemble(bool geometric);
  void AssembleSegment(std::size_t i, bool geometric);
  void AssembleBend(std::size_t i, bool geometric);
  bool FactorFree();
  void FactorStable();
  double Residual() const;
  bool FindIncrements(const std::array<Frame, 2>& ends);
  double SolveStep();
  void Move(double share);
  void Keep();
  void Search(double slope, double before);

  TubeSection section_;
  std::vector<Station> stations_;  // count_ in use
  std::size_t count_;
  std::array<Frame, 2> rest_ends_, ends_;
  double rest_length_ = 0;
  double tolerance_ = 0;             // N
  double drag_ = 0, turn_drag_ = 0;  // N/m, N m: of a block that nothing holds
  int cuts_ = 0;
  bool last_free_ = false;

  // Working memory. Blocks: rotation of the first end, then nodes and segments in turn, then the
  // rotation of the last end.
  BlockBand tangent_, factor_;
  std::vector<char> fixed_, loose_;
  std::vector<Vector3d> gradient_, step_;
  std::vector<Eigen::Matrix<double, 3, 12>> columns_;
  std::vector<Matrix3d> node_columns_;
  std::vector<Vector3d> kept_x_;
  std::vector<Matrix3d> kept_R_;
};

/// Returns exp([v]x).
Matrix3d RotationOf(const Vector3d& v);
/// Returns v with R = exp([v]x) and |v| <= pi.
Vector3d RotationVector(const Matrix3d& R);

}  // namespace hpdm
