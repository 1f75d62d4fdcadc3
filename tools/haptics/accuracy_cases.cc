#include "tools/haptics/accuracy_cases.h"

#include <optional>

#include "engine/base/error.h"

namespace hpdm {
namespace {

struct Hands {
  const char* name;
  std::optional<HandScript> first;
  std::optional<HandScript> second;
  bool rub = false;  // with friction
};

// Coulomb: enough for a slide to stick and to slip.
constexpr double kFriction = 0.3;

constexpr Hands kHands[] = {
    {"press", HandScript::kPalpate, {}},
    {"slide", HandScript::kSlide, {}},
    {"tap", HandScript::kTap, {}},
    {"grasp_pull", {}, HandScript::kGraspPull},
    {"press_grasp_pull", HandScript::kPalpate, HandScript::kGraspPull},
    {"slide_press", HandScript::kSlide, HandScript::kPalpate},
    {"slide_friction", HandScript::kSlide, {}, true},
    {"slide_press_friction", HandScript::kSlide, HandScript::kPalpate, true},
};

Scene WithHands(const Scene& scene, const Hands& hands, StrainMeasure strain) {
  Scene trial = scene;
  for (OrganOptions& organ : trial.organs) {
    organ.energy.strain = strain;
    if (strain == StrainMeasure::kFinite) organ.lattice.local.functions = 0;
  }
  trial.instruments.clear();
  for (const auto& [instrument, script] : {std::pair(scene.instruments[0], hands.first),
                                           std::pair(scene.instruments[1], hands.second)}) {
    if (!script.has_value()) continue;
    trial.instruments.push_back(instrument);
    trial.instruments.back().hand.script = *script;
    trial.instruments.back().geometry.friction = hands.rub ? kFriction : 0;
  }
  return trial;
}

}  // namespace

std::vector<AccuracyCase> AccuracyCases(const Scene& scene, bool quick) {
  if (scene.instruments.size() < 2 || scene.instruments[1].type != InstrumentType::kGrasper) {
    throw InputError(scene.path.string() +
                     ": needs two instruments; give it a second one of type \"grasper\"");
  }
  std::vector<AccuracyCase> cases;
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    const bool finite = strain == StrainMeasure::kFinite;
    if (quick && finite) break;
    for (const Hands& hands : kHands) {
      cases.push_back({hands.name + std::string(finite ? "_finite" : ""),
                       WithHands(scene, hands, strain), quick ? 1.6 : 3});
    }
  }
  return cases;
}

}  // namespace hpdm
