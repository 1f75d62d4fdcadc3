#include "tools/haptics/bonded_disc.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "engine/organ/organ_state.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kDiscYoung = 5000;  // Pa
constexpr double kBlockSide = 40 * kDiscRadius;
constexpr double kDiscWay = 1e-5;   // m
constexpr double kDiscTurn = 1e-3;  // rad

// A disc on a block in the state before any motion.
class TiedDisc {
 public:
  explicit TiedDisc(const DiscCase& disc) : model_(DiscBlock(disc)), state_(model_, 1) {
    ActiveRefinement& active = state_.contacts.refinement;
    if (model_.refinement_basis() != nullptr) {
      active.ChooseNearest(model_.refinement_basis()->centres(), {&centre_, 1},
                           LocalFunctionsOf(model_.options()));
      state_.relaxation->SetActiveFunctions(active);
    }
    AddDisc(model_, centre_, footprint_.get());
    footprint_->Resolve(model_, 0, &state_.neighbourhoods);
    FillLocalCoupling({footprint_.get(), 1}, &coupling_);
  }

  // Returns the force (N) on the tissue and the torque (N m) about the centre for a motion of the
  // disc (m, rad).
  std::pair<Vector3d, Vector3d> Move(const Vector3d& way, const Vector3d& turn) {
    ContactConstraints& contacts = state_.contacts;
    contacts.Clear();
    for (int k = 0; k < footprint_->rows(); ++k) {
      ContactConstraints::Row& row = *contacts.Add();
      row.kind = ContactConstraints::RowKind::kGrasp;
      row.p_rest_W = footprint_->Mean(k, model_.rest().vertices, model_.rest().triangles);
      row.target_W = row.p_rest_W + way + turn.cross(row.p_rest_W - centre_);
      row.local_compliance_W = coupling_.block<3, 3>(3 * k, 3 * k);
      row.coupled = {&coupling_, k};
      Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(state_.control_displacements.rows());
      footprint_->AddToRow(k, model_, contacts.refinement, weights);
      contacts.WeightRow(k) = weights;
    }
    Points U = Points::Zero(state_.control_displacements.rows(), 3);
    state_.relaxation->Relax(&contacts, &U);
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
    for (int k = 0; k < contacts.size(); ++k) {
      force += contacts[k].force_W;
      torque += (contacts[k].p_rest_W - centre_).cross(contacts[k].force_W);
    }
    return {force, torque};
  }

 private:
  OrganModel model_;
  OrganState state_;
  Vector3d centre_ = {0.0013, -0.0007, 0};  // beside the block's axis and the mesh's vertices
  std::unique_ptr<Footprint> footprint_ = std::make_unique<Footprint>();
  LocalCoupling coupling_;
};

}  // namespace

OrganModel DiscBlock(const DiscCase& disc) {
  constexpr double kShell = 0.04;
  OrganOptions options;
  options.name = "block";
  options.material.young = kDiscYoung;
  options.material.poisson = disc.poisson;
  options.lattice.cells = {disc.cells, disc.cells, disc.cells};
  options.lattice.local.functions = disc.functions;
  for (int axis = 0; axis < 3; ++axis) {
    BoxFraction low, high;
    low.max[axis] = kShell;
    high.min[axis] = 1 - kShell;
    options.supports.push_back({low, {}});
    if (axis < 2) options.supports.push_back({high, {}});
  }
  const int n = disc.squares;
  return OrganModel(options, GridBox(Vector3d(-kBlockSide / 2, -kBlockSide / 2, -kBlockSide),
                                     Vector3d(kBlockSide / 2, kBlockSide / 2, 0), {n, n, n}));
}

void AddDisc(const OrganModel& model, const Vector3d& centre, Footprint* footprint) {
  using std::numbers::pi;
  constexpr int kRings = 4, kAngles = 16;
  const SurfaceTree tree(model.rest().vertices, model.rest().triangles);
  const auto radius = [](double share) {
    return kDiscRadius * std::sqrt(1 - (1 - share) * (1 - share));
  };
  for (int i = 0; i < kRings; ++i) {
    const double inner = radius(i / 4.0), outer = radius((i + 1) / 4.0), r = radius((i + 0.5) / 4);
    const double along = pi * (outer * outer - inner * inner) / kAngles / (outer - inner);
    for (int k = 0; k < kAngles; ++k) {
      const double angle = 2 * pi * (k + 0.5 * (i % 2)) / kAngles;
      const Eigen::Vector2d place = r * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const Vector3d p = centre + Vector3d(place.x(), place.y(), 0);
      footprint->Add({tree.Closest(p, 1).at, place, {outer - inner, along}});
    }
  }
}

DiscStiffness ExactDiscStiffness(double poisson) {
  const double G = kDiscYoung / (2 * (1 + poisson)), a = kDiscRadius, cube = a * a * a;
  return {4 * G * a * std::log(3 - 4 * poisson) / (1 - 2 * poisson), 8 * G * a / (2 - poisson),
          8 * G * cube / (3 * (1 - poisson)), 16 * G * cube / 3};
}

DiscStiffness MeasureDisc(const DiscCase& disc) {
  TiedDisc tied(disc);
  const Vector3d x = Vector3d::UnitX(), z = Vector3d::UnitZ(), none = Vector3d::Zero();
  return {tied.Move(kDiscWay * z, none).first.z() / kDiscWay,
          tied.Move(kDiscWay * x, none).first.x() / kDiscWay,
          tied.Move(none, kDiscTurn * x).second.x() / kDiscTurn,
          tied.Move(none, kDiscTurn * z).second.z() / kDiscTurn};
}

}  // namespace hpdm
