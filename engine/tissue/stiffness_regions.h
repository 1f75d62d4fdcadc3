#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/organ_options.h"
#include "engine/tissue/interior.h"

namespace hpdm {

/// Young's modulus (Pa) at a rest point (world, m): of the last region that holds it, or the
/// material's. `bounds`: the posed organ's axis-aligned box. No allocation.
double YoungAt(const OrganOptions& organ, const Box& bounds, const Vector3d& p_W);

/// The tissue of an organ whose points carry their own stiffness.
struct StiffnessTissue {
  TissueQuadrature tissue;    ///< Cells as asked for.
  Eigen::VectorXd stiffness;  ///< Q: Young's modulus over that of the organ's material.
};

/// SampleTissue (interior.h) in which each cell that a region's border crosses has points of its
/// own on either side of it: the cell is sampled in parts of at most a quarter of the region's
/// least side (an eighth to a sixteenth of the cell) and what lies on each side reduced to at most
/// 54 points with the same moments, so a step costs as much as with two or three whole cells. The
/// share of a region in a cell is right to about a fiftieth of the region's side. Without regions,
/// SampleTissue itself. Set-up only. Throws InputError (the organ's name, remedy) when a region
/// holds no tissue.
StiffnessTissue SampleStiffness(const SurfaceMesh& rest_W, const OrientedBox& box_W,
                                const std::array<int, 3>& cells, const OrganOptions& organ);

/// `weights` (Q, m^3) times the relative Young's modulus at `points` (Q x 3, world, m): the
/// integral over them of the organ's own elastic energy is that of the regions' too.
Eigen::VectorXd ElasticWeights(const OrganOptions& organ, const Box& bounds, const Points& points,
                               const Eigen::VectorXd& weights);

}  // namespace hpdm
