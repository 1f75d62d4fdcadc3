#include "lcmtypes/wire/mesh_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

/// An organ of random vertices and triangles with `kept` of the 6^3 control points of a lattice.
OrganDescription RandomOrgan(int vertices, int triangles, int kept) {
  std::mt19937 random(5);
  OrganDescription organ;
  organ.name = "liver";
  organ.vertices = Points::Random(vertices, 3) * 0.1;
  organ.triangles.resize(triangles, 3);
  for (Eigen::Index i = 0; i < organ.triangles.size(); ++i) {
    organ.triangles.data()[i] = static_cast<int>(random() % static_cast<unsigned>(vertices));
  }
  LatticeDescription& lattice = organ.lattice.emplace();
  lattice.origin_W = {-0.1, -0.2, -0.3};
  lattice.axes = Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  lattice.lengths = {0.2, 0.3, 0.4};
  for (int i = 0; i < kept; ++i) lattice.kept.push_back(i);
  return organ;
}

std::vector<mesh_t> OverTheWire(const std::vector<mesh_t>& parts) {
  std::vector<mesh_t> received(parts.size());
  std::vector<std::uint8_t> buffer;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto bytes = EncodeMessage(parts[i], &buffer);
    EXPECT_LE(bytes.size(), static_cast<std::size_t>(kMaxMeshPartBytes));
    EXPECT_TRUE(DecodeMessage(bytes, &received[i]));
  }
  return received;
}

TEST(MeshCodec, PartsInAnyOrderGiveTheOrganBack) {
  const OrganDescription sent = RandomOrgan(15'000, 30'000, 200);
  std::vector<mesh_t> parts = OverTheWire(SplitMesh(3, sent));
  EXPECT_GT(parts.size(), 10u);
  std::shuffle(parts.begin(), parts.end(), std::mt19937(6));
  OrganDescription received;
  std::string error;
  ASSERT_TRUE(JoinMesh(parts, &received, &error)) << error;
  EXPECT_EQ(parts[0].organ, 3);
  EXPECT_EQ(received.name, sent.name);
  EXPECT_EQ(received.triangles, sent.triangles);
  EXPECT_EQ(received.vertices, sent.vertices.cast<float>().cast<double>());
  ASSERT_TRUE(received.lattice.has_value());
  EXPECT_EQ(received.lattice->basis, sent.lattice->basis);
  EXPECT_EQ(received.lattice->degree, sent.lattice->degree);
  EXPECT_EQ(received.lattice->cells, sent.lattice->cells);
  EXPECT_EQ(received.lattice->origin_W, sent.lattice->origin_W);
  EXPECT_EQ(received.lattice->axes, sent.lattice->axes);
  EXPECT_EQ(received.lattice->lengths, sent.lattice->lengths);
  EXPECT_EQ(received.lattice->kept, sent.lattice->kept);
}

TEST(MeshCodec, AnOrganWithoutLatticeAndAnEmptyOneAreOnePartEach) {
  OrganDescription sent = RandomOrgan(100, 50, 0);
  sent.lattice.reset();
  for (int empty : {0, 1}) {
    if (empty)
      sent = OrganDescription{
          .name = "", .vertices = Points(0, 3), .triangles = Triangles(0, 3), .lattice = {}};
    const std::vector<mesh_t> parts = OverTheWire(SplitMesh(0, sent));
    ASSERT_EQ(parts.size(), 1u);
    OrganDescription received;
    std::string error;
    ASSERT_TRUE(JoinMesh(parts, &received, &error)) << error;
    EXPECT_FALSE(received.lattice.has_value());
    EXPECT_EQ(received.vertices.rows(), sent.vertices.rows());
    EXPECT_EQ(received.triangles, sent.triangles);
  }
}

TEST(MeshCodec, AnEndlessNameIsCutSoThatPartsKeepTheirSize) {
  OrganDescription sent = RandomOrgan(10'000, 10'000, 10);
  sent.name.assign(1'000'000, 'x');
  OrganDescription received;
  std::string error;
  ASSERT_TRUE(JoinMesh(OverTheWire(SplitMesh(0, sent)), &received, &error)) << error;
  EXPECT_EQ(received.name.size(), static_cast<std::size_t>(kMaxOrganNameBytes));
}

/// Joins a damaged copy of three parts and returns the error.
template <typename Damage>
std::string Refusal(Damage damage) {
  std::vector<mesh_t> parts = SplitMesh(0, RandomOrgan(200, 300, 100), 2500);
  EXPECT_GE(parts.size(), 3u);
  damage(&parts);
  OrganDescription received;
  std::string error;
  EXPECT_FALSE(JoinMesh(parts, &received, &error));
  return error;
}

using Parts = std::vector<mesh_t>*;

TEST(MeshCodec, MissingRepeatedAndForeignPartsAreRefused) {
  EXPECT_EQ(Refusal([](Parts p) { p->clear(); }), "no part");
  EXPECT_EQ(Refusal([](Parts p) { p->pop_back(); }), "parts missing or too many");
  EXPECT_EQ(Refusal([](Parts p) { p->push_back(p->front()); }), "parts missing or too many");
  EXPECT_EQ(Refusal([](Parts p) { (*p)[1] = (*p)[0]; }), "part repeated");
  EXPECT_EQ(Refusal([](Parts p) { (*p)[1].organ = 1; }), "parts of different wholes");
  EXPECT_EQ(Refusal([](Parts p) { (*p)[1].part = -1; }), "part number out of range");
  EXPECT_EQ(Refusal([](Parts p) { std::swap((*p)[0].part, (*p)[1].part); }),
            "parts do not follow each other");
}

TEST(MeshCodec, AbsurdNumbersAreRefusedWithoutReservingThem) {
  const int huge = std::numeric_limits<std::int32_t>::max();
  const auto all = [](Parts p, auto change) {
    for (mesh_t& part : *p) change(part);
  };
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.total_vertices = huge; }); }),
            "totals disagree with the parts");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.part_count = huge; }); }),
            "parts missing or too many");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.cells[1] = huge; }); }),
            "cells out of range");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.degree[2] = 0; }); }),
            "degree out of range");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.basis = 9; }); }), "unknown basis");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.lengths[0] = 0; }); }),
            "box without volume");
  EXPECT_EQ(Refusal([&](Parts p) { all(p, [&](mesh_t& m) { m.axes[0][0] = NAN; }); }),
            "box axes not perpendicular unit vectors");
  EXPECT_EQ(Refusal([](Parts p) {
              for (mesh_t& part : *p) {
                if (!part.triangles.empty()) part.triangles[0] = 200;
              }
            }),
            "triangle index out of range");
  EXPECT_EQ(Refusal([](Parts p) {
              for (mesh_t& part : *p) {
                if (!part.kept.empty()) part.kept[0] = 216;
              }
            }),
            "control point index out of range");
  EXPECT_EQ(Refusal([](Parts p) { (*p)[0].vertices[0] = NAN; }), "vertex not finite");
}

}  // namespace
}  // namespace hpdm
