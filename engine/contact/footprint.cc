#include "engine/contact/footprint.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hpdm {
namespace {

// Longest side of a part in which the lattice's row is sampled, of the resolved radius.
constexpr double kResolution = 0.25;

// A corner whose weights sum to less has no points: those of one point at all corners sum to four.
constexpr double kNoWeight = 1e-6;

// A point load at these depths, in the side of a square and in the radius of the kernel, sinks like
// a uniform square (UniformPairSinking) and like two kernels (KernelPairSinking) at d = 0.
constexpr double kUniformDepth = 0.336, kKernelDepth = 0.473;

// The images of a force in a layer count up to this distance, in resolved radii.
constexpr double kImageReach = 8;
constexpr int kMaxImages = 64;

// Returns the response at the distance `along` of a point load at `depth`.
PairSinking PointAtDepth(double along, double depth) {
  const double r = std::hypot(along, depth);
  const double radial = along > 1e-6 * depth ? (r - depth) / (along * along) : 1 / (2 * depth);
  return {1 / (std::numbers::pi * r), radial / std::numbers::pi, 0};
}

// Returns what the lattice leaves of the response to a force at `depth`, in m.
PairSinking AtDepth(double along, double depth, double radius) {
  const PairSinking point = PointAtDepth(along, depth);
  const PairSinking resolved = PointAtDepth(along, depth + kKernelDepth * radius);
  return {point.mean - resolved.mean, point.radial - resolved.radial, 0};
}

double Kernel(double d, double radius) {
  return d < radius ? std::cos(std::numbers::pi * d / (2 * radius)) : 0;
}

}  // namespace

void Footprint::Resolve(const OrganModel& model, double thickness, NeighbourhoodSearch* search) {
  const SurfaceMesh& rest = model.rest();
  normal_W_.setZero();
  double largest = 0;
  for (int i = 0; i < count_; ++i) {
    p_rest_W_[i] = points_[i].at.Position(rest.vertices, rest.triangles);
    normal_W_ += points_[i].at.Position(model.rest_normals(), rest.triangles);
    largest = std::max(largest, points_[i].sides.maxCoeff());
  }
  normal_W_ = normal_W_.stableNormalized();
  const SurfacePoint& middle = points_[count_ / 2].at;
  thickness_ = thickness;
  has_local_ = model.FinestRadius() > largest;
  resolved_radius_ = largest;
  if (has_local_) {
    resolved_radius_ = thickness > 0 ? model.FinestRadius() : model.ResolvedRadius(middle, largest);
  }
  material_ = model.MaterialAt(middle);
  SetWeights();
  Sample(model, search);
}

// Scales the places to -1..1 and sets the weights (1 +- x)(1 +- y), normalised to one, of each corner near
// which there are points.
void Footprint::SetWeights() {
  Eigen::Vector2d low = points_[0].place, high = low, cell = Eigen::Vector2d::Zero();
  for (int i = 0; i < count_; ++i) {
    low = low.cwiseMin(points_[i].place);
    high = high.cwiseMax(points_[i].place);
    cell = cell.cwiseMax(points_[i].sides);
  }
  std::array<int, 2> signs;
  for (int axis = 0; axis < 2; ++axis) signs[axis] = has_local_ && high[axis] > low[axis] ? 2 : 1;
  rows_ = 0;
  for (int corner = 0; corner < signs[0] * signs[1]; ++corner) {
    const Eigen::Vector2d sign((corner % signs[0]) * 2 - 1, (corner / signs[0]) * 2 - 1);
    auto& weights = weights_[rows_];
    double sum = 0;
    for (int i = 0; i < count_; ++i) {
      double weight = 1;
      for (int axis = 0; axis < 2; ++axis) {
        if (signs[axis] == 1) continue;
        const double along =
            (2 * points_[i].place[axis] - low[axis] - high[axis]) / (high[axis] - low[axis]);
        weight *= 1 + sign[axis] * along;
      }
      weights[i] = weight;
      sum += weight;
    }
    if (sum < kNoWeight) continue;  // all points lie on the two sides that do not meet there
    for (int i = 0; i < count_; ++i) weights[i] /= sum;
    ++rows_;
  }
}

// Spreads each point's share over the surface by the kernel that the lattice resolves.
void Footprint::Sample(const OrganModel& model, NeighbourhoodSearch* search) {
  const SurfaceMesh& rest = model.rest();
  Vector3d centre = Vector3d::Zero();
  for (int i = 0; i < count_; ++i) centre += p_rest_W_[i] / count_;
  double reach = 0;
  int nearest = 0;
  for (int i = 0; i < count_; ++i) {
    reach = std::max(reach, (p_rest_W_[i] - centre).norm());
    if ((p_rest_W_[i] - centre).norm() < (p_rest_W_[nearest] - centre).norm()) nearest = i;
  }
  const double distance = (p_rest_W_[nearest] - centre).norm();
  reach += resolved_radius_ + distance;
  const SurfacePoint& at = points_[nearest].at;
  search->Collect(rest.vertices, at, {.reach = reach}, &around_);
  GatherSurface(rest, around_, at, normal_W_, reach, kResolution * resolved_radius_, &samples_);
  Places p_samples_W(Places::kUntouched);  // m, at rest
  for (int s = 0; s < samples_.sample_count; ++s) {
    samples_.weights[s].fill(0);
    p_samples_W[s] = AtSample(samples_.samples[s], rest.triangles, rest.vertices);
  }
  for (int i = 0; i < count_; ++i) Spread(i, &p_samples_W);
}

