#include "engine/mesh/collision.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/AABB.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/check.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {

using Aabb = fcl::AABB<double>;
using Model = fcl::BVHModel<Aabb>;

struct SurfaceTree::Tree {
  Model model;
};

namespace {

double SquaredDistance(const Aabb& a, const Aabb& b) {
  const Vector3d gap = (a.min_ - b.max_).cwiseMax(b.min_ - a.max_).cwiseMax(Vector3d::Zero());
  return gap.squaredNorm();
}

// A point or a segment with its own bounding box.
struct Query {
  Query(const Vector3d& p) : Query(p, p) {}
  Query(const Vector3d& from, const Vector3d& to)
      : box(from, to), start(from), way(to - from), is_point(from == to) {}

  // True if the segment comes as near to the box as sqrt(reach2) along every axis: necessary for a
  // distance of sqrt(reach2). Rejects most boxes that only the bounding box of a slanted segment
  // meets.
  bool Passes(const Aabb& other, double reach2) const {
    if (is_point) return true;          // the caller has compared the boxes
    constexpr double kRounding = 1e-9;  // m
    const double reach = std::sqrt(reach2) + kRounding;
    double enter = 0, leave = 1;
    for (int d = 0; d < 3; ++d) {
      const double low = other.min_[d] - reach - start[d], high = other.max_[d] + reach - start[d];
      if (way[d] == 0) {
        if (low > 0 || high < 0) return false;
        continue;
      }
      const double a = low / way[d], b = high / way[d];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }

  Aabb box;
  Vector3d start, way;
  bool is_point;
};

// Visits the leaves whose box is closer to the query than sqrt(*bound2), near children first;
// `visit` may lower the bound. The recursion is as deep as the tree: usually log2 F, at most F with
// FCL's middle split.
template <typename Visit>
void WalkFrom(const Model& model, int node_id, const Query& query, const double* bound2,
              const Visit& visit) {
  const auto& node = model.getBV(node_id);
  if (node.isLeaf()) {
    visit(node.primitiveId());
    return;
  }
  int near = node.leftChild(), far = node.rightChild();
  double near2 = SquaredDistance(model.getBV(near).bv, query.box);
  double far2 = SquaredDistance(model.getBV(far).bv, query.box);
  if (far2 < near2) {
    std::swap(near, far);
    std::swap(near2, far2);
  }
  for (const auto& [child, distance2] : {std::pair(near, near2), std::pair(far, far2)}) {
    if (distance2 > *bound2 || !query.Passes(model.getBV(child).bv, *bound2)) continue;
    WalkFrom(model, child, query, bound2, visit);
  }
}

template <typename Visit>
void Walk(const Model& model, const Query& query, const double* bound2, const Visit& visit) {
  if (SquaredDistance(model.getBV(0).bv, query.box) > *bound2) return;
  WalkFrom(model, 0, query, bound2, visit);
}

// Boxes of one tree against those of another, grown by `reach` and moved.
struct BoxPairs {
  const Model& model;
  const Model& other;
  Vector3d offset;
  double reach;

  bool Meet(int id, int other_id) const {
    const Aabb& a = model.getBV(id).bv;
    const Aabb& b = other.getBV(other_id).bv;
    return ((a.min_ - b.max_ - offset).array() <= reach).all() &&
           ((b.min_ + offset - a.max_).array() <= reach).all();
  }

  // True if a leaf below `other_id`, whose box meets that of `id`, does so too.
  bool MeetsLeaf(int id, int other_id) const {
    const auto& node = other.getBV(other_id);
    if (node.isLeaf()) return true;
    for (const int child : {node.leftChild(), node.rightChild()}) {
      if (Meet(id, child) && MeetsLeaf(id, child)) return true;
    }
    return false;
  }

  // `other_id` holds all of the other tree that meets the box of `id`.
  template <typename Visit>
  void Walk(int id, int other_id, const Visit& visit) const {
    for (;;) {  // to the smallest node that holds them
      const auto& node = other.getBV(other_id);
      if (node.isLeaf()) break;
      const bool left = Meet(id, node.leftChild()), right = Meet(id, node.rightChild());
      if (!left && !right) return;
      if (left && right) break;
      other_id = left ? node.leftChild() : node.rightChild();
    }
    const auto& node = model.getBV(id);
    if (node.isLeaf()) {
      if (MeetsLeaf(id, other_id)) visit(node.primitiveId());
      return;
    }
    for (const int child : {node.leftChild(), node.rightChild()}) {
      if (Meet(child, other_id)) Walk(child, other_id, visit);
    }
  }
};

struct Corners {
  const Vector3d &a, &b, &c;
};

Corners CornersOf(const Model& model, int triangle) {
  const fcl::Triangle& t = model.tri_indices[triangle];
  return {model.vertices[t[0]], model.vertices[t[1]], model.vertices[t[2]]};
}

}  // namespace

SurfaceTree::SurfaceTree(const Points& vertices, const Triangles& triangles)
    : tree_(std::make_unique<Tree>()) {
  HPDM_CHECK(triangles.rows() >= 1);
  Model& model = tree_->model;
  model.bv_splitter =
      std::make_shared<fcl::detail::BVSplitter<Aabb>>(fcl::detail::SPLIT_METHOD_BV_CENTER);
  std::vector<Vector3d> points(vertices.rows());
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) points[v] = vertices.row(v);
  std::vector<fcl::Triangle> faces(triangles.rows());
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    faces[t] = fcl::Triangle(triangles(t, 0), triangles(t, 1), triangles(t, 2));
  }
  model.beginModel(static_cast<int>(triangles.rows()), static_cast<int>(vertices.rows()));
  model.addSubModel(points, faces);
  model.endModel();
  // Refit visits the nodes from the last to the first, so children must come after their parent.
  for (int id = 0; id < model.getNumBVs(); ++id) {
    const auto& node = model.getBV(id);
    HPDM_CHECK(node.isLeaf() || (node.leftChild() > id && node.rightChild() > id));
  }
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree::SurfaceTree(const SurfaceTree& other) : tree_(std::make_unique<Tree>(*other.tree_)) {}

