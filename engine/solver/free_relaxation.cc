#include "engine/solver/free_relaxation.h"

#include <utility>

#include "engine/base/copying.h"
#include "engine/solver/contact_body.h"

namespace hpdm {
namespace {

// Turns the vectors of each control point in the columns (3n rows).
void TurnEach(const Matrix3d& rotation, Eigen::Ref<Eigen::MatrixXd> columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    for (Eigen::Index a = 0; a + 2 < columns.rows(); a += 3) {
      const Vector3d turned = rotation * columns.block<3, 1>(a, c);
      columns.block<3, 1>(a, c) = turned;
    }
  }
}

class FreeRelaxation final : public BodyRelaxation, public LatticeCompliance {
 public:
  FreeRelaxation(std::unique_ptr<ComplianceSolver> K, const FreeBody& body,
                 const FreeFlight& flight, Eigen::Index rows)
      : solver_(std::move(K)),
        body_(&body),
        flight_(flight),
        motion_(RestOf(body)),
        U_free_(Points::Zero(rows, 3)),
        response_(3 * rows, 1),
        V_(Points::Zero(rows, 3)),
        local_(3 * rows),
        part_(3 * rows) {}
  std::unique_ptr<Relaxation> Clone() const override {
    return std::make_unique<FreeRelaxation>(*this);
  }
  void Take(const Relaxation& other) override { *this = static_cast<const FreeRelaxation&>(other); }

  void Begin(const RelaxationInput& input, const ContactConstraints& contacts) override {
    solver_->SetActiveFunctions(contacts.refinement);
    lost_ = input.free;
    before_ = {motion_, q_, rate_, held_, tied_};
    if (held_) {
      predicted_ = RestOf(*body_);
      flight_.AdvanceSmall(&q_, &rate_);
      PlaceSmall(q_, &U_free_);
      return;
    }
    flown_ = motion_;
    flight_.Advance(*body_, &flown_);
    predicted_ = flown_;
    predicted_.p_W += flight_.Impulse();
    PlaceRigid(predicted_, &U_free_);
    AddLost(predicted_, &U_free_);
  }

  bool Linearise(int body, const ContactConstraints& contacts, ContactSolver* solver) override {
    const Matrix3d R_FW = predicted_.R_WF.transpose();
    solver->Turn(body, R_FW);
    solver_->Respond(body, contacts, 1, solver);
    solver->Turn(body, predicted_.R_WF);
    TakeOffChanges(body, contacts, U_free_, solver);
    return true;
  }

  bool Advance(int, const ContactConstraints& contacts, const ContactSolver&) override {
    const Matrix3d R_FW = predicted_.R_WF.transpose();
    has_forces_ = false;
    response_.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      if (contacts[i].force_W.isZero(0)) continue;
      has_forces_ = true;
      const Vector3d force_F = R_FW * contacts[i].force_W;
      for (Eigen::Index a = 0; a < U_free_.rows(); ++a) {
        const double weight = contacts.Weights()(i, a);
        if (weight != 0) response_.block<3, 1>(3 * a, 0) += weight * force_F;
      }
    }
    if (has_forces_) solver_->SolveLoads(response_);
    return true;
  }

  RelaxationResult End(const RelaxationResult& solved, Points* U) override {
    if (held_) {
      *U = U_free_;
      if (has_forces_) *U += Eigen::Map<const Points>(response_.data(), U->rows(), 3);
      return solved;
    }
    if (tied_) {  // TakeMoved() finds the motion.
      if (!has_forces_) response_.setZero();
      for (Eigen::Index a = 0; a < U->rows(); ++a) {
        const Vector3d v_F = response_.block<3, 1>(3 * a, 0);
        U->row(a) = U_free_.row(a) + (predicted_.R_WF * v_F).transpose();
      }
      return solved;
    }
    if (has_forces_) {
      V_ = Eigen::Map<const Points>(response_.data(), V_.rows(), 3);
      TakeMotion(body_->RigidPart(V_));
    } else {
      V_.setZero();
      motion_ = flown_;
    }
    PlaceDeformed(U);
    return solved;
  }

