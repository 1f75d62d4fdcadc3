#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/organ/organ_state.h"
#include "engine/pairs/contact_cells.h"
#include "engine/pairs/creased_normals.h"

namespace hpdm {

/// A pair of facing points of organs A and B, with its share of the contact.
struct PairSample {
  SurfacePoint on_a;
  SurfacePoint on_b;
  double weight = 0;
};

/// A place where two organs touch or are about to: one row of the contact problem,
///     b_A = sum weight b(on_a),   b_B = sum weight b(on_b),   gap + n . (u_B - u_A) >= 0.
struct PairContact {
  std::uint64_t key = 0;                  ///< The same for the same material place in every step.
  Vector3d normal_W = Vector3d::UnitZ();  ///< Unit, from A to B: B must stay on this side of A.
  double gap = 0;  ///< m, sum weight n . (x_B - x_A); negative where they overlap.
  /// m, of the sample with the least gap along its own normal. It has a weight above zero.
  double least_gap = 0;
  double area = 0;  ///< m^2, of samples with gap <= 0; those up to kTouching count in part.
  std::span<const PairSample> samples;  ///< The weights sum to one.
};

/// A surface at rest. Both outlive the pair.
struct PairSurface {
  const SurfaceMesh* rest;
  const SurfaceTopology* topology;
};

/// A surface in a step: its world position is `vertices` (V x 3, m) moved by `offset_W` (m).
struct PairShape {
  const Points& vertices;
  const SurfaceTree& tree;  ///< Fits the vertices.
  Vector3d offset_W = Vector3d::Zero();
  double demand = 0;  ///< m: how far the step's tools are about to move it at most.
};

/// Finds where two organs touch, both deforming.
///
/// 1. The finer surface (smaller mean triangle; A if equal) carries samples and cells
///    (contact_cells.h). Both trees are descended together to its triangles near the other surface.
/// 2. Each sample there seeks the closest point of the other surface among the triangles that face
///    it. The far side of a thin wall does not. Its gap is the distance along the normal there.
/// 3. A sample found for the first time counts as inside if it is behind the closest of all
///    triangles (IsBehind). From then on it keeps its side: its partner moves at most kMostSlide
///    at rest from step to step, and the gap's sign is that of the partner's normal. So a sample
///    that a press drove through a wall comes back through it.
/// 4. Weights are smooth: area x exp(-gap / sharpness), faded out towards the margin, towards
///    normals that do not face each other, and beside the partner's edge. So forces do not jump
///    when samples come and go, and a cell that touches in a part has its row in that part. The
///    sharpness is half of how far the cell's own force indents the organs, at least
///    kSharpness. With less, a deeper sample would get so much more force that it were the less deep
///    one in the next step.
/// 5. Contacts within a margin count before they touch. It is kMargin and the motion of both
///    surfaces in the last step and the growth of the tools' demand since then, at most kMostMotion.
/// 6. At most kMaxPatches contacts. Where more cells touch, the cells of whole blocks
///    (contact_cells.h) are one contact each, first in the blocks that are farthest from touching. A
///    block that was one contact in the last step counts as farther. If all blocks together are still
///    too many, those with the largest integral of (margin - gap) over their area stay. A contact of
///    the last step counts half as much again, so that rows do not flicker.
///
/// Does not find a surface that was nowhere nearer than the margin before it jumped through a wall
/// within one step, nor an organ inside another without any of its samples within kMostDepth.
///
/// Sized once; deformation thread; a step allocates nothing.
class OrganPair {
 public:
  static constexpr int kMaxPatches = 48;
  static constexpr double kMargin = 0.002;      ///< m.
  static constexpr double kMostMotion = 0.010;  ///< m.
  /// The same of a pair with a free organ, m: 4.5 m/s at 30 steps a second.
  static constexpr double kMostFreeMotion = 0.15;
  /// What a free organ moves in a step over its last step's motion, at most, as it gains speed.
  static constexpr double kFreeGain = 1.5;
  /// Least sharpness over the gap, so that a far contact has weight.
  static constexpr double kFarShare = 0.1;
  static constexpr double kMostDepth = 0.015;    ///< m, of a sample found for the first time.
  static constexpr double kMostSlide = 0.010;    ///< m.
  static constexpr double kSharpness = 0.0003;   ///< m, without force.
  static constexpr double kTouching = 0.0002;    ///< m.
  static constexpr double kDefaultCell = 0.008;  ///< m.

  /// `cell_size`: m, of the cells (ContactCells).
  OrganPair(const PairSurface& a, const PairSurface& b, double cell_size = kDefaultCell);
  /// With cells of half the radius that the organs' lattices resolve, 5 to 10 mm.
  OrganPair(const OrganModel& a, const OrganModel& b);

