#include "tools/bench/bench_scene.h"

#include "scenes/generator/shapes/instrument_mesh.h"

namespace hpdm {
namespace {

std::vector<OrganModel> InARow(const std::vector<BenchOrgan>& row) {
  std::vector<OrganModel> organs;
  organs.reserve(row.size());
  for (std::size_t o = 0; o < row.size(); ++o) {
    SurfaceMesh rest = row[o].rest;
    rest.vertices.col(0).array() += BenchScene::kApart * static_cast<double>(o);
    organs.emplace_back(row[o].options, std::move(rest));
  }
  return organs;
}

}  // namespace

BenchScene::BenchScene(const std::vector<BenchOrgan>& organs, int instruments)
    : probe_(ProbeMesh()),
      organs_(InARow(organs)),
      render_(SizedSnapshot(organs_, instruments, true)),
      telemetry_(SizedSnapshot(organs_, instruments, false)),
      loop_(organs_, std::vector<ToolOptions>(static_cast<std::size_t>(instruments)),
            {tool_states_, patches_, render_, telemetry_}) {
  tools_.tool_count = instruments;
  for (int i = 0; i < instruments; ++i) {
    const SurfaceMesh& rest = organs_[0].rest();
    const SurfacePoint at = FrontPoint(rest, i == 0 ? -0.04 : 0.05);
    const Vector3d p = at.Position(rest.vertices, rest.triangles);
    entry_[i] = p;
    tools_.tools[i].p_trocar_W = p + Vector3d(0, 0, 0.15);
    tools_.tools[i].X_WT.translation() = p + Vector3d(0, 0, 0.02);
  }
  posed_.assign(static_cast<std::size_t>(instruments), probe_.vertices);
  loop_.Step(tools_, 0);  // starts outside, so that the tips enter in the next step
}

void BenchScene::Step() {
  deep_ = !deep_;
  for (int i = 0; i < tools_.tool_count; ++i) {
    Isometry3d& X_WT = tools_.tools[i].X_WT;
    X_WT.translation() = entry_[i] - Vector3d(0, 0, deep_ ? 0.006 : 0.005);
    // The visible mesh of the instrument; collisions use its capsule and the tip's ball.
    Points& posed = posed_[static_cast<std::size_t>(i)];
    posed.noalias() = probe_.vertices * X_WT.linear().transpose();
    posed.rowwise() += X_WT.translation().transpose();
  }
  now_ns_ += kNanosecondsPerSecond / 30;
  loop_.Step(tools_, now_ns_);
}

void BenchScene::StepAway() {
  for (int i = 0; i < tools_.tool_count; ++i) {
    tools_.tools[i].X_WT.translation() = tools_.tools[i].p_trocar_W + Vector3d(0, 0, 0.2);
  }
  now_ns_ += kNanosecondsPerSecond / 30;
  loop_.Step(tools_, now_ns_);
}

bool BenchScene::AllPress() const {
  int pressing = 0;
  const OrganState& state = loop_.organ(0);
  for (int i = 0; i < state.contacts.size(); ++i) {
    pressing += !state.contacts[i].shaft && state.contacts[i].force_W.norm() > 0;
  }
  return pressing == tools_.tool_count;
}

int BenchScene::polygons() const {
  return tools_.tool_count * static_cast<int>(probe_.triangles.rows());
}

int BenchScene::triangles() const {
  Eigen::Index count = 0;
  for (const OrganModel& organ : organs_) count += organ.rest().triangles.rows();
  return static_cast<int>(count);
}

}  // namespace hpdm
