#include "tools/yardstick/cgal_mesher.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_3.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/make_mesh_3.h>

#include <map>

#include "engine/base/error.h"

namespace hpdm {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Surface_mesh<Kernel::Point_3>;
using Domain = CGAL::Polyhedral_mesh_domain_3<Polyhedron, Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

struct SizeField {
  using FT = Kernel::FT;
  using Index = Domain::Index;
  const std::function<double(const Vector3d&)>* size;
  double unit;

  FT operator()(const Kernel::Point_3& p, int, const Index&) const {
    return (*size)(Vector3d(p.x(), p.y(), p.z()) * unit) / unit;
  }
};

}  // namespace

TetraMesh FillWithTetrahedra(const SurfaceMesh& surface,
                             const std::function<double(const Vector3d&)>& size, double distance) {
  constexpr double kUnit = 1e-3;  // CGAL works in mm: some of its bounds are absolute
  Polyhedron polyhedron;
  std::vector<Polyhedron::Vertex_index> vertices;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v) {
    const Vector3d p = surface.vertices.row(v).transpose() / kUnit;
    vertices.push_back(polyhedron.add_vertex({p.x(), p.y(), p.z()}));
  }
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto corner = [&](int k) {
      return vertices[static_cast<std::size_t>(surface.triangles(t, k))];
    };
    if (polyhedron.add_face(corner(0), corner(1), corner(2)) == Polyhedron::null_face()) {
      throw InputError("yardstick: the surface is not a manifold; mend the mesh");
    }
  }
  CGAL::get_default_random() = CGAL::Random(1);
  const Domain domain(polyhedron, &CGAL::get_default_random());
  const SizeField field{&size, kUnit};
  namespace parameters = CGAL::parameters;
  const Criteria criteria(parameters::facet_angle = 25, parameters::facet_size = field,
                          parameters::facet_distance = distance / kUnit,
                          parameters::cell_radius_edge_ratio = 2, parameters::cell_size = field);
  const Complex complex =
      CGAL::make_mesh_3<Complex>(domain, criteria, parameters::perturb(), parameters::exude());

  std::map<Triangulation::Vertex_handle, int> numbers;
  std::vector<Vector3d> nodes;
  Tetrahedra elements(static_cast<Eigen::Index>(complex.number_of_cells_in_complex()), 4);
  Eigen::Index next = 0;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end();
       ++cell, ++next) {
    for (int k = 0; k < 4; ++k) {
      const auto [at, is_new] =
          numbers.try_emplace(cell->vertex(k), static_cast<int>(nodes.size()));
      if (is_new) {
        const auto& p = cell->vertex(k)->point();
        nodes.emplace_back(CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z()));
      }
      elements(next, k) = at->second;
    }
  }
  Points positions(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    positions.row(static_cast<Eigen::Index>(n)) = kUnit * nodes[n].transpose();
  }
  return MakeTetraMesh(positions, elements, "yardstick");
}

}  // namespace hpdm
