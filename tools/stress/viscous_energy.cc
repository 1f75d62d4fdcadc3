#include "tools/stress/viscous_energy.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <variant>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Row = ContactConstraints::Row;

bool IsHeldBy(const Row& row, int tool) {
  return row.kind == ContactConstraints::RowKind::kGrasp && row.tool == tool && !row.shaft;
}

}  // namespace

ViscousEnergy::ViscousEnergy(const OrganModel& model)
    : model_(model), prony_(model.options().material.prony) {
  HPDM_CHECK(prony_.count > 0 && model.finite_energy() == nullptr);
}

// Advances the springs of `body`, whose displacements change linearly to `u`, and adds what the
// dashpots dissipate. `K` (u) returns the stiffness times a vector.
template <class Stiffness>
void ViscousEnergy::Advance(const Eigen::VectorXd& u, double dt, const Stiffness& K, Body* body) {
  if (body->u.size() != u.size()) {
    body->u = Eigen::VectorXd::Zero(u.size());
    body->w.fill(body->u);
  }
  for (int k = 0; k < prony_.count; ++k) {
    const auto& [share, time] = prony_.terms[static_cast<std::size_t>(k)];
    Eigen::VectorXd& w = body->w[static_cast<std::size_t>(k)];
    const double ratio = share / (1 - prony_.Share()), kept = std::exp(-dt / time);
    const Eigen::VectorXd a = time / dt * (u - body->u), b = w - a;
    const Eigen::VectorXd Ka = K(a), Kb = K(b);
    dissipated_ += ratio / time *
                   (a.dot(Ka) * dt + 2 * a.dot(Kb) * time * (1 - kept) +
                    b.dot(Kb) * time / 2 * (1 - kept * kept));
    w = a + kept * b;
  }
  body->u = u;
}

template <class Stiffness>
double ViscousEnergy::InBranches(const Body& body, const Stiffness& K) const {
  double energy = 0;
  for (int k = 0; k < prony_.count; ++k) {
    const Eigen::VectorXd& w = body.w[static_cast<std::size_t>(k)];
    const double ratio = prony_.terms[static_cast<std::size_t>(k)].share / (1 - prony_.Share());
    energy += ratio / 2 * w.dot(K(w));
  }
  return energy;
}

void ViscousEnergy::Add(const OrganState& state, double dt) {
  HPDM_CHECK(state.contacts.refinement.slots() == 0);
  const Points& U = state.control_displacements;
  const Eigen::Map<const Eigen::VectorXd> u(U.data(), U.size());
  stored_ = 0;
  const ScalarStiffness& springs = model_.lattice_organ()->elastic_supports();
  const auto alike = [&](const ScalarStiffness& K, const Eigen::VectorXd& x) {
    const Points force = K * Eigen::Map<const Points>(x.data(), U.rows(), 3);
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(force.data(), force.size()));
  };
  const auto tissue = [&](const auto& K) {
    const auto K_t = [&](const Eigen::VectorXd& x) {
      return springs.size() > 0 ? Eigen::VectorXd(K(x) - alike(springs, x)) : K(x);
    };
    Advance(u, dt, K_t, &tissue_);
    stored_ += 0.5 * u.dot(K(u)) + InBranches(tissue_, K_t);
  };
  if (const auto* full = std::get_if<FullStiffness>(&model_.stiffness())) {
    tissue([&](const Eigen::VectorXd& x) { return Eigen::VectorXd(*full * x); });
  } else {
    const auto& scalar = std::get<ScalarStiffness>(model_.stiffness());
    tissue([&](const Eigen::VectorXd& x) { return alike(scalar, x); });
  }
  for (int tool = 0; tool < kMaxInstruments; ++tool) AddGrasp(state, tool, dt);
  AddDents(state);
}

// The tissue between a tool's jaws, whose points are coupled.
void ViscousEnergy::AddGrasp(const OrganState& state, int tool, double dt) {
  std::vector<int> rows;
  for (int i = 0; i < state.contacts.size(); ++i) {
    if (IsHeldBy(state.contacts[i], tool)) rows.push_back(i);
  }
  Body& body = held_[static_cast<std::size_t>(tool)];
  if (rows.empty()) {
    body = {};
    return;
  }
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd compliance(3 * count, 3 * count);
  Eigen::VectorXd u(3 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Row& row = state.contacts[rows[static_cast<std::size_t>(i)]];
    u.segment<3>(3 * i) = state.memory.local(rows[static_cast<std::size_t>(i)]).displacement_W;
    for (Eigen::Index j = 0; j < count; ++j) {
      const Row& other = state.contacts[rows[static_cast<std::size_t>(j)]];
      compliance.block<3, 3>(3 * i, 3 * j) =
          i == j ? row.local_compliance_W : row.coupled.To(other.coupled);
    }
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(compliance);
  const auto K = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(solver.solve(x)); };
  Advance(u, dt, K, &body);
  stored_ += 0.5 * u.dot(K(u)) + InBranches(body, K);
}

void ViscousEnergy::AddDents(const OrganState& state) {
  for (std::size_t tool = 0; tool < dents_.size(); ++tool) {
    const MaxwellMemory::Dent& dent = state.memory.dents()[tool];
    Dent now;
    if (dent.used) {
      const Vector3d phi_W = dent.memory.equilibrium_force_W();
      const double pressing = std::max(0.0, -dent.indentation.normal_W().dot(phi_W));
      now.u_W = dent.indentation.BallYield(pressing) * (dent.indentation.factor_W() * phi_W);
    }
    for (int i = 0; i < state.contacts.size(); ++i) {
      const Row& row = state.contacts[i];
      if (row.kind != ContactConstraints::RowKind::kPress || row.shaft) continue;
      if (row.tool == static_cast<int>(tool)) now.force_W = row.force_W;
    }
    const Dent& last = dents_[tool];
    dissipated_ += 0.5 * (last.force_W + now.force_W).dot(now.u_W - last.u_W);
    dents_[tool] = now;
  }
}

}  // namespace hpdm
