#include "engine/exercise/duct_judge.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Share of the lumen's width, below 1 by roundings.
constexpr double kWhole = 1 - 1e-9;
// Clips that must be left on the organ's side of a cut.
constexpr int kLeftOnOrgan = 1;

}  // namespace

DuctJudge::DuctJudge(std::vector<ExerciseDuct> ducts, int stay) : stay_(stay) {
  for (const ExerciseDuct& duct : ducts) ducts_.push_back({.options = duct});
}

const DuctJudge::Duct* DuctJudge::Find(int duct) const {
  const auto at = static_cast<std::size_t>(duct);
  return duct >= 0 && at < ducts_.size() ? &ducts_[at] : nullptr;
}

bool DuctJudge::IsGood(const DuctAction& clip, double angle) const {
  const Duct* duct = Find(clip.duct);
  if (duct == nullptr || clip.angle > angle || clip.coverage < kWhole) return false;
  const auto is_near = [&](const Clip& other) {
    return std::abs(other.arc - clip.arc) - kClipWidth < kLeastGap;
  };
  if (std::ranges::any_of(duct->clips, is_near)) return false;
  const double least = kLeastToEnd + kClipWidth / 2;
  const bool near_a = duct->options.organ_end != 0 && clip.arc < least;
  const bool near_b = duct->options.organ_end != 1 && clip.length - clip.arc < least;
  return !near_a && !near_b;
}

void DuctJudge::Keep(const DuctAction& action, bool good) {
  if (Find(action.duct) == nullptr) return;
  Duct& duct = ducts_[static_cast<std::size_t>(action.duct)];
  if (action.kind == DuctActionKind::kClip) {
    duct.clips.push_back({action.arc, action.coverage >= kWhole, good});
  } else if (action.kind == DuctActionKind::kCut) {
    duct.cuts.push_back(action.arc);
  }
}

int DuctJudge::GoodClips(int duct) const {
  const Duct* found = Find(duct);
  return found == nullptr ? 0 : static_cast<int>(std::ranges::count_if(found->clips, &Clip::good));
}

bool DuctJudge::IsCutWell(int duct) const {
  const Duct* found = Find(duct);
  if (found == nullptr || found->cuts.empty()) return false;
  const auto [first, last] = std::ranges::minmax(found->cuts);
  int at_a = 0, at_b = 0;
  for (const Clip& clip : found->clips) {
    at_a += clip.covers && clip.arc < first;
    at_b += clip.covers && clip.arc > last;
  }
  return at_a >= (found->options.organ_end == 0 ? kLeftOnOrgan : stay_) &&
         at_b >= (found->options.organ_end == 1 ? kLeftOnOrgan : stay_);
}

}  // namespace hpdm
