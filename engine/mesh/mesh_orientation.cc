#include "engine/mesh/mesh_orientation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/mesh/mesh_edges.h"
#include "engine/mesh/winding_number.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxContainers = 64;
constexpr int kContainmentPoints = 8;
/// Least volume about the centroid over area^1.5 of an open patch that clearly bulges: a fifth of a
/// hemisphere's 0.1. A flat sheet has 0.
constexpr double kBulge = 0.02;

/// Triangles connected through edges of exactly two triangles.
struct Patch {
  std::vector<int> triangles;
  bool closed = true;
  double volume = 0;  ///< m^3, signed by the present orientation; about its centroid.
  double area = 0;
  double turned_area = 0;  ///< Area of the triangles that were flipped to agree with the first one.
  Eigen::AlignedBox3d box;
};

class Orienter {
 public:
  explicit Orienter(SurfaceMesh* mesh)
      : vertices_(mesh->vertices),
        triangles_(mesh->triangles),
        texture_coordinates_(mesh->texture_coordinates),
        turned_(static_cast<std::size_t>(mesh->triangles.rows())),
        patch_of_(static_cast<std::size_t>(mesh->triangles.rows()), -1) {}

  int Orient() {
    LinkNeighbours();
    for (int t = 0; t < triangles_.rows(); ++t) {
      if (patch_of_[Index(t)] < 0) GrowPatch(t);
    }
    for (Patch& patch : patches_) {
      Measure(&patch);
      const bool bulges = std::abs(patch.volume) > kBulge * std::pow(patch.area, 1.5);
      const bool outwards =
          patch.closed || bulges ? patch.volume >= 0 : 2 * patch.turned_area <= patch.area;
      if (!outwards) Turn(&patch);
    }
    TurnCavities();
    return static_cast<int>(std::count(turned_.begin(), turned_.end(), true));
  }

 private:
  struct Link {
    int triangle = -1;
    bool agrees = true;
  };

  static std::size_t Index(int i) { return static_cast<std::size_t>(i); }

  void LinkNeighbours() {
    links_.resize(Index(static_cast<int>(triangles_.rows())));
    std::vector<int> count(links_.size());
    ForEachEdge(SortedEdgeUses(triangles_), [&](auto first, auto last) {
      if (last - first != 2) return;
      const auto second = first + 1;
      const bool agrees = first->forward != second->forward;
      links_[Index(first->triangle)][Index(count[Index(first->triangle)]++)] = {second->triangle,
                                                                                agrees};
      links_[Index(second->triangle)][Index(count[Index(second->triangle)]++)] = {first->triangle,
                                                                                  agrees};
    });
  }

  void GrowPatch(int seed) {
    const int number = static_cast<int>(patches_.size());
    Patch& patch = patches_.emplace_back();
    patch.triangles.push_back(seed);
    patch_of_[Index(seed)] = number;
    for (std::size_t next = 0; next < patch.triangles.size(); ++next) {
      const int t = patch.triangles[next];
      for (const Link& link : links_[Index(t)]) {
        if (link.triangle < 0) {
          patch.closed = false;
        } else if (patch_of_[Index(link.triangle)] < 0) {
          patch_of_[Index(link.triangle)] = number;
          patch.triangles.push_back(link.triangle);
          if (turned_[Index(t)] == link.agrees) TurnTriangle(link.triangle);
        }
      }
    }
  }

  void TurnTriangle(int t) {
    std::swap(triangles_(t, 1), triangles_(t, 2));
    if (texture_coordinates_.rows() > 0) {
      texture_coordinates_.row(3 * t + 1).swap(texture_coordinates_.row(3 * t + 2));
    }
    turned_[Index(t)] = !turned_[Index(t)];
  }

  void Turn(Patch* patch) {
    for (const int t : patch->triangles) TurnTriangle(t);
    patch->volume = -patch->volume;
  }

  Vector3d Vertex(int t, int corner) const { return vertices_.row(triangles_(t, corner)); }

  void Measure(Patch* patch) const {
    Vector3d centroid = Vector3d::Zero();
    for (const int t : patch->triangles) {
      const Vector3d a = Vertex(t, 0), b = Vertex(t, 1), c = Vertex(t, 2);
      const double area = (b - a).cross(c - a).norm() / 2;
      patch->area += area;
      if (turned_[Index(t)]) patch->turned_area += area;
      centroid += area * (a + b + c) / 3;
      patch->box.extend(a).extend(b).extend(c);
    }
    if (patch->area > 0) centroid /= patch->area;
    for (const int t : patch->triangles) {
      const Vector3d a = Vertex(t, 0) - centroid, b = Vertex(t, 1) - centroid,
                     c = Vertex(t, 2) - centroid;
      patch->volume += a.dot(b.cross(c)) / 6;
    }
  }

  /// Requires that all closed patches face outwards.
  void TurnCavities() {
    std::vector<int> containers;
    for (std::size_t p = 0; p < patches_.size(); ++p) {
      if (patches_[p].closed) containers.push_back(static_cast<int>(p));
    }
    if (containers.size() < 2) return;
    std::stable_sort(containers.begin(), containers.end(), [&](int p, int q) {
      return patches_[Index(p)].volume > patches_[Index(q)].volume;
    });
    const std::vector<int> closed = containers;
    containers.resize(std::min(containers.size(), kMaxContainers));

    std::vector<std::unique_ptr<WindingNumber>> windings(containers.size());
    std::vector<int> cavities;
    for (std::size_t rank = 0; rank < closed.size(); ++rank) {
      const Patch& patch = patches_[Index(closed[rank])];
      int around = 0;
      for (std::size_t c = 0; c < std::min(rank, containers.size()); ++c) {
        const Patch& container = patches_[Index(containers[c])];
        if (!container.box.contains(patch.box)) continue;
        if (!windings[c]) windings[c] = MakeWinding(container);
        if (Contains(*windings[c], patch)) ++around;
      }
      if (around % 2 == 1) cavities.push_back(closed[rank]);
    }
    for (const int p : cavities) Turn(&patches_[Index(p)]);
  }

  std::unique_ptr<WindingNumber> MakeWinding(const Patch& patch) const {
    Triangles triangles(static_cast<Eigen::Index>(patch.triangles.size()), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
      triangles.row(t) = triangles_.row(patch.triangles[static_cast<std::size_t>(t)]);
    }
    return std::make_unique<WindingNumber>(vertices_, triangles);
  }

  /// Tests several points, because patches may cross instead of one containing the other.
  bool Contains(const WindingNumber& container, const Patch& patch) const {
    const std::size_t step = std::max<std::size_t>(1, patch.triangles.size() / kContainmentPoints);
    for (std::size_t i = 0; i < patch.triangles.size(); i += step) {
      if (container.At(Vertex(patch.triangles[i], 0)) < 0.5) return false;
    }
    return true;
  }

  const Points& vertices_;
  Triangles& triangles_;
  TextureCoordinates& texture_coordinates_;
  std::vector<std::array<Link, 3>> links_;
  std::vector<bool> turned_;
  std::vector<int> patch_of_;
  std::vector<Patch> patches_;
};

}  // namespace

int OrientTriangles(SurfaceMesh* mesh) { return Orienter(mesh).Orient(); }

}  // namespace hpdm