// Adds a point's share to the samples, by the resolved kernel about it.
void Footprint::Spread(int i, Places* p_samples_W) {
  const auto density = [&](int s) {
    return Kernel(((*p_samples_W)[s] - p_rest_W_[i]).norm(), resolved_radius_) *
           samples_.samples[s].weight;
  };
  const int count = samples_.sample_count;
  double sum = 0;
  for (int s = 0; s < count; ++s) sum += density(s);
  if (sum > 0) {
    for (int s = 0; s < count; ++s) {
      const double share = density(s) / sum;
      if (share == 0) continue;
      for (int row = 0; row < rows_; ++row) samples_.weights[s][row] += weights_[row][i] * share;
    }
  } else if (count < KernelSamples::kMaxSamples) {  // no surface faces that way: the point alone
    samples_.samples[samples_.sample_count++] = {points_[i].at.triangle, points_[i].at.barycentric,
                                                 0};
    for (int row = 0; row < rows_; ++row) samples_.weights[count][row] = weights_[row][i];
    (*p_samples_W)[count] = p_rest_W_[i];
  }
}

Vector3d Footprint::Mean(int row, const Points& vertices, const Triangles& triangles) const {
  Vector3d mean = Vector3d::Zero();
  for (int i = 0; i < count_; ++i) {
    mean += weights_[row][i] * points_[i].at.Position(vertices, triangles);
  }
  return mean;
}

void Footprint::AddToRow(int row, const OrganModel& model, const ActiveRefinement& active,
                         Eigen::Ref<Eigen::RowVectorXd> weights) const {
  for (int s = 0; s < samples_.sample_count; ++s) {
    const double weight = samples_.weights[s][row];
    if (weight == 0) continue;
    const SurfaceSample& sample = samples_.samples[s];
    model.AddToRow({sample.triangle, sample.barycentric}, weight, active, weights);
  }
}

// G - G_res between two points. In a layer the tangential part also has the images of the force on
// the free sides.
Matrix3d Footprint::Unresolved(int i, const Footprint& other, int j) const {
  const bool same_side = normal_W_.dot(other.normal_W_) > 0;
  const Vector3d normal_W = (normal_W_ + (same_side ? 1 : -1) * other.normal_W_).stableNormalized();
  const Matrix3d tangential = Matrix3d::Identity() - normal_W * normal_W.transpose();
  const Vector3d offset_W = p_rest_W_[i] - other.p_rest_W_[j];
  const Eigen::Vector2d &sides = points_[i].sides, &other_sides = other.points_[j].sides;
  const double radius = (resolved_radius_ + other.resolved_radius_) / 2;
  const double along = (tangential * offset_W).norm();
  PairSinking sinking;
  if (same_side) {
    const double d = offset_W.norm();
    sinking = UniformPairSinking(this == &other && i == j ? 0 : d, sides, other_sides);
    const PairSinking resolved = KernelPairSinking(d, radius);
    sinking.mean -= resolved.mean;
    sinking.radial -= resolved.radial;
    sinking.inward -= resolved.inward;
  } else {
    const double size = std::sqrt(std::max(sides.prod(), other_sides.prod()));
    sinking = AtDepth(along, std::abs(normal_W.dot(offset_W)) + kUniformDepth * size, radius);
  }
  Matrix3d C = SurfaceGreen(material_, normal_W, offset_W, sinking);
  if (thickness_ > 0) {
    const PairSinking images = Images(along, same_side ? 2 : 1, radius);
    C += tangential * SurfaceGreen(material_, normal_W, offset_W, images) * tangential;
  }
  return C;
}

// Sums the images at the depths first, first + 2, ... times the thickness on both sides.
PairSinking Footprint::Images(double along, int first, double radius) const {
  const double nu = material_.poisson;
  PairSinking sum;
  for (int k = first; k * thickness_ < kImageReach * radius && k < kMaxImages; k += 2) {
    const PairSinking image = AtDepth(along, k * thickness_, radius);
    const double count = k == 1 ? 1 : 2;  // one of the two at one thickness is the force itself
    sum.mean += count * image.mean;
    sum.radial += count * image.radial;
  }
  // Makes the sum's limit that of a plate in plane stress.
  const double plate = (3 - nu) / (4 - 2 * nu);
  sum.mean *= plate;
  sum.radial *= plate;
  return sum;
}

void Footprint::AddLocalCompliance(const Footprint& other, int at, int other_at,
                                   LocalCoupling* coupling) const {
  if (!has_local_) return;
  for (int i = 0; i < count_; ++i) {
    for (int j = 0; j < other.count_; ++j) {
      const Matrix3d C = Unresolved(i, other, j);
      for (int k = 0; k < rows_; ++k) {
        for (int l = 0; l < other.rows_; ++l) {
          coupling->block<3, 3>(3 * (at + k), 3 * (other_at + l)) +=
              weights_[k][i] * other.weights_[l][j] * C;
        }
      }
    }
  }
}

void FillLocalCoupling(std::span<const Footprint> footprints, LocalCoupling* coupling) {
  int rows = 0;
  for (const Footprint& footprint : footprints) rows += footprint.rows();
  coupling->setZero(3 * rows, 3 * rows);
  int at = 0;
  for (const Footprint& footprint : footprints) {
    int other_at = 0;
    for (const Footprint& other : footprints) {
      if (other_at > at) break;
      footprint.AddLocalCompliance(other, at, other_at, coupling);
      other_at += other.rows();
    }
    at += footprint.rows();
  }
  // Only the blocks below the diagonal are filled in; rounding makes those on it not symmetric.
  for (int row = 0; row < 3 * rows; ++row) {
    for (int column = 0; column < row; ++column) {
      (*coupling)(column, row) = (*coupling)(row, column);
    }
  }
}

}  // namespace hpdm
