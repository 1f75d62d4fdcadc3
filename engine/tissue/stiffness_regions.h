#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/organ_options.h"
#include "engine/tissue/interior.h"

namespace hpdm {

/// Returns Young's modulus (Pa) at a rest point (world, m). It is that of the last region that
/// contains the point, else that of the material. `bounds`: the posed organ's axis-aligned box. No
/// allocation.
double YoungAt(const OrganOptions& organ, const Box& bounds, const Vector3d& p_W);

/// The tissue of an organ whose points carry their own stiffness.
struct StiffnessTissue {
  TissueQuadrature tissue;    ///< Over the requested cells.
  Eigen::VectorXd stiffness;  ///< Q: Young's modulus over that of the organ's material.
};

/// Samples the tissue like SampleTissue (interior.h), with separate points on the two sides of a
/// region's border.
///
/// 1. A cell near a region is sampled in parts of at most a quarter of the region's least side. The
///    parts are between an eighth and a sixteenth of the cell.
/// 2. The points on each side of the border are reduced to at most 54 with the same moments. So in
///    a step the cell costs as much as two or three whole cells.
/// 3. The share of a region in a cell is accurate to about a fiftieth of the region's side.
/// 4. Without regions the result is that of SampleTissue.
/// 5. `cuts` (or nullptr): points do not stand for both sides, except within a part of a cell near
///    a region.
///
/// Set-up only. Throws InputError (the organ's name, remedy) if a region contains no tissue.
StiffnessTissue SampleStiffness(const SurfaceMesh& rest_W, const OrientedBox& box_W,
                                const std::array<int, 3>& cells, const OrganOptions& organ,
                                CutSurfaces cuts = nullptr);

/// Returns `weights` (Q, m^3) times the relative Young's modulus at `points` (Q x 3, world, m).
/// With these weights the elastic energy of the organ's material includes its regions.
Eigen::VectorXd ElasticWeights(const OrganOptions& organ, const Box& bounds, const Points& points,
                               const Eigen::VectorXd& weights);

}  // namespace hpdm
