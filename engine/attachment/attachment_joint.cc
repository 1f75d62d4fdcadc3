#include "engine/attachment/attachment_joint.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "engine/mesh/mesh_edges.h"

namespace hpdm {
namespace {

// A lasting load moves a free organ by this many times its motion in a step: enough for the layers to
// bear all of it but a millionth.
constexpr double kLasting = 1e4;

double YieldOf(const OrganOptions& options) {
  return FreeFlight(options.time_step, options.free->drag, Vector3d::Zero()).Yield();
}

// Columns of both organs that the bed touches, as one list: those of a, then those of b.
struct Touched {
  std::vector<std::pair<int, int>> columns;  // side, column
  Eigen::MatrixXd rows;                      // M x columns: delta's dependence on them
};

Touched TouchedBy(const AttachmentBed& bed) {
  Touched touched;
  std::array<std::vector<int>, 2> place;
  for (int side = 0; side < 2; ++side) {
    const WeightMatrix& rows = bed.rows[static_cast<std::size_t>(side)];
    std::vector<bool> used(static_cast<std::size_t>(rows.cols()), false);
    for (int i = 0; i < rows.outerSize(); ++i) {
      for (WeightMatrix::InnerIterator it(rows, i); it; ++it) used[ToSize(it.col())] = true;
    }
    auto& places = place[static_cast<std::size_t>(side)];
    places.assign(used.size(), -1);
    for (std::size_t c = 0; c < used.size(); ++c) {
      if (!used[c]) continue;
      places[c] = static_cast<int>(touched.columns.size());
      touched.columns.emplace_back(side, static_cast<int>(c));
    }
  }
  touched.rows =
      Eigen::MatrixXd::Zero(bed.size(), static_cast<Eigen::Index>(touched.columns.size()));
  for (std::size_t side = 0; side < 2; ++side) {
    const double sign = side == 0 ? -1 : 1;
    for (int i = 0; i < bed.rows[side].outerSize(); ++i) {
      for (WeightMatrix::InnerIterator it(bed.rows[side], i); it; ++it) {
        touched.rows(i, place[side][ToSize(it.col())]) = sign * it.value();
      }
    }
  }
  return touched;
}

// Returns the organs' compliance between the touched columns, m/N, as the mean of the three axes.
Eigen::MatrixXd MeanCompliance(const Touched& touched,
                               const std::array<AttachmentJoint::Organ, 2>& organs) {
  const auto size = static_cast<Eigen::Index>(touched.columns.size());
  Eigen::MatrixXd compliance = Eigen::MatrixXd::Zero(size, size);
  for (int side = 0; side < 2; ++side) {
    const AttachmentJoint::Organ& organ = organs[ToSize(side)];
    if (organ.compliance == nullptr) continue;
    for (Eigen::Index c = 0; c < size; ++c) {
      if (touched.columns[ToSize(c)].first != side) continue;
      Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * organ.rows, 3);
      for (int d = 0; d < 3; ++d) loads(3 * touched.columns[ToSize(c)].second + d, d) = 1;
      organ.compliance->SolveLoads(loads);
      for (Eigen::Index r = 0; r < size; ++r) {
        if (touched.columns[ToSize(r)].first != side) continue;
        compliance(r, c) = loads.middleRows<3>(3 * touched.columns[ToSize(r)].second).trace() / 3;
      }
    }
  }
  return (compliance + compliance.transpose()) / 2;
}

}  // namespace

AttachmentJoint::AttachmentJoint(std::vector<AttachmentBed> beds,
                                 const std::vector<std::array<Organ, 2>>& organs,
                                 std::vector<std::shared_ptr<const DuctModel>> ducts) {
  HPDM_CHECK(beds.size() + ducts.size() == organs.size());
  for (std::size_t l = 0; l < beds.size(); ++l) AddLayer(std::move(beds[l]), organs[l]);
  for (std::size_t d = 0; d < ducts.size(); ++d) {
    AddDuct(std::move(ducts[d]), organs[beds.size() + d]);
  }
  Respond();
  organs_.clear();
  shapes_.clear();
}

int AttachmentJoint::MemberOf(int organ) const {
  for (std::size_t m = 0; m < members_.size(); ++m) {
    if (members_[m].organ == organ) return static_cast<int>(m);
  }
  return -1;
}

int AttachmentJoint::AddMember(const Organ& organ) {
  const int found = MemberOf(organ.index);
  if (found >= 0) return found;
  members_.emplace_back().organ = organ.index;
  organs_.push_back(organ);
  shapes_.emplace_back(0, organ.compliance != nullptr ? organ.control_points : 0);
  return static_cast<int>(members_.size()) - 1;
}

