// Fillings and layers of an organ.

#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

TEST_F(SceneTest, ALumenHasTheValuesOfItsKeys) {
  const Scene scene = Load(kOrgan +
                           "[[organ.lumen]]\n[[organ.lumen]]\nsphere={centre=[1,2,3],radius=0.25}\n"
                           "filled=false\nbulk_modulus=1e5\npressure=900\n"
                           "leak_resistance=3e7\nperforated_at=12\n");
  ASSERT_EQ(scene.organs[0].lumens.size(), 2);
  const LumenOptions &plain = scene.organs[0].lumens[0], &given = scene.organs[0].lumens[1];
  EXPECT_FALSE(plain.region);
  EXPECT_TRUE(plain.filled);
  EXPECT_EQ(plain.bulk_modulus, 2.2e9);
  EXPECT_EQ(plain.pressure, 0);
  EXPECT_EQ(plain.leak_resistance, 4e8);
  EXPECT_FALSE(plain.perforated_at);
  EXPECT_EQ(std::get<Sphere>(given.region.value()).centre, Vector3d(1, 2, 3));
  EXPECT_FALSE(given.filled);
  EXPECT_EQ(given.bulk_modulus, 1e5);
  EXPECT_EQ(given.pressure, 900);
  EXPECT_EQ(given.leak_resistance, 3e7);
  EXPECT_EQ(given.perforated_at, 12);
}

TEST_F(SceneTest, ViscoelasticTissueIsNotPerforated) {
  EXPECT_TRUE(Contains(ErrorOf([&] {
                         Load(kOrgan +
                              "material={prony=[{share=0.3,time=1}]}\n"
                              "[[organ.lumen]]\nperforated_at=1\n");
                       }),
                       "of viscoelastic tissue stay closed"));
}

TEST_F(SceneTest, ALayerHasTheValuesOfItsKeys) {
  const Scene scene =
      Load(kOrgan +
           "[[organ.layer]]\nstiffness=12\n[[organ.layer]]\nstiffness=13\npoisson=0.2\n"
           "strength=300\nbox_fraction={min=[0,0,0],max=[1,1,0.5]}\n");
  ASSERT_EQ(scene.organs[0].layers.size(), 2);
  const LayerOptions &plain = scene.organs[0].layers[0], &given = scene.organs[0].layers[1];
  EXPECT_FALSE(plain.region);
  EXPECT_EQ(plain.stiffness, 12);
  EXPECT_EQ(plain.poisson, 0.45);
  EXPECT_FALSE(plain.strength);
  EXPECT_EQ(std::get<BoxFraction>(given.region.value()).max.z(), 0.5);
  EXPECT_EQ(given.stiffness, 13);
  EXPECT_EQ(given.poisson, 0.2);
  EXPECT_EQ(given.strength, 300);
}

TEST_F(SceneTest, FillingsAndLayersNeedAConstantStiffness) {
  for (const std::string table : {"[[organ.lumen]]\n", "[[organ.layer]]\nstiffness=1\n"}) {
    for (const std::string other :
         {"energy={strain='finite'}\n", "energy={strain='adaptive'}\n", "energy={type='metric'}\n",
          "energy={solver='gauss_seidel'}\n", "lattice={adaptive_functions=300}\n"}) {
      EXPECT_TRUE(
          Contains(ErrorOf([&] { Load(kOrgan + other + table); }), "does not apply to this organ"))
          << table << other;
    }
    EXPECT_TRUE(Contains(ErrorOf([&] { Load(kOrgan + "model='mass_spring'\n" + table); }),
                         "needs model = \"hpdm\""))
        << table;
    EXPECT_TRUE(
        Contains(ErrorOf([&] {
                   Load(kOrgan + table +
                        "[[cut]]\norgan='liver'\nstrip=[[[0,0,0],[0,0,1]],[[1,0,0],[1,0,1]]]\n");
                 }),
                 "has a lumen or a layer"))
        << table;
  }
}

}  // namespace
}  // namespace hpdm
