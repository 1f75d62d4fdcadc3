#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "engine/contact/surface_kernel.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"
#include "engine/tissue/layer_tensions.h"
#include "engine/tissue/lumen.h"

namespace hpdm {

/// Fillings and layers on an organ's surface add an energy to its lattice: sums of squares of rows that
/// are linear in the displacements, so K += rows^T rows.
///
/// 1. A filled lumen of volume V whose fluid has the bulk modulus k: k / (2 V) (sum areas . u)^2,
///    one row. With water it keeps its volume to V p / k, 1e-6 at 2 kPa.
/// 2. A layer: the energy of a membrane in plane stress,
///        S / (2 (1 - nu^2)) int (e_11 + e_22)^2 - 2 (1 - nu) (e_11 e_22 - e_12^2) dA,
///    S = Young's modulus times thickness, with the strain e of the lattice's field in the tangent
///    plane of the surface. Three rows a sample; it takes no bending.
///
/// The rows are those of any lattice over the organ. Constant once built; set-up and any thread.
class FillingsAndLayers {
 public:
  /// No filling and no layer.
  FillingsAndLayers() = default;
  /// `rest` and `rest_normals` (V x 3) must outlive it. `longest_side`: m, of a layer's samples.
  /// Throws InputError (organ's name, fault, remedy).
  FillingsAndLayers(const OrganOptions& organ, const SurfaceMesh& rest, const Points& rest_normals,
                    double longest_side);

  const std::vector<Lumen>& lumens() const { return lumens_; }
  /// Not without lumens or layers.
  const Points& rest_vertices() const { return rest_->vertices; }
  /// Returns the area of each layer of the options, m^2.
  const std::vector<double>& layer_areas() const { return layer_areas_; }
  const LayerTensions& tensions() const { return tensions_; }

  /// One row a filled lumen: L x 3n, N^(1/2) m^(-1/2).
  Eigen::MatrixXd FillingRows(const Lattice& lattice) const;
  /// Three rows a sample of a layer: 3S x 3n, N^(1/2) m^(-1/2).
  WeightMatrix LayerRows(const Lattice& lattice) const;
  /// Adds rows^T rows of all of them to K (3n x 3n, N/m).
  void AddTo(const Lattice& lattice, Eigen::MatrixXd* K) const;

 private:
  struct Sample {
    int layer = 0;
    double area = 0;                    // m^2
    Vector3d p_W, normal_W;             // m; outwards, of its side of a gap
    Eigen::Matrix<double, 3, 2> plane;  // unit vectors in the tangent plane
  };
  Lattice::Site SiteOf(const Lattice& lattice, const Sample& sample) const;

  void AddSamples(int layer, const SurfaceMesh& outer, const std::vector<SurfaceSample>& samples);

  const SurfaceMesh* rest_ = nullptr;
  const Points* rest_normals_ = nullptr;
  std::vector<Lumen> lumens_;
  std::vector<LayerOptions> layers_;
  std::vector<double> layer_areas_;
  LayerTensions tensions_;
  std::vector<Sample> samples_;
};

}  // namespace hpdm