void AttachmentJoint::AddLayer(AttachmentBed bed, const std::array<Organ, 2>& organs) {
  const std::array<int, 2> members{AddMember(organs[0]), AddMember(organs[1])};
  const Touched touched = TouchedBy(bed);
  // Weighted by the root of their stiffness, the samples' displacements have the layer's energy.
  const Eigen::VectorXd root = (bed.areas * bed.law.stiffness).cwiseSqrt();
  const Eigen::MatrixXd rows = root.asDiagonal() * touched.rows;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      rows * MeanCompliance(touched, organs) * rows.transpose());
  const Eigen::VectorXd& ratios = solver.eigenvalues();  // ascending
  // Below organs that are much stiffer than it the layer still has all of its shapes.
  const double least = kLeastRatio * std::min(1.0, ratios[ratios.size() - 1]);
  Eigen::Index dropped = 0;
  while (dropped + 1 < ratios.size() && !(ratios[dropped] > least)) ++dropped;
  const Eigen::MatrixXd kept = solver.eigenvectors().rightCols(ratios.size() - dropped);
  const Eigen::Index first = modes_, count = kept.cols();
  AddModes(count);
  const Eigen::MatrixXd shape = kept.transpose() * rows;
  for (std::size_t c = 0; c < touched.columns.size(); ++c) {
    const auto [side, column] = touched.columns[c];
    const auto m = static_cast<std::size_t>(members[static_cast<std::size_t>(side)]);
    const auto moved = shape.col(static_cast<Eigen::Index>(c));
    shapes_[m].block(first, column, count, 1) = moved;
    members_[m].offset.segment(first, count) += moved;  // the functions sum to one
  }
  // A rigid organ has no functions: to move it by v is to move the other one by -v.
  for (std::size_t side = 0; side < 2; ++side) {
    if (organs[side].compliance != nullptr) continue;
    const auto own = static_cast<std::size_t>(members[side]);
    const auto other = static_cast<std::size_t>(members[1 - side]);
    members_[own].offset.segment(first, count) = -members_[other].offset.segment(first, count);
  }
  Layer& layer = layers_.emplace_back(Layer{std::move(bed), members, first, {}});
  layer.samples = kept.transpose() * root.cwiseInverse().asDiagonal();
}

// Adds modes that no member moves yet.
void AttachmentJoint::AddModes(Eigen::Index count) {
  modes_ += count;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    Eigen::MatrixXd& shape = shapes_[m];
    Eigen::VectorXd& offset = members_[m].offset;
    const Eigen::Index had = shape.rows();
    shape.conservativeResize(modes_, Eigen::NoChange);
    shape.bottomRows(modes_ - had).setZero();
    offset.conservativeResize(modes_);
    offset.tail(modes_ - had).setZero();
  }
}

void AttachmentJoint::AddDuct(std::shared_ptr<const DuctModel> model,
                              const std::array<Organ, 2>& organs) {
  Duct& duct = ducts_.emplace_back(Duct{std::move(model), {-1, -1}, modes_});
  for (std::size_t end = 0; end < 2; ++end) {
    if (organs[end].index >= 0) duct.members[end] = AddMember(organs[end]);
  }
  AddModes(0);
  for (std::size_t end = 0; end < 2; ++end) {
    if (!duct.model->IsHeldByLattice(end)) continue;
    const Eigen::Index first = modes_;
    AddModes(DuctModel::Hold::kRows);
    const auto m = ToSize(duct.members[end]);
    for (int r = 0; r < DuctModel::Hold::kRows; ++r) {
      for (const auto& [column, value] : duct.model->holds[end].rows[ToSize(r)]) {
        shapes_[m](first + r, column) = value;
      }
    }
    members_[m].offset[first] = 1;
  }
}

// Computes the members' responses and G.
void AttachmentJoint::Respond() {
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(3 * modes_, 3 * modes_);
  for (std::size_t m = 0; m < members_.size(); ++m) {
    const Eigen::MatrixXd& shape = shapes_[m];
    const Organ& organ = organs_[m];
    if (organ.compliance == nullptr) continue;
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * organ.rows, 3 * modes_);
    for (Eigen::Index j = 0; j < modes_; ++j) {
      for (Eigen::Index a = 0; a < shape.cols(); ++a) {
        for (int d = 0; d < 3; ++d) loads(3 * a + d, 3 * j + d) = shape(j, a);
      }
    }
    organ.compliance->SolveLoads(loads);
    RowMajorMatrix& response = members_[m].response;
    response = loads.topRows(3 * organ.control_points);
    if (organ.weight_W != nullptr && organ.weight_W->size() > 0) {
      if (sag_.size() == 0) sag_.setZero(3 * modes_);
      sag_ += response.transpose() *
              Eigen::Map<const Eigen::VectorXd>(organ.weight_W->data(), organ.weight_W->size());
    }
    for (Eigen::Index a = 0; a < shape.cols(); ++a) {
      for (Eigen::Index j = 0; j < modes_; ++j) {
        if (shape(j, a) != 0) G.middleRows<3>(3 * j) += shape(j, a) * response.middleRows<3>(3 * a);
      }
    }
  }
  if (modes_ == 0) return;
  Eigen::MatrixXd lasting;
  for (std::size_t m = 0; m < members_.size(); ++m) {
    members_[m].free = organs_[m].body != nullptr;
    if (members_[m].free || organs_[m].leaks) members_[m].shape = shapes_[m];
    if (!members_[m].free) continue;
    if (organs_[m].weight_W == nullptr || organs_[m].weight_W->size() == 0) continue;
    if (lasting.size() == 0) lasting = G;
    AddFreeMotion(m, &lasting);
  }
  lasting_ = std::move(lasting);
  compliance_ = RowMajorMatrix::Zero(G.rows(), FullGroups(G.cols()));
  compliance_.leftCols(G.cols()) = (G + G.transpose()) / 2;
}

