#include "engine/solver/enriched_compliance_solver.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/lattice_body.h"

namespace hpdm {
namespace {

// A press on top of the body, its row over the lattice and the local functions in use.
class RefinedPress {
 public:
  RefinedPress(const LatticeBody& body, const RefinementBasis& local)
      : body_(body), local_(local), contacts_(body.lattice.size(), local.size(), 20) {}

  // Compliance under the press at p.
  double Compliance(ComplianceSolver* solver, const Vector3d& p) {
    contacts_.Clear();
    const Vector3d points[] = {p};
    contacts_.refinement.ChooseNearest(local_.centres(), points, 20);
    ContactConstraints::Row* row = contacts_.Add();
    row->p_rest_W = p;
    auto weights = contacts_.WeightRow(0);
    body_.lattice.ForEachFunction(p, [&](int column, double value) { weights[column] = value; });
    local_.finer().ForEachFunction(p, [&](int function, double value) {
      const int slot = contacts_.refinement.Slot(function);
      if (slot >= 0) weights[body_.lattice.size() + slot] = value;
    });
    contact_solver_.Build(contacts_);
    solver->Respond(0, contacts_, 1, &contact_solver_);
    return contact_solver_.compliance()(0, 0);
  }
  const ActiveRefinement& active() const { return contacts_.refinement; }

 private:
  const LatticeBody& body_;
  const RefinementBasis& local_;
  ContactConstraints contacts_;
  ContactSolver contact_solver_;
};

class EnrichedComplianceTest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(PoissonRatios, EnrichedComplianceTest, testing::Values(0.3, 0.45));

TEST_P(EnrichedComplianceTest, AMovedSetEqualsANewOne) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  RefinedPress press(body, local);
  const auto moving = MakeComplianceSolver(local, 20), fresh = MakeComplianceSolver(local, 20);
  double last = 0;
  for (int i = 0; i <= 10; ++i) {
    last = press.Compliance(moving.get(), Vector3d(0.008 * i - 0.04, 0.01, 0.045));
  }
  RefinedPress again(body, local);
  const double first = again.Compliance(fresh.get(), Vector3d(0.04, 0.01, 0.045));
  EXPECT_NEAR(last, first, 1e-9 * first);  // the order of the slots only
}

TEST_P(EnrichedComplianceTest, FunctionsEnterAndLeaveWithoutAJump) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  RefinedPress press(body, local);
  const auto solver = MakeComplianceSolver(local, 20);
  const auto compliance = [&](double x) {
    return press.Compliance(solver.get(), Vector3d(x, 0.011, 0.045));
  };
  const auto set_at = [&](double x) {
    compliance(x);
    std::set<int> functions;
    for (int s = 0; s < 20; ++s) functions.insert(press.active().Function(s));
    return functions;
  };
  int swaps = 0;
  for (int i = 0; i < 30; ++i) {
    double before = 5e-4 * i, behind = before + 5e-4;
    const std::set<int> first = set_at(before);
    if (set_at(behind) == first) continue;
    ++swaps;
    while (behind - before > 1e-9) {
      const double middle = (before + behind) / 2;
      (set_at(middle) == first ? before : behind) = middle;
    }
    // A nanometre: the weights there are below 1e-6. At full weight a function makes some 1e-3.
    EXPECT_NEAR(compliance(behind) / compliance(before), 1, 1e-6) << before;
  }
  EXPECT_GT(swaps, 3);
}

TEST_P(EnrichedComplianceTest, FunctionsSoftenAPressAndNeverStiffenIt) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  const auto plain = MakeComplianceSolver(body.K), refined = MakeComplianceSolver(local, 20);
  for (const double x : {-0.06, -0.02, 0.0, 0.03}) {
    const Vector3d p(x, 0.01, 0.04);
    ContactConstraints contacts(body.lattice.size());
    contacts.Add();
    auto weights = contacts.WeightRow(0);
    body.lattice.ForEachFunction(p, [&](int column, double value) { weights[column] = value; });
    ContactSolver contact_solver;
    contact_solver.Build(contacts);
    plain->Respond(0, contacts, 1, &contact_solver);
    // A larger space has a smaller least energy; a point load gains well over a tenth.
    EXPECT_GT(RefinedPress(body, local).Compliance(refined.get(), p),
              1.1 * contact_solver.compliance()(0, 0));
  }
}

}  // namespace
}  // namespace hpdm