  /// Finds the contacts of a step, in the order of their keys. They hold until the next Update().
  std::span<const PairContact> Update(const PairShape& a, const PairShape& b);
  /// The same without tools.
  std::span<const PairContact> Update(const OrganState& a, const OrganState& b) {
    return Update({a.vertices, a.tree, a.offset_W}, {b.vertices, b.tree, b.offset_W});
  }
  std::span<const PairContact> contacts() const { return {contacts_.data(), count_}; }

  /// Sets how far (m) the contact with a key of the last Update() is indented by its own force.
  /// Zero, as for all others: it does not press.
  void SetIndentation(std::uint64_t key, double indentation);

  /// False if there were more contacts or samples than there is room for.
  bool complete() const { return complete_; }
  double margin() const { return margin_; }  ///< m, of the last Update().

 private:
  static constexpr std::size_t kMaxFound = 8192;

  // One of the surfaces.
  struct Side {
    explicit Side(const PairSurface& pair_surface)
        : surface(pair_surface),
          normals(*pair_surface.rest, *pair_surface.topology),
          last_vertices(pair_surface.rest->vertices) {}
    PairSurface surface;
    CreasedNormals normals;
    Points last_vertices;  // m, of the last step
    Vector3d last_offset_W = Vector3d::Zero();
    double last_demand = 0;  // m

    // Returns how far it may move in this step: as in the last one, and what the tools' demand has
    // grown. A held press has the same demand in all steps, its tip's indentation.
    double ExpectedMotion(const PairShape& shape) const;
    void Remember(const PairShape& shape);
  };
  // State of a sample after the last step.
  struct Memory {
    int partner = -1;                            // triangle
    Vector3d p_partner_rest = Vector3d::Zero();  // m
    double gap = 0;                              // m
  };
  struct Found {
    int sample = 0;
    SurfacePoint partner;
    Vector3d p_sample, p_partner;  // m, in the target's frame
    Vector3d normal_difference;    // the sample's less the partner's
    double gap = 0;
    double area = 0;  // m^2, faded
  };
  struct Cell {
    std::uint32_t stamp = 0;
    bool kept = false;       // had a contact in the last step
    double indentation = 0;  // m, SetIndentation()
    int slot = -1;
    double weight = 0;
    double score = 0;
    double area = 0;
    double least_gap = 0;
    Vector3d p_sample, p_partner, normal_difference;

    void Begin(std::uint32_t step);
    void Add(const Cell& other);
  };
  // The cells that touch in a step, of one block.
  struct Block {
    std::uint32_t stamp = 0;
    int count = 0;
    double least_gap = 0;
    bool merged = false;       // in this step
    bool merged_last = false;  // in the last one
  };
  enum class Behind { kFront, kBack, kEither };

  void SetMargin(const PairShape& source, const PairShape& target);
  void Search(const PairShape& source, const PairShape& target, double reach);
  bool IsNear(int triangle, const PairShape& source, const PairShape& target, double reach) const;
  void SeekPartner(int sample, double triangle_area, const PairShape& source,
                   const PairShape& target, double reach);
  SurfacePoint ClosestFacing(const Vector3d& p, const Vector3d& normal, const PairShape& target,
                             double reach, Behind behind, const Memory* near) const;
  double Weight(const Found& found, int cell) const;
  void AddToCells(const Found& found);
  void MergeBlocks();
  void ChooseCells();
  void WriteContacts();

  bool a_is_source_;
  Side source_, target_;
  ContactCells cells_;
  std::vector<Memory> memory_;           // of each sample
  std::vector<std::uint32_t> searched_;  // step in which a sample found its partner
  std::vector<int> partnered_, last_partnered_;
  std::vector<int> triangles_;  // of the source, to be searched
  std::vector<std::uint32_t> triangle_stamps_;
  std::vector<Found> found_;
  std::vector<Cell> cell_;  // the cells, then the blocks where they are one contact
  std::vector<Block> block_;
  std::vector<int> touched_blocks_;
  std::vector<int> touched_cells_, kept_cells_;
  std::vector<PairSample> pool_;
  std::vector<PairContact> contacts_;
  std::size_t count_ = 0;
  std::uint32_t stamp_ = 0;
  std::uint32_t search_stamp_ = 0;
  double motion_gain_ = 1;
  double most_motion_ = kMostMotion;
  double margin_ = kMargin;
  bool deeper_ = false;  // a sample was found inside for the first time
  bool complete_ = true;
};

}  // namespace hpdm
