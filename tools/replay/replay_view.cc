#include "tools/replay/replay_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include "engine/base/error.h"
#include "lcmtypes/analysis/tissue_force.h"
#include "render/camera/laparoscope.h"
#include "tools/shared/number_text.h"

namespace hpdm {
namespace {

/// Field of view of the views along an axis, rad.
constexpr double kOverviewField = std::numbers::pi / 3;

/// Looks at all organs from a direction (unit), as near as the picture contains them.
LaparoscopeOptions Overview(const Vector3d& from, const Session& session) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vector3d low = Vector3d::Constant(kInfinity), high = -low;
  for (const OrganModel& organ : session.organs()) {
    const Points& vertices = organ.rest().vertices;
    low = low.cwiseMin(vertices.colwise().minCoeff().transpose());
    high = high.cwiseMax(vertices.colwise().maxCoeff().transpose());
  }
  LaparoscopeOptions camera;
  camera.p_target_W = 0.5 * (low + high);
  const double radius = std::max(0.5 * (high - low).norm(), 2 * kScopeNear);
  camera.p_scope_W = camera.p_target_W + radius / std::sin(kOverviewField / 2) * from;
  camera.field_of_view = kOverviewField;
  return camera;
}

/// Reads six numbers, separated by commas; false if the text is not that.
bool ReadSixNumbers(std::string_view text, std::array<double, 6>* numbers) {
  for (std::size_t i = 0; i < numbers->size(); ++i) {
    const bool last = i + 1 == numbers->size();
    const std::size_t comma = text.find(',');
    if ((comma == std::string_view::npos) != last) return false;
    const std::string_view number = text.substr(0, comma);
    if (!ReadNumber(number, &(*numbers)[i]) || !std::isfinite((*numbers)[i])) return false;
    text.remove_prefix(last ? text.size() : comma + 1);
  }
  return true;
}

}  // namespace

LaparoscopeOptions ParseView(const std::string& view, const Session& session) {
  static const std::map<std::string, Vector3d> kDirections = {
      {"front", -Vector3d::UnitY()}, {"behind", Vector3d::UnitY()}, {"left", -Vector3d::UnitX()},
      {"right", Vector3d::UnitX()},  {"below", -Vector3d::UnitZ()}, {"above", Vector3d::UnitZ()}};
  if (view == "laparoscope") return session.scene().laparoscope;
  if (const auto named = kDirections.find(view); named != kDirections.end()) {
    return Overview(named->second, session);
  }
  std::array<double, 6> numbers{};
  if (!ReadSixNumbers(view, &numbers)) {
    throw InputError("--view " + view +
                     ": unknown view; give laparoscope, front, behind, left, right, below, above, "
                     "or X,Y,Z,X,Y,Z: position and target in m");
  }
  LaparoscopeOptions camera;
  camera.p_scope_W = Vector3d(numbers[0], numbers[1], numbers[2]);
  camera.p_target_W = Vector3d(numbers[3], numbers[4], numbers[5]);
  camera.field_of_view = session.scene().laparoscope.field_of_view;
  try {
    Laparoscope(camera, Laparoscope::kMinSide, Laparoscope::kMinSide);
  } catch (const InputError& error) {
    throw InputError("--view " + view + ": " + error.what());
  }
  return camera;
}

PictureViewer::PictureViewer(const LaparoscopeOptions& camera, const RenderOptions& options,
                             TripleBuffer<ViewSettings>* settings,
                             RenderContextFactory make_context, Session* session)
    : session_(*session),
      render_(
          session->OrganVisuals(), session->InstrumentVisuals(), camera, options,
          {*session->render_scenes, nullptr, settings, &session->health, nullptr},
          [] { return Nanoseconds{0}; }, std::move(make_context)) {}

void PictureViewer::OnTick(const HapticSample& replayed) {
  health_.time_ns = replayed.time_ns;
  health_.tool_count = replayed.tool_count;
  for (int t = 0; t < replayed.tool_count; ++t) {
    const ToolSample& from = replayed.tools[t];
    SessionHealth::Tool& tool = health_.tools[t];
    tool.force_W = TissueForce(from);
    tool.depth = from.depth;
    tool.organ = from.organ;
    tool.guard_flags = from.guard_flags;
    tool.peak_force = std::max(tool.peak_force, tool.force_W.norm());
  }
  session_.health.Back() = health_;
  session_.health.Publish();
}

void PictureViewer::Draw() {
  render_.Frame();
  if (!render_.file_failure().empty()) throw InputError(render_.file_failure());
  if (!render_.failure().empty()) throw MachineError(render_.failure());
}

void PictureViewer::DrawAgain() {
  // This thread both writes and reads the buffer.
  TripleBuffer<SceneSnapshot>& scenes = *session_.render_scenes;
  scenes.Update();
  scenes.Back() = scenes.Front();
  scenes.Publish();
  Draw();
}

}  // namespace hpdm
