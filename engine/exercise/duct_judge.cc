#include "engine/exercise/duct_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/angle.h"
#include "engine/base/check.h"
#include "engine/base/format.h"

namespace hpdm {
namespace {

// Clips that must be left on the organ's side of a cut.
constexpr int kLeftOnOrgan = 1;

// Returns what the jaws alone decide.
ClipFinding FindingOfJaws(const DuctAction& clip, double angle) {
  ClipFinding finding;
  finding.angle = clip.angle;
  finding.most_angle = angle;
  finding.coverage = clip.coverage;
  if (clip.angle > angle) finding.faults |= kClipOblique;
  if (clip.coverage < DuctJudge::kLeastCoverage) finding.faults |= kClipShort;
  return finding;
}

}  // namespace

DuctJudge::DuctJudge(std::vector<ExerciseDuct> ducts, int stay) : stay_(stay) {
  for (const ExerciseDuct& duct : ducts) ducts_.push_back({.options = duct});
}

const DuctJudge::Duct* DuctJudge::Find(int duct) const {
  const auto at = static_cast<std::size_t>(duct);
  return duct >= 0 && at < ducts_.size() ? &ducts_[at] : nullptr;
}

bool DuctJudge::IsGood(const DuctAction& clip, double angle) const {
  return Find(clip.duct) != nullptr && Examine(clip, angle).faults == kClipSound;
}

ClipFinding DuctJudge::Examine(const DuctAction& clip, double angle) const {
  const Duct* duct = Find(clip.duct);
  if (duct == nullptr) return FindingOfJaws(clip, angle);
  double gap = std::numeric_limits<double>::infinity();
  for (const Clip& other : duct->clips) gap = std::min(gap, std::abs(other.arc - clip.arc));
  return Examine(clip, gap, duct->options, angle);
}

ClipFinding DuctJudge::Examine(const DuctAction& clip, double gap, const ExerciseDuct& duct,
                               double angle) {
  ClipFinding finding = FindingOfJaws(clip, angle);
  finding.to_clip = gap - kClipWidth;
  if (finding.to_clip < kLeastGap) finding.faults |= kClipNearClip;
  finding.to_end = std::numeric_limits<double>::infinity();
  const double least = kLeastToEnd + kClipWidth / 2;
  const auto measure_end = [&](int end, double from_end) {
    if (duct.organ_end == end) return;
    finding.to_end = std::min(finding.to_end, from_end - kClipWidth / 2);
    if (from_end < least) finding.faults |= kClipNearEnd;
  };
  measure_end(0, clip.arc);
  measure_end(1, clip.length - clip.arc);
  return finding;
}

void DuctJudge::Keep(const DuctAction& action, bool good) {
  if (Find(action.duct) == nullptr) return;
  Duct& duct = ducts_[static_cast<std::size_t>(action.duct)];
  if (action.kind == DuctActionKind::kClip) {
    duct.clips.push_back({action.arc, action.coverage >= kLeastCoverage, good});
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
  return AreEnough(at_a, at_b, found->options, stay_);
}

bool DuctJudge::AreEnough(int at_a, int at_b, const ExerciseDuct& duct, int stay) {
  return at_a >= (duct.organ_end == 0 ? kLeftOnOrgan : stay) &&
         at_b >= (duct.organ_end == 1 ? kLeftOnOrgan : stay);
}

std::string FaultText(const ClipFinding& clip, const std::string& duct, bool keys) {
  constexpr double kMilli = 1e3, kPerCent = 100;
  std::string text;
  const auto add = [&](ClipFault fault, const std::string& part) {
    if ((clip.faults & fault) != 0) text += (text.empty() ? "" : "; ") + part;
  };
  add(kClipOblique, Format("oblique: %.0f\u00b0 (at most %.0f\u00b0)", clip.angle / kDegree,
                           clip.most_angle / kDegree) +
                        (keys ? ": roll it (q, e) or turn the tube" : ""));
  add(kClipShort,
      Format("covers %.0f %% of the width (at least %.0f %%)", std::floor(kPerCent * clip.coverage),
             kPerCent * DuctJudge::kLeastCoverage));
  add(kClipNearClip, clip.to_clip < 0
                         ? std::string("on another clip")
                         : Format("%.1f mm from the next clip (at least %g mm)",
                                  kMilli * clip.to_clip, kMilli * DuctJudge::kLeastGap));
  add(kClipNearEnd, Format("%.1f mm from the end that stays (at least %g mm)",
                           std::max(0.0, kMilli * clip.to_end), kMilli * DuctJudge::kLeastToEnd));
  add(kClipOnNothing, "no duct between the jaws");
  add(kClipRefused, "no room for a clip there");
  return text.empty() || duct.empty() ? text : duct + ": " + text;
}

}  // namespace hpdm