SurfaceTree& SurfaceTree::operator=(const SurfaceTree& other) {
  Model& model = tree_->model;
  const Model& from = other.tree_->model;
  HPDM_CHECK(from.num_vertices == model.num_vertices && from.getNumBVs() == model.getNumBVs());
  std::copy_n(from.vertices, from.num_vertices, model.vertices);
  for (int id = 0; id < model.getNumBVs(); ++id) model.getBV(id).bv = from.getBV(id).bv;
  return *this;
}

void SurfaceTree::Refit(const Points& vertices) {
  Model& model = tree_->model;
  HPDM_CHECK(vertices.rows() == model.num_vertices);
  for (int v = 0; v < model.num_vertices; ++v) model.vertices[v] = vertices.row(v).transpose();
  for (int id = model.getNumBVs() - 1; id >= 0; --id) {
    auto& node = model.getBV(id);
    if (node.isLeaf()) {
      const Corners t = CornersOf(model, node.primitiveId());
      node.bv.min_ = t.a.cwiseMin(t.b).cwiseMin(t.c);
      node.bv.max_ = t.a.cwiseMax(t.b).cwiseMax(t.c);
    } else {
      const Aabb& left = model.getBV(node.leftChild()).bv;
      const Aabb& right = model.getBV(node.rightChild()).bv;
      node.bv.min_ = left.min_.cwiseMin(right.min_);
      node.bv.max_ = left.max_.cwiseMax(right.max_);
    }
  }
}

SurfaceHit SurfaceTree::Closest(const Vector3d& p, double max_distance) const {
  const Model& model = tree_->model;
  SurfaceHit best;
  double best2 = max_distance * max_distance;
  Walk(model, Query(p), &best2, [&](int triangle) {
    const Corners t = CornersOf(model, triangle);
    const TrianglePoint closest = ClosestOnTriangle(p, t.a, t.b, t.c);
    const double distance2 = (closest.point - p).squaredNorm();
    if (distance2 > best2) return;
    best2 = distance2;
    best.at = {triangle, closest.barycentric};
  });
  best.distance = std::sqrt(best2);
  return best;
}

SurfaceHit SurfaceTree::ClosestToSegment(const Vector3d& start, const Vector3d& end,
                                         double max_distance) const {
  const Model& model = tree_->model;
  SurfaceHit best;
  double best2 = max_distance * max_distance;
  Walk(model, Query(start, end), &best2, [&](int triangle) {
    const Corners t = CornersOf(model, triangle);
    const SegmentTrianglePair pair = ClosestSegmentTriangle(start, end, t.a, t.b, t.c);
    if (pair.squared_distance > best2) return;
    best2 = pair.squared_distance;
    best.at = {triangle, pair.on_triangle.barycentric};
    best.along = pair.along;
  });
  best.distance = std::sqrt(best2);
  return best;
}

SurfaceHit SurfaceTree::FirstTouch(const Vector3d& start, const Vector3d& end,
                                   const Vector3d& start_to, const Vector3d& end_to, double radius,
                                   double* share) const {
  constexpr int kMaxAdvances = 64;
  constexpr double kTouching = 1e-5;  // m
  const Vector3d start_way = start_to - start, end_way = end_to - end;
  const double way = std::max(start_way.norm(), end_way.norm());
  SurfaceHit hit;
  *share = 0;
  for (int i = 0; i < kMaxAdvances; ++i) {
    const double left = (1 - *share) * way;
    hit = ClosestToSegment(start + *share * start_way, end + *share * end_way,
                           radius + left + kTouching);
    if (hit.at.triangle < 0 || hit.distance <= radius + kTouching) return hit;
    if (*share == 1) return {};
    *share = std::min(1.0, *share + (hit.distance - radius) / way);
  }
  return hit;
}

SurfaceHit SurfaceTree::FirstEntry(const Vector3d& start, const Vector3d& end) const {
  const Model& model = tree_->model;
  SurfaceHit first;
  first.along = std::numeric_limits<double>::infinity();
  const double touching = 0;
  Walk(model, Query(start, end), &touching, [&](int triangle) {
    const Corners t = CornersOf(model, triangle);
    double along = 0;
    Vector3d barycentric;
    if (!CrossesFromFront(start, end, t.a, t.b, t.c, &along, &barycentric)) return;
    if (along >= first.along) return;
    first.along = along;
    first.at = {triangle, barycentric};
  });
  return first;
}

void SurfaceTree::Visit(const Vector3d& p, double reach, double (*visit)(void*, int),
                        void* visitor) const {
  double reach2 = reach * reach;
  Walk(tree_->model, Query(p), &reach2, [&](int triangle) {
    const double next = visit(visitor, triangle);
    reach2 = next * next;
  });
}

void SurfaceTree::Visit(const SurfaceTree& other, const Vector3d& offset, double reach,
                        void (*visit)(void*, int), void* visitor) const {
  const BoxPairs pairs{tree_->model, other.tree_->model, offset, reach};
  if (!pairs.Meet(0, 0)) return;
  pairs.Walk(0, 0, [&](int triangle) { visit(visitor, triangle); });
}

}  // namespace hpdm
