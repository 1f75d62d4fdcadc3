#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <variant>

#include "scenes/loader/scene.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

void EnsureFile(const std::string& path) {
  HPDM_ENSURE(path.empty() || std::filesystem::is_regular_file(path));
}

void EnsureWithin(double value, double least, double most) {
  HPDM_ENSURE(value >= least && value <= most);  // refuses NaN too
}

void EnsureName(const std::string& name, std::set<std::string>* others) {
  HPDM_ENSURE(!name.empty() && name.size() <= 64);
  for (const char c : name) HPDM_ENSURE(static_cast<unsigned char>(c) >= ' ' && c != '\x7f');
  HPDM_ENSURE(others->insert(name).second);
}

void EnsureRegion(const Region& region) {
  if (const auto* sphere = std::get_if<Sphere>(&region)) {
    HPDM_ENSURE(sphere->centre.allFinite() && sphere->radius > 0 && std::isfinite(sphere->radius));
  } else {
    const auto ensure = [](const Vector3d& min, const Vector3d& max) {
      HPDM_ENSURE(min.allFinite() && max.allFinite() && (min.array() < max.array()).all());
    };
    if (const auto* box = std::get_if<Box>(&region)) ensure(box->min, box->max);
    if (const auto* box = std::get_if<BoxFraction>(&region)) ensure(box->min, box->max);
  }
}

void EnsureOrgan(const OrganOptions& organ) {
  EnsureFile(organ.mesh);
  HPDM_ENSURE(!organ.mesh.empty());
  EnsureFile(organ.texture);
  EnsureWithin(organ.unit_m, 0, 1000);
  const Matrix3d R = organ.X_WO.linear();
  HPDM_ENSURE((R.transpose() * R - Matrix3d::Identity()).norm() < 1e-12);  // roundings alone
  HPDM_ENSURE(organ.X_WO.translation().allFinite());
  HPDM_ENSURE(organ.motion.displacement_W.allFinite());
  EnsureWithin(organ.motion.frequency, 0, 10);
  EnsureWithin(organ.time_step, 1e-3, 1);
  EnsureWithin(organ.wall_stiffness.value_or(1), 1e-300, 1e6);
  const LatticeOptions& lattice = organ.lattice;
  for (std::size_t d = 0; d < 3; ++d) {
    EnsureWithin(lattice.degree[d], 1, lattice.basis == BasisType::kBSpline ? 3 : 30);
    EnsureWithin(lattice.cells[d], 1, lattice.basis == BasisType::kBSpline ? 64 : 1);
  }
  EnsureWithin(lattice.margin, 0, 1);
  EnsureWithin(LocalFunctionsOf(organ), 0, 250);
  EnsureWithin(lattice.local.refinement, 2, 6);
  EnsureWithin(organ.energy.alpha, 1e-323, 1e12);
  EnsureWithin(organ.energy.beta, 0, 1e12);
  EnsureWithin(organ.energy.newton_iterations, 1, 1000);
  EnsureWithin(organ.energy.newton_budget, 0, 10);
  EnsureWithin(organ.material.young, 1e-323, 1e12);
  EnsureWithin(organ.material.poisson, 0, std::nextafter(0.5, 0));
  EnsureWithin(organ.material.density, 1e-323, 30000);
  const PronySeries& prony = organ.material.prony;
  HPDM_ENSURE(prony.count >= 0 && prony.count <= PronySeries::kMaxTerms);
  HPDM_ENSURE(prony.Share() <= PronySeries::kMaxShare + 1e-9);
  for (const SupportOptions& support : organ.supports) {
    EnsureRegion(support.region);
    EnsureWithin(support.stiffness.value_or(1), 1e-323, 1e15);
  }
}

void EnsureHeld(const InstrumentDescription& held, std::set<std::string>* names) {
  EnsureName(held.name, names);
  EnsureFile(held.mesh);
  for (const std::string& mesh : held.jaws.meshes) EnsureFile(mesh);
  HPDM_ENSURE(held.jaws.meshes.size() <= 2);
  HPDM_ENSURE(std::isfinite(held.jaws.pivot) && std::isfinite(held.jaws.opening));
  HPDM_ENSURE(std::isfinite(held.insulated_from.value_or(0)));
  EnsureWithin(held.geometry.tip_radius, 1e-323, 0.05);
  EnsureWithin(held.geometry.shaft_radius, 1e-323, 0.05);
  EnsureWithin(held.geometry.friction, 0, 10);
}

void EnsureDevice(const DeviceProfile& device) {
  for (const double positive :
       {device.mass, device.rotational_inertia, device.encoder_step, device.angle_encoder_step,
        device.jaw_encoder_step, device.max_force, device.max_torque, device.max_force_rate}) {
    EnsureWithin(positive, 1e-323, 1e6);
  }
  for (const double not_negative : {device.damping, device.rotational_damping, device.friction,
                                    device.rotational_friction, device.delay}) {
    EnsureWithin(not_negative, 0, 1e4);
  }
  EnsureWithin(device.max_angle, 1e-323, 1.5);
  EnsureWithin(device.max_insertion, device.min_insertion, 1);
}

