#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "engine/attachment/attachment_bed.h"
#include "engine/base/few_columns.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/duct/duct_model.h"
#include "engine/solver/free_body.h"

namespace hpdm {

/// Organs that attachments and ducts join, directly or through others: the constant part of their
/// common response. A layer's samples see the displacements U of its two organs only through few modes
/// w = Phi U, since the lattices have few functions there: delta_i = sum_j M_ij w_j. So with the
/// stiffness of the layers R = M^T diag(A_i k_i) M in these modes the organs respond by
///     H - H Phi^T (1 + R G)^-1 R Phi H,     H = K^-1 of all organs,   G = Phi H Phi^T.
/// Damage changes R alone. A duct acts on the rows of its ends (DuctModel::Hold): these are further
/// modes, behind those of all layers, and its stiffness is a block of R. Modes are Phi's rows times
/// the three axes: mode 3 j + d moves along d.
///
/// Local functions follow the lattice (schur_complement.h): a layer acts on U + Y V.
/// Built at set-up; any thread may read it.
class AttachmentJoint {
 public:
  /// Modes in which the undamaged layer has less than this share of the organs' own stiffness are
  /// dropped; of a layer that is softer than they in all modes, less than this share of its first. Two
  /// blocks on a layer of 224 samples have 39 modes then; their displacements are within 3e-4 of a direct
  /// solution at any damage, with 33 modes (a share of 1e-2) within 5e-3.
  static constexpr double kLeastRatio = 1e-3;

  /// One organ for the joint. `compliance`: at rest, without local functions in use; nullptr for a
  /// rigid organ. `rows`: its control points and slots.
  struct Organ {
    int index = 0;  ///< In the scene.
    int control_points = 0;
    Eigen::Index rows = 0;
    const LatticeCompliance* compliance = nullptr;
    /// Its weight on the control points, n x 3, N; nullptr: layers bear none of it.
    const Points* weight_W = nullptr;
    /// The mass of an organ that moves as a whole; else nullptr.
    const FreeBody* body = nullptr;
    double yield = 0;    ///< s^2: FreeFlight::Yield() of such an organ.
    bool leaks = false;  ///< It has lumens, whose loss moves it without forces.
  };
  struct Member {
    int organ = 0;            ///< Index in the scene.
    RowMajorMatrix response;  ///< 3n x 3r: H Phi^T. Empty for a rigid organ.
    Eigen::VectorXd offset;   ///< r: the modes that an offset of the organ by 1 m excites.
    bool free = false;        ///< It moves as a whole.
    /// r x n: Phi along one axis, of an organ that is free or leaks; else empty.
    Eigen::MatrixXd shape;
    Eigen::Index unknowns() const { return response.rows(); }
  };
  struct Layer {
    AttachmentBed bed;
    std::array<int, 2> members{};  ///< a and b.
    Eigen::Index first_mode = 0;
    Eigen::MatrixXd samples;  ///< s x M: column i is M_i.
  };

  /// A duct with the members that hold its ends; -1: the world.
  struct Duct {
    std::shared_ptr<const DuctModel> model;
    std::array<int, 2> members{-1, -1};
    Eigen::Index first_mode = 0;  ///< Of those of its ends that lattices hold.
    /// Returns the first mode of an end that a lattice holds.
    Eigen::Index FirstModeOf(std::size_t end) const {
      return first_mode + (end == 1 && model->IsHeldByLattice(0) ? DuctModel::Hold::kRows : 0);
    }
    /// Returns the number of modes.
    Eigen::Index modes() const {
      return DuctModel::Hold::kRows *
             (Eigen::Index{model->IsHeldByLattice(0)} + Eigen::Index{model->IsHeldByLattice(1)});
    }
  };

  /// `beds`, `ducts`: connected; `organs`: a and b of each bed, then those of each duct, with index
  /// -1 for the world.
  AttachmentJoint(std::vector<AttachmentBed> beds, const std::vector<std::array<Organ, 2>>& organs,
                  std::vector<std::shared_ptr<const DuctModel>> ducts = {});

  const std::vector<Member>& members() const { return members_; }
  const std::vector<Layer>& layers() const { return layers_; }
  const std::vector<Duct>& ducts() const { return ducts_; }
  Eigen::Index modes() const { return modes_; }  ///< r, along each axis.
  /// Returns the number of the organ's member, or -1.
  int MemberOf(int organ) const;
  /// 3r, m: how far the organs' weight would move the modes without the layers, Phi H W. Empty
  /// without a weight.
  const Eigen::VectorXd& sag() const { return sag_; }
  /// G, symmetric, in the first 3r columns; further columns of zeros fill the last group of kFewColumns.
  const RowMajorMatrix& compliance() const { return compliance_; }
  /// Returns G (3r x 3r) for loads that last, which no inertia bears: sag() is for it. Other than
  /// compliance() with a free organ.
  Eigen::MatrixXd LastingCompliance() const {
    return lasting_.size() > 0 ? lasting_ : Eigen::MatrixXd(compliance_.leftCols(3 * modes_));
  }

 private:
  int AddMember(const Organ& organ);
  void AddLayer(AttachmentBed bed, const std::array<Organ, 2>& organs);
  void AddDuct(std::shared_ptr<const DuctModel> model, const std::array<Organ, 2>& organs);
  void AddModes(Eigen::Index count);
  void Respond();
  void AddFreeMotion(std::size_t member, Eigen::MatrixXd* G);

  std::vector<Member> members_;
  std::vector<Organ> organs_;            // of each member, at set-up
  std::vector<Eigen::MatrixXd> shapes_;  // of each member, r x n: Phi; at set-up
  std::vector<Layer> layers_;
  std::vector<Duct> ducts_;
  Eigen::Index modes_ = 0;
  RowMajorMatrix compliance_;
  Eigen::MatrixXd lasting_;
  Eigen::VectorXd sag_;
};

/// An organ for a joint. `relaxation`: at rest, of the organ; `rows`: its control points and slots. All
/// must outlive the joint's construction. The weight of an organ that is neither supported nor free is
/// left out: nothing but the layer would bear it, and it would have no place once freed.
AttachmentJoint::Organ JoinedOrgan(int index, const OrganModel& organ, const Relaxation& relaxation,
                                   Eigen::Index rows);

/// Groups the beds and the ducts into joints. `organs`: a and b of each bed, then those of each duct,
/// with index -1 for the world.
std::vector<std::shared_ptr<const AttachmentJoint>> JoinOrgans(
    std::vector<AttachmentBed> beds,
    const std::vector<std::array<AttachmentJoint::Organ, 2>>& organs,
    std::vector<std::shared_ptr<const DuctModel>> ducts = {});

}  // namespace hpdm