// Adds the whole-body motion of a free organ under lasting loads to G and to the sag.
void AttachmentJoint::AddFreeMotion(std::size_t member, Eigen::MatrixXd* G) {
  const FreeBody& body = *organs_[member].body;
  const Eigen::MatrixXd& shape = shapes_[member];
  // Modes by a unit translation and a unit rotation.
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(3 * modes_, 6);
  for (Eigen::Index j = 0; j < modes_; ++j) {
    for (Eigen::Index a = 0; a < body.arms.rows(); ++a) {
      if (shape(j, a) == 0) continue;
      const Vector3d arm = body.arms.row(a);
      for (int d = 0; d < 3; ++d) {
        moved(3 * j + d, d) += shape(j, a);
        moved.block<3, 1>(3 * j, 3 + d) += shape(j, a) * Vector3d::Unit(d).cross(arm);
      }
    }
  }
  Eigen::Matrix<double, 6, 6> yields = Eigen::Matrix<double, 6, 6>::Zero();
  yields.topLeftCorner<3, 3>() = Matrix3d::Identity() / body.mass;
  yields.bottomRightCorner<3, 3>() = body.inertia.inverse();
  *G += kLasting * organs_[member].yield * moved * yields * moved.transpose();
  const Eigen::RowVector3d weight_W = organs_[member].weight_W->colwise().sum();
  sag_ += kLasting * organs_[member].yield * moved.leftCols<3>() * weight_W.transpose() / body.mass;
}

AttachmentJoint::Organ JoinedOrgan(int index, const OrganModel& organ, const Relaxation& relaxation,
                                   Eigen::Index rows) {
  if (organ.rigid()) return {.index = index, .rows = rows};
  const bool has_place = !organ.options().supports.empty() || organ.free_body() != nullptr;
  return {.index = index,
          .control_points = organ.control_points(),
          .rows = rows,
          .compliance = relaxation.compliance(),
          .weight_W = has_place ? &organ.lattice_organ()->weight_W() : nullptr,
          .body = organ.free_body(),
          .yield = organ.free_body() != nullptr ? YieldOf(organ.options()) : 0,
          .leaks = !organ.lattice_organ()->fillings_and_layers().lumens().empty()};
}

std::vector<std::shared_ptr<const AttachmentJoint>> JoinOrgans(
    std::vector<AttachmentBed> beds,
    const std::vector<std::array<AttachmentJoint::Organ, 2>>& organs,
    std::vector<std::shared_ptr<const DuctModel>> ducts) {
  DisjointSets groups(static_cast<int>(organs.size()));
  for (std::size_t l = 0; l < organs.size(); ++l) {
    for (std::size_t k = 0; k < l; ++k) {
      const auto shares = [&](const AttachmentJoint::Organ& organ) {
        return organ.index >= 0 &&
               (organ.index == organs[k][0].index || organ.index == organs[k][1].index);
      };
      if (!shares(organs[l][0]) && !shares(organs[l][1])) continue;
      groups.Merge(static_cast<int>(k), static_cast<int>(l));
    }
  }
  const auto in_group = [&groups](std::size_t l, std::size_t g) {
    return groups.Find(static_cast<int>(l)) == static_cast<int>(g);
  };
  std::vector<std::shared_ptr<const AttachmentJoint>> joints;
  for (std::size_t g = 0; g < organs.size(); ++g) {
    std::vector<AttachmentBed> own;
    std::vector<std::shared_ptr<const DuctModel>> own_ducts;
    std::vector<std::array<AttachmentJoint::Organ, 2>> pairs;
    for (std::size_t l = 0; l < beds.size(); ++l) {
      if (!in_group(l, g)) continue;
      own.push_back(std::move(beds[l]));
      pairs.push_back(organs[l]);
    }
    for (std::size_t d = 0; d < ducts.size(); ++d) {
      if (!in_group(beds.size() + d, g)) continue;
      own_ducts.push_back(std::move(ducts[d]));
      pairs.push_back(organs[beds.size() + d]);
    }
    if (pairs.empty()) continue;
    joints.push_back(
        std::make_shared<AttachmentJoint>(std::move(own), pairs, std::move(own_ducts)));
  }
  return joints;
}

}  // namespace hpdm
