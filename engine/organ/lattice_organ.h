#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/inversion_detector.h"
#include "engine/organ/organ_mechanics.h"
#include "engine/solver/free_body.h"

namespace hpdm {

/// Tissue that a free-form-deformation lattice moves (model "hpdm"). Its splines have an elastic
/// energy over the tissue that they contain; finer splines join them where a contact is.
class LatticeOrgan final : public OrganMechanics {
 public:
  /// Samples the tissue and assembles its energy. Appends to `warnings`. Throws InputError
  /// (organ's name, fault, remedy), for example for a support without tissue or too large a lattice.
  LatticeOrgan(const OrganSurface& surface, std::vector<std::string>* warnings);

  const Lattice& lattice() const { return lattice_; }
  /// True if functions of the lattice or local functions are split by tissue, stand on several
  /// levels or belong to a front.
  bool split() const {
    return lattice_.split() || !lattice_.levels().empty() || lattice_.front_functions() > 0 ||
           (refinement_basis_ && refinement_basis_->finer().split());
  }
  /// Returns the error that finer levels could still remove (LevelPlacement::error); absent without
  /// adaptive functions.
  const std::optional<double>& error_of_levels() const { return error_of_levels_; }
  /// Returns the cuts of the scene and then the narrow notches (CutsOf), or nullptr.
  const CutSurfaces& cuts() const { return cuts_; }
  /// Returns the volume of the tissue that each support holds, m^3.
  const std::vector<double>& support_volumes() const { return support_volumes_; }
  /// The springs that do not relax with viscoelastic tissue: n x n, N/m, the same along each axis;
  /// empty if there are none or the tissue is elastic.
  const ScalarStiffness& elastic_supports() const { return elastic_supports_; }
  /// The weight of the tissue as loads on the control points, n x 3, N; empty without gravity.
  const Points& weight_W() const { return weight_W_; }
  /// Fillings and layers, whose stiffness is in that of the organ.
  const FillingsAndLayers& fillings_and_layers() const { return fillings_and_layers_; }
  /// Mass of a free organ (OrganOptions::free); nullptr for others.
  const FreeBody* free_body() const { return free_body_ ? &*free_body_ : nullptr; }
  const InversionDetector& inversion_detector() const { return *inversion_detector_; }
  const ElasticEnergy* finite_energy() const override { return finite_energy_.get(); }
  const RefinementBasis* refinement_basis() const override {
    return refinement_basis_ ? &*refinement_basis_ : nullptr;
  }

  std::unique_ptr<Relaxation> MakeRelaxation(int slots,
                                             std::function<Nanoseconds()> clock) const override;
  void AddToRow(const SurfacePoint& at, double weight, const ActiveRefinement& active,
                Eigen::Ref<Eigen::RowVectorXd> row) const override;
  void AddLocalDisplacements(const ActiveRefinement& active, const Points& U,
                             Points* vertices) const override;
  bool HasModulus() const override { return options().energy.type == EnergyType::kStrain; }
  double ResolvedRadius(const SurfacePoint& at, double radius) const override;
  double FinestRadius() const override;

 private:
  WeightMatrix SurfaceWeights(const Lattice& lattice) const;  // at the vertices
  std::vector<Quadrature> SampleSupports();
  void PlaceFinerLevels(Quadrature* elastic, const std::vector<Quadrature>& held);
  void BuildElasticSupports(const Quadrature& tissue, const std::vector<Quadrature>& held);
  void BuildMetricEnergy(Quadrature tissue, const std::array<int, 3>& cells,
                         const std::vector<Quadrature>& held);
  void BuildStrainEnergy(const Quadrature& tissue, const std::vector<Quadrature>& held);

  Lattice lattice_;
  CutSurfaces cuts_;
  std::vector<double> support_volumes_;
  ScalarStiffness elastic_supports_;
  FillingsAndLayers fillings_and_layers_;
  Points weight_W_;
  std::optional<double> error_of_levels_;
  double resolution_ = 0;      // m: kernel radius that the finest functions resolve
  Eigen::VectorXd thickness_;  // V, m, at most twice the resolution
  std::unique_ptr<const ElasticEnergy> finite_energy_;
  std::optional<RefinementBasis> refinement_basis_;
  Eigen::SparseMatrix<double> refinement_weights_;  // finer_weights(), function by function
  std::optional<FreeBody> free_body_;
  std::optional<FreeFlight> free_flight_;
  std::optional<InversionDetector> inversion_detector_;
};

}  // namespace hpdm