  const Points* FreeDisplacements() const override { return held_ ? &U_free_ : nullptr; }

  // The motion over the prediction is that of impulses at the step's start.
  void TakeMoved(Points* U) override {
    if (held_) {
      TakeSmallMotion(*U);
    } else if (tied_ && !before_.held) {  // a step in which links let go ends as it was
      TakeTiedMotion(U);
    }
  }

  void Tie() override { tied_ = true; }
  Isometry3d PredictedFrame() const override { return FrameOf(predicted_); }
  Isometry3d Frame() const override { return FrameOf(motion_); }

  void TakeBack() override {
    motion_ = before_.motion;
    q_ = before_.q;
    rate_ = before_.rate;
    held_ = before_.held;
    tied_ = before_.tied;
  }

  void SetHeld(bool held) override {
    if (held_ && !held) motion_ = MotionFrom(*body_, q_, rate_);
    held_ = held;
  }

  Matrix3d Rotation() const override { return motion_.R_WF; }
  bool AtRest() const override { return false; }

  double BodyEnergy(const Points& U) const override {
    const double weight = -body_->mass * flight_.gravity_W().dot(body_->RigidPart(U).translation);
    if (held_) {
      return weight + 0.5 * (body_->mass * rate_.translation.squaredNorm() +
                             rate_.rotation.dot(body_->inertia * rate_.rotation));
    }
    const Vector3d momentum_F = motion_.R_WF.transpose() * motion_.momentum_W;
    return weight + 0.5 * (body_->mass * motion_.v_W.squaredNorm() +
                           momentum_F.dot(body_->inertia.inverse() * momentum_F));
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    solver_->SetActiveFunctions(active);
  }
  const LatticeCompliance* compliance() const override { return this; }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    RespondToSet({&b, 1}, response);
  }
  void RespondToSet(std::span<const SparseRow> rows,
                    Eigen::Ref<Eigen::MatrixXd> responses) const override {
    const Matrix3d& R = motion_.R_WF;
    solver_->RespondToSet(rows, responses);
    for (Eigen::Index c = 0; c < responses.cols(); c += 3) {
      for (Eigen::Index a = 0; a + 2 < responses.rows(); a += 3) {
        const Matrix3d turned = R * responses.block<3, 3>(a, c) * R.transpose();
        responses.block<3, 3>(a, c) = turned;
      }
    }
  }
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override {
    TurnEach(motion_.R_WF.transpose(), loads);
    solver_->SolveLoads(loads);
    TurnEach(motion_.R_WF, loads);
  }
  void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& V,
                    Eigen::Ref<Eigen::VectorXd> U_bar) const override {
    auto V_F = local_.head(V.size());
    auto part = part_.head(U_bar.size());
    V_F = V;
    TurnEach(motion_.R_WF.transpose(), V_F);
    part.setZero();
    solver_->AddLocalPart(V_F, part);
    TurnEach(motion_.R_WF, part);
    U_bar += part;
  }
  Matrix3d PointCompliance(const SparseRow& b) const override {
    return motion_.R_WF * solver_->PointCompliance(b) * motion_.R_WF.transpose();
  }

 private:
  static FreeMotion RestOf(const FreeBody& body) {
    FreeMotion rest;
    rest.p_W = body.p_centre_W;
    return rest;
  }

  Isometry3d FrameOf(const FreeMotion& motion) const {
    Isometry3d X_WF = Isometry3d::Identity();
    if (!tied_) return X_WF;
    X_WF.linear() = motion.R_WF;
    X_WF.translation() = motion.p_W - motion.R_WF * body_->p_centre_W;
    return X_WF;
  }

  void TakeSmallMotion(const Points& U) {
    if (!U.allFinite()) {
      q_ = rate_ = {};
      return;
    }
    const FreeBody::Motion moved = body_->RigidPart(U);
    rate_.translation += (moved.translation - q_.translation) / flight_.dt();
    rate_.rotation += (moved.rotation - q_.rotation) / flight_.dt();
    q_ = moved;
  }

  void TakeTiedMotion(Points* U) {
    for (Eigen::Index a = 0; a < V_.rows(); ++a) {
      V_.row(a) = (U->row(a) - U_free_.row(a)) * predicted_.R_WF;
    }
    if (V_.isZero(0)) {
      motion_ = flown_;
    } else {
      TakeMotion(body_->RigidPart(V_));
    }
    PlaceDeformed(U);
  }

  // Moves the rigid part of the response from the deformation V to the frame.
  void TakeMotion(const FreeBody::Motion& q) {
    for (Eigen::Index a = 0; a < body_->arms.rows(); ++a) {
      const Vector3d arm = body_->arms.row(a);
      V_.row(a) -= (q.translation + q.rotation.cross(arm)).transpose();
    }
    const Matrix3d& R = predicted_.R_WF;
    motion_ = predicted_;
    motion_.p_W += R * q.translation;
    motion_.v_W += R * q.translation / flight_.dt();
    motion_.momentum_W += R * (body_->inertia * q.rotation) / flight_.dt();
    TurnFrame(R * q.rotation, &motion_.R_WF);
  }

  void PlaceSmall(const FreeBody::Motion& q, Points* U) const {
    U->setZero();
    for (Eigen::Index a = 0; a < body_->arms.rows(); ++a) {
      const Vector3d arm = body_->arms.row(a);
      U->row(a) = (q.translation + q.rotation.cross(arm)).transpose();
    }
    AddLost(RestOf(*body_), U);
  }

  // Adds the displacements without forces in the frame.
  void AddLost(const FreeMotion& motion, Points* U) const {
    if (lost_ != nullptr) U->noalias() += lost_->lazyProduct(motion.R_WF.transpose());
  }

  // Places the deformation V, and the one without forces, by the motion.
  void PlaceDeformed(Points* U) {
    PlaceRigid(motion_, U);
    AddLost(motion_, U);
    for (Eigen::Index a = 0; a < V_.rows(); ++a) {
      U->row(a) += (motion_.R_WF * V_.row(a).transpose()).transpose();
    }
    if (!U->allFinite()) motion_ = RestOf(*body_);
  }

  void PlaceRigid(const FreeMotion& motion, Points* U) const {
    U->setZero();
    for (Eigen::Index a = 0; a < body_->arms.rows(); ++a) {
      const Vector3d arm = body_->arms.row(a);
      U->row(a) = (motion.p_W - body_->p_centre_W + motion.R_WF * arm - arm).transpose();
    }
  }

  Cloned<ComplianceSolver> solver_;
  const FreeBody* body_;
  FreeFlight flight_;
  FreeMotion motion_;
  FreeMotion flown_;       // after the step's free flight
  FreeMotion predicted_;   // the same with gravity as an impulse
  bool held_ = false;      // by links
  bool tied_ = false;      // by links, in its moving frame
  FreeBody::Motion q_;     // while it is held: m, rad
  FreeBody::Motion rate_;  // the same: m/s, rad/s
  struct Before {
    FreeMotion motion;
    FreeBody::Motion q, rate;
    bool held = false, tied = false;
  };
  Before before_;  // the step
  bool has_forces_ = false;
  const Points* lost_ = nullptr;   // rows x 3, m, in the frame: of the present step without forces
  Points U_free_;                  // rows x 3, m: at predicted_, or by q_
  Eigen::MatrixXd response_;       // 3 rows x 1, m: K^-1 R^T B^T f
  Points V_;                       // rows x 3, m, in the frame
  mutable Eigen::VectorXd local_;  // 3 rows
  mutable Eigen::VectorXd part_;   // 3 rows
};

}  // namespace

std::unique_ptr<Relaxation> MakeFreeRelaxation(std::unique_ptr<ComplianceSolver> K,
                                               const FreeBody& body, const FreeFlight& flight,
                                               Eigen::Index rows) {
  return std::make_unique<FreeRelaxation>(std::move(K), body, flight, rows);
}

}  // namespace hpdm
