#pragma once

#include <gtest/gtest.h>

#include "engine/contact/contact_constraints.h"
#include "engine/organ_options.h"

namespace hpdm {

/// The third of a body with the least x, held.
inline SupportOptions OneEnd() { return {BoxFraction{Vector3d::Zero(), Vector3d(0.3, 1, 1)}, {}}; }

/// The vertex that lies farthest along world x, away from OneEnd().
inline int FarEnd(const SurfaceMesh& rest) {
  int v = 0;
  rest.vertices.col(0).maxCoeff(&v);
  return v;
}

/// Adds a row at the vertex v, which is to move by `move` (m, world). A press pushes against `normal`.
inline void AddVertex(ContactConstraints* contacts, const SurfaceMesh& rest,
                      ContactConstraints::RowKind kind, int v, const Vector3d& move,
                      const Vector3d& normal = Vector3d::UnitZ()) {
  ContactConstraints::Row* row = contacts->Add();
  ASSERT_NE(row, nullptr);
  row->kind = kind;
  row->p_rest_W = rest.vertices.row(v);
  row->target_W = row->p_rest_W + move;
  row->normal_W = normal;
  contacts->WeightRow(contacts->size() - 1)[v] = 1;
}

}  // namespace hpdm
