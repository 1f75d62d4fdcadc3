#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "engine/exercise/exercise_options.h"
#include "engine/mesh/closest_point.h"
#include "engine/snapshots.h"

/// Questions about one step that an exercise's rules ask.
namespace hpdm {

inline bool Contains(const std::vector<int>& numbers, int number) {
  return std::ranges::find(numbers, number) != numbers.end();
}

inline bool IsOneOf(const std::vector<ExerciseTool>& tools, int hand, int instrument_index) {
  return tools.empty() || std::ranges::any_of(tools, [&](const ExerciseTool& tool) {
           return tool.hand == hand && tool.instrument_index == instrument_index;
         });
}

/// Visits the contacts of one tip: the main one and those on other organs.
template <typename Visit>
void VisitContacts(const StepSample& sample, int hand, const Visit& visit) {
  const auto h = static_cast<std::size_t>(hand);
  if (sample.contacts[h].organ >= 0) visit(sample.contacts[h]);
  for (const SolvedContact& contact : sample.beside[h]) {
    if (contact.organ >= 0) visit(contact);
  }
}

inline bool Touches(const SolvedContact& contact) {
  return contact.kind != ContactKind::kNone && contact.force_on_tissue_W.squaredNorm() > 0;
}

inline bool Presses(const StepSample& sample, int hand, int organ) {
  bool presses = false;
  VisitContacts(sample, hand, [&](const SolvedContact& contact) {
    presses = presses || (contact.organ == organ && Touches(contact));
  });
  return presses;
}

/// True if the contact is a grasp of the wanted organ by a wanted instrument.
inline bool IsHold(const ExerciseContact& wanted, const SolvedContact& contact, int hand,
                   int instrument_index) {
  return contact.kind == ContactKind::kGrasp && contact.organ == wanted.organ &&
         IsOneOf(wanted.with, hand, instrument_index);
}

inline double LiftOf(const SolvedContact& contact) {
  return (contact.contact_W - contact.p_original_W).norm();
}

inline double TornArea(const StepSample& sample, int attachment) {
  double area = 0;
  for (int a = 0; a < sample.attachment_count; ++a) {
    if (attachment >= 0 && a != attachment) continue;
    const AttachmentOutcome& layer = sample.attachments[static_cast<std::size_t>(a)];
    area += layer.freed_area - layer.burnt_area - layer.cut_area;
  }
  return area;
}

/// Returns what of these attachments is free, m^2.
inline double FreedArea(const StepSample& sample, const std::vector<int>& attachments) {
  double area = 0;
  for (const int a : attachments) {
    if (a < sample.attachment_count)
      area += sample.attachments[static_cast<std::size_t>(a)].freed_area;
  }
  return area;
}

/// True if a rule for ducts is meant for this one.
inline bool Means(const ExerciseErrorOptions& error, int duct) {
  return error.ducts.empty() || Contains(error.ducts, duct);
}

/// Returns the largest angle of a good clip on a duct, rad: the least of its rules.
inline double ClipAngleOf(const ExerciseOptions& options, int duct) {
  std::optional<double> least;
  for (const ExerciseErrorOptions& error : options.errors) {
    if (error.kind != ExerciseErrorKind::kBadClip || !Means(error, duct)) continue;
    least = std::min(least.value_or(error.limit), error.limit);
  }
  return least.value_or(kClipAngle);
}

/// Returns the step that must be done before a clip (kEarlyClip) or a cut (kEarlyCut) of a duct, -1: none
/// that is not. `done`: how many steps are.
inline int StepBefore(const ExerciseOptions& options, ExerciseErrorKind kind, int duct, int done) {
  for (const ExerciseErrorOptions& error : options.errors) {
    if (error.kind == kind && Means(error, duct) && done <= error.before) return error.before;
  }
  return -1;
}

/// Returns the distance of a point from a line through points, m.
inline double DistanceTo(const std::vector<Vector3d>& path_W, const Vector3d& p_W) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < path_W.size(); ++i) {
    const Vector3d nearest_W = ClosestPointOnSegment(p_W, path_W[i], path_W[i + 1]);
    least = std::min(least, (p_W - nearest_W).norm());
  }
  return least;
}

}  // namespace hpdm
