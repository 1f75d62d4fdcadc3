#include "render/overlay/contact_marks.h"

#include <algorithm>
#include <array>

#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

constexpr double kNormalLength = 0.02;     // m
constexpr double kMinMarkRadius = 0.0025;  // m, for grasps, whose contact has no kernel
constexpr double kHeadShare = 0.3;         // length of an arrow's head over the arrow's
const Colour kVertexColour(1.0f, 0.95f, 0.45f);
const Colour kContactColour(1.0f, 1.0f, 1.0f);
const Colour kNormalColour(0.35f, 0.90f, 1.0f);
const Colour kForceColour(1.0f, 0.80f, 0.10f);

void AddPoint(const Eigen::Vector3f& p, float radius, const Colour& colour, Marks* marks) {
  marks->push_back({.a_W = p, .radius_a = radius, .b_W = p, .radius_b = radius, .colour = colour});
}

void AddArrow(const Vector3d& from, const Vector3d& arrow, float radius, const Colour& colour,
              Marks* marks) {
  const Eigen::Vector3f start = from.cast<float>(), end = (from + arrow).cast<float>();
  const Eigen::Vector3f neck = (from + (1 - kHeadShare) * arrow).cast<float>();
  marks->push_back(
      {.a_W = start, .radius_a = radius, .b_W = neck, .radius_b = radius, .colour = colour});
  marks->push_back(
      {.a_W = neck, .radius_a = 3 * radius, .b_W = end, .radius_b = 0, .colour = colour});
}

}  // namespace

void AddContactMarks(const SolvedContact& contact, const OrganSnapshot& shape,
                     const Triangles& triangles, Marks* marks) {
  // A tip near the surface has a contact without a force.
  if (contact.kind == ContactKind::kNone || contact.force_on_tissue_W.isZero(0)) return;
  const double radius = std::max(contact.kernel_radius, kMinMarkRadius);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    std::array<Vector3d, 3> corners;
    for (int k = 0; k < 3; ++k) {
      corners[k] = shape.vertices.row(triangles(t, k)).transpose().cast<double>() + shape.offset_W;
    }
    const Vector3d nearest =
        ClosestOnTriangle(contact.contact_W, corners[0], corners[1], corners[2]).point;
    if ((nearest - contact.contact_W).squaredNorm() > radius * radius) continue;
    for (const Vector3d& corner : corners) {
      AddPoint(corner.cast<float>(), 2.5f, kVertexColour, marks);
    }
  }
  AddPoint(contact.contact_W.cast<float>(), 3.5f, kContactColour, marks);
  AddArrow(contact.contact_W, kNormalLength * contact.normal_W, 1.0f, kNormalColour, marks);
  AddArrow(contact.contact_W, -kArrowLength * contact.force_on_tissue_W, 2.0f, kForceColour, marks);
}

}  // namespace hpdm
