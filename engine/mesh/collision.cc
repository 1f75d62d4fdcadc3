#include "engine/mesh/collision.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/AABB.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "engine/mesh/closest_point.h"

namespace hpdm {

using Aabb = fcl::AABB<double>;
using Model = fcl::BVHModel<Aabb>;

struct SurfaceTree::Tree {
  // What motion does not change, for all copies of a tree.
  struct Nodes {
    // Of each node: the first of its two children, which are neighbours and follow it; or, of a leaf,
    // -1 less its triangle.
    std::vector<int> links;
    std::vector<int> box;  // of each node, in `boxes`; -1: a leaf
    std::vector<std::array<int, 3>> triangles;
  };

  std::shared_ptr<const Nodes> nodes;
  std::vector<Aabb> boxes;         // of the nodes that are no leaves, m
  std::vector<Vector3d> vertices;  // m

  int size() const { return static_cast<int>(nodes->links.size()); }
  bool IsLeaf(int id) const { return nodes->links[ToSize(id)] < 0; }
  int Left(int id) const { return nodes->links[ToSize(id)]; }
  int Right(int id) const { return nodes->links[ToSize(id)] + 1; }
  int Triangle(int id) const { return -nodes->links[ToSize(id)] - 1; }
  // A leaf's box is that of its triangle: half of the nodes need no box in the copies.
  Aabb Box(int id) const {
    const int box = nodes->box[ToSize(id)];
    if (box >= 0) return boxes[ToSize(box)];
    const auto [i, j, k] = nodes->triangles[ToSize(Triangle(id))];
    const Vector3d &a = vertices[ToSize(i)], &b = vertices[ToSize(j)], &c = vertices[ToSize(k)];
    Aabb leaf;
    leaf.min_ = a.cwiseMin(b).cwiseMin(c);
    leaf.max_ = a.cwiseMax(b).cwiseMax(c);
    return leaf;
  }
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
  // meets. For segments; of a point the boxes' distance says it all.
  bool Passes(const Aabb& other, double reach2) const {
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
template <typename Tree, typename Visit>
void WalkFrom(const Tree& tree, int node_id, const Query& query, const double* bound2,
              const Visit& visit) {
  if (tree.IsLeaf(node_id)) {
    visit(tree.Triangle(node_id));
    return;
  }
  int near = tree.Left(node_id), far = tree.Right(node_id);
  double near2 = SquaredDistance(tree.Box(near), query.box);
  double far2 = SquaredDistance(tree.Box(far), query.box);
  if (far2 < near2) {
    std::swap(near, far);
    std::swap(near2, far2);
  }
  for (const auto& [child, distance2] : {std::pair(near, near2), std::pair(far, far2)}) {
    if (distance2 > *bound2) continue;
    if (!query.is_point && !query.Passes(tree.Box(child), *bound2)) continue;
    WalkFrom(tree, child, query, bound2, visit);
  }
}

template <typename Tree, typename Visit>
void Walk(const Tree& tree, const Query& query, const double* bound2, const Visit& visit) {
  if (SquaredDistance(tree.Box(0), query.box) > *bound2) return;
  WalkFrom(tree, 0, query, bound2, visit);
}

// Boxes of one tree against those of another, grown by `reach` and moved.
template <typename Tree>
struct BoxPairs {
  const Tree& tree;
  const Tree& other;
  Vector3d offset;
  double reach;

  bool Meet(int id, int other_id) const {
    const Aabb a = tree.Box(id);
    const Aabb b = other.Box(other_id);
    return ((a.min_ - b.max_ - offset).array() <= reach).all() &&
           ((b.min_ + offset - a.max_).array() <= reach).all();
  }

  // True if a leaf below `other_id`, whose box meets that of `id`, does so too.
  bool MeetsLeaf(int id, int other_id) const {
    if (other.IsLeaf(other_id)) return true;
    for (const int child : {other.Left(other_id), other.Right(other_id)}) {
      if (Meet(id, child) && MeetsLeaf(id, child)) return true;
    }
    return false;
  }

  // `other_id` holds all of the other tree that meets the box of `id`.
  template <typename Visit>
  void Walk(int id, int other_id, const Visit& visit) const {
    for (;;) {  // to the smallest node that holds them
      if (other.IsLeaf(other_id)) break;
      const bool left = Meet(id, other.Left(other_id)), right = Meet(id, other.Right(other_id));
      if (!left && !right) return;
      if (left && right) break;
      other_id = left ? other.Left(other_id) : other.Right(other_id);
    }
    if (tree.IsLeaf(id)) {
      if (MeetsLeaf(id, other_id)) visit(tree.Triangle(id));
      return;
    }
    for (const int child : {tree.Left(id), tree.Right(id)}) {
      if (Meet(child, other_id)) Walk(child, other_id, visit);
    }
  }
};

struct Corners {
  const Vector3d &a, &b, &c;
};

template <typename Tree>
Corners CornersOf(const Tree& tree, int triangle) {
  const auto [a, b, c] = tree.nodes->triangles[ToSize(triangle)];
  return {tree.vertices[ToSize(a)], tree.vertices[ToSize(b)], tree.vertices[ToSize(c)]};
}

}  // namespace

SurfaceTree::SurfaceTree(const Points& vertices, const Triangles& triangles)
    : tree_(std::make_unique<Tree>()) {
  HPDM_CHECK(triangles.rows() >= 1);
  Model model;
  model.bv_splitter =
      std::make_shared<fcl::detail::BVSplitter<Aabb>>(fcl::detail::SPLIT_METHOD_BV_CENTER);
  Tree::Nodes nodes;
  tree_->vertices.resize(ToSize(vertices.rows()));
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) tree_->vertices[ToSize(v)] = vertices.row(v);
  std::vector<fcl::Triangle> faces;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    nodes.triangles.push_back({triangles(t, 0), triangles(t, 1), triangles(t, 2)});
    faces.emplace_back(triangles(t, 0), triangles(t, 1), triangles(t, 2));
  }
  model.beginModel(static_cast<int>(triangles.rows()), static_cast<int>(vertices.rows()));
  model.addSubModel(tree_->vertices, faces);
  model.endModel();
  for (int id = 0; id < model.getNumBVs(); ++id) {
    const auto& node = model.getBV(id);
    if (node.isLeaf()) {
      nodes.links.push_back(-node.primitiveId() - 1);
      nodes.box.push_back(-1);
      continue;
    }
    nodes.links.push_back(node.leftChild());
    nodes.box.push_back(static_cast<int>(tree_->boxes.size()));
    tree_->boxes.push_back(node.bv);
    // Refit visits the nodes from the last to the first, so children must come after their parent.
    HPDM_CHECK(node.leftChild() > id && node.rightChild() == node.leftChild() + 1);
  }
  tree_->nodes = std::make_shared<const Tree::Nodes>(std::move(nodes));
}

SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree::SurfaceTree(const SurfaceTree& other) : tree_(std::make_unique<Tree>(*other.tree_)) {}

SurfaceTree& SurfaceTree::operator=(const SurfaceTree& other) {
  HPDM_CHECK(other.tree_->vertices.size() == tree_->vertices.size() &&
             other.tree_->size() == tree_->size());
  *tree_ = *other.tree_;
  return *this;
}

void SurfaceTree::Refit(const Points& vertices) {
  Tree& tree = *tree_;
  HPDM_CHECK(ToSize(vertices.rows()) == tree.vertices.size());
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) tree.vertices[ToSize(v)] = vertices.row(v);
  for (int id = tree.size() - 1; id >= 0; --id) {
    if (tree.IsLeaf(id)) continue;
    const Aabb left = tree.Box(tree.Left(id)), right = tree.Box(tree.Right(id));
    Aabb& box = tree.boxes[ToSize(tree.nodes->box[ToSize(id)])];
    box.min_ = left.min_.cwiseMin(right.min_);
    box.max_ = left.max_.cwiseMax(right.max_);
  }
}

SurfaceHit SurfaceTree::Closest(const Vector3d& p, double max_distance) const {
  const Tree& tree = *tree_;
  SurfaceHit best;
  double best2 = max_distance * max_distance;
  Walk(tree, Query(p), &best2, [&](int triangle) {
    const Corners t = CornersOf(tree, triangle);
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
  const Tree& tree = *tree_;
  SurfaceHit best;
  double best2 = max_distance * max_distance;
  Walk(tree, Query(start, end), &best2, [&](int triangle) {
    const Corners t = CornersOf(tree, triangle);
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
  const Tree& tree = *tree_;
  SurfaceHit first;
  first.along = std::numeric_limits<double>::infinity();
  const double touching = 0;
  Walk(tree, Query(start, end), &touching, [&](int triangle) {
    const Corners t = CornersOf(tree, triangle);
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
  Walk(*tree_, Query(p), &reach2, [&](int triangle) {
    const double next = visit(visitor, triangle);
    reach2 = next * next;
  });
}

void SurfaceTree::Visit(const SurfaceTree& other, const Vector3d& offset, double reach,
                        void (*visit)(void*, int), void* visitor) const {
  const BoxPairs<Tree> pairs{*tree_, *other.tree_, offset, reach};
  if (!pairs.Meet(0, 0)) return;
  pairs.Walk(0, 0, [&](int triangle) { visit(visitor, triangle); });
}

}  // namespace hpdm