void EnsureInstrument(const InstrumentOptions& instrument, std::set<std::string>* names) {
  EnsureHeld(instrument, names);
  HPDM_ENSURE(instrument.HeldCount() <= kMaxHeld);
  std::set<std::string> held = {instrument.name};
  for (const InstrumentDescription& exchange : instrument.exchanges) EnsureHeld(exchange, &held);
  HPDM_ENSURE(instrument.p_trocar_W.allFinite());
  EnsureWithin(instrument.k1, 0, 1e9);
  EnsureWithin(instrument.k2, 0, 1e9);
  EnsureWithin(instrument.trocar_friction, 0, 20);
  EnsureWithin(instrument.trocar_torque, 0, 1);
  EnsureDevice(instrument.device);
  const HandOptions& hand = instrument.hand;
  HPDM_ENSURE(hand.target.value_or(Vector3d::Zero()).allFinite());
  EnsureWithin(hand.depth, 1e-323, 0.5);
  EnsureWithin(hand.spread, 1e-323, 0.5);
  EnsureWithin(hand.speed, 1e-323, 5);
  EnsureWithin(hand.stiffness, 1e-323, 1e5);
  EnsureWithin(hand.damping, 0, 1e4);
  EnsureWithin(hand.tremor, 0, 0.01);
  EnsureFile(instrument.trace.file);
  HPDM_ENSURE(instrument.trace.scale > 0 && std::isfinite(instrument.trace.scale));
  HPDM_ENSURE(instrument.trace.speed > 0 && std::isfinite(instrument.trace.speed));
  HPDM_ENSURE(instrument.trace.R_WF.allFinite());
  HPDM_ENSURE(instrument.trace.position.value_or(Vector3d::Zero()).allFinite());
}

void EnsureLoad(const LoadOptions& load, const std::set<std::string>& organs) {
  HPDM_ENSURE(organs.count(load.organ) == 1);
  HPDM_ENSURE(
      load.force_W.has_value() + load.displacement_W.has_value() + load.pressure.has_value() == 1);
  HPDM_ENSURE(load.force_W.value_or(Vector3d::Zero()).allFinite());
  HPDM_ENSURE(load.displacement_W.value_or(Vector3d::Zero()).allFinite());
  HPDM_ENSURE(std::isfinite(load.pressure.value_or(0)));
  HPDM_ENSURE(load.pressure || load.radius > 0);
  if (load.region) EnsureRegion(*load.region);
}

void EnsureFiles(const Scene& scene) {
  std::set<std::string> names;
  for (const hpdm::SceneFile& file : scene.files) {
    HPDM_ENSURE(names.insert(file.name).second);
    EnsureFile(file.path);
    HPDM_ENSURE(scene.recorded == !file.sha256.empty());
    if (!scene.recorded) continue;
    const auto folder = scene.path.parent_path();
    HPDM_ENSURE(StaysInside(std::filesystem::path(file.path).lexically_relative(folder)));
  }
}

void EnsureValid(const Scene& scene) {
  EnsureFiles(scene);
  EnsureFile(scene.background);
  EnsureWithin(scene.timing.haptic_hz, 100, 10000);
  EnsureWithin(scene.timing.deformation_hz, 1, scene.timing.haptic_hz);
  EnsureWithin(scene.timing.render_hz, 1, 240);
  EnsureWithin(scene.timing.patch_delay_ticks, 1, 10000);
  EnsureWithin(static_cast<double>(scene.organs.size()), 1, kMaxOrgans);
  EnsureWithin(static_cast<double>(scene.instruments.size()), 0, kMaxInstruments);
  std::set<std::string> organs, instruments;
  for (const OrganOptions& organ : scene.organs) {
    EnsureName(organ.name, &organs);
    EnsureOrgan(organ);
  }
  for (const InstrumentOptions& instrument : scene.instruments) {
    EnsureInstrument(instrument, &instruments);
    HPDM_ENSURE(organs.count(instrument.hand.organ) == 1);
  }
  for (const LoadOptions& load : scene.loads) EnsureLoad(load, organs);
  const LaparoscopeOptions& scope = scene.laparoscope;
  HPDM_ENSURE((scope.p_target_W - scope.p_scope_W).norm() > 0.002);
  EnsureWithin(scope.field_of_view, 0.1, 2.6);
  EnsureWithin(scope.distortion, -0.3, 0.3);
}

/// The scene's file, beside files for it to name.
class Folder : public InputFile {
 public:
  Folder() : InputFile("scene.toml") {
    for (const char* name : {"m.obj", "t.png", "t.csv"}) std::ofstream(*this / name) << "here\n";
  }
};

}  // namespace

bool SceneFile(Bytes bytes) {
  static const Folder file;
  file.Write(bytes);
  try {
    const Scene scene = LoadScene(file.path());
    HPDM_ENSURE(scene.source_text == Text(bytes));
    EnsureValid(scene);
    return true;
  } catch (const InputError& error) {
    EnsureOneLine(error, file.path());
    return false;
  }
}

}  // namespace hpdm::fuzz
