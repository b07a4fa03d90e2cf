// What networks of materials and lights leave in the scene description.
#include <string>
#include <variant>
#include <vector>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

TEST(Shading, NetworksAreSnapshotsInOrder) {
  const Read r = readWorld(R"(Pattern "PxrManifold2D" "uv" "float scaleS" [2]
Pattern "PxrTexture" "tex" "string filename" ["a.tex"] "reference struct manifold" ["uv:result"]
Pattern "PxrTexture" "unused" "string filename" ["b.tex"]
Pattern "PxrMix" "mix" "reference color color1" ["tex:resultRGB"] "color color2" [1 0 0] "reference float mix" ["tex:resultA"]
AttributeBegin
Bxdf "PxrSurface" "s" "reference color diffuseColor" ["mix:resultRGB"] "float diffuseGain" [0.5]
Displace "PxrDisplace" "d" "reference float dispScalar" ["tex:resultR"]
Sphere 1 -1 1 360
Pattern "PxrMix" "mix" "color color1" [0 0 1]
Sphere 1 -1 1 360
AttributeEnd
Bxdf "PxrSurface" "t" "reference color diffuseColor" ["mix:resultRGB"]
Sphere 1 -1 1 360)");
  expectClean(r);
  const Network& n = *r.primitive(0).attributes->bxdf;
  EXPECT_EQ(n.terminal->plugin, "PxrSurface");
  ASSERT_EQ(n.patterns.size(), 3u);
  EXPECT_EQ(n.patterns[0]->handle, "uv");
  EXPECT_EQ(n.patterns[1]->handle, "tex");
  EXPECT_EQ(n.patterns[2]->handle, "mix");
  const Parameter* input = n.terminal->params.find("diffuseColor");
  EXPECT_TRUE(input->isReference);
  EXPECT_EQ(input->type, ValueType::Color);
  EXPECT_EQ(input->strings[0], "mix:resultRGB");
  EXPECT_EQ(r.primitive(0).attributes->displacement->patterns.size(), 2u);
  EXPECT_EQ(r.primitive(1).attributes->bxdf, r.primitive(0).attributes->bxdf)
      << "a later pattern leaves the snapshot alone";
  ASSERT_EQ(r.primitive(2).attributes->bxdf->patterns.size(), 3u) << "the inner pattern went with its block";
}

TEST(Shading, PatternsMayStandBehindWhatReadsThem) {
  const Read r = readWorld(
      "Displace \"PxrDisplace\" \"d\" \"reference float dispScalar\" [\"p:out\"]\nPattern \"P\" \"p\"\nSphere 1 -1 1 "
      "360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->displacement->patterns.size(), 1u);
}

TEST(Shading, LayeredBxdfsReadBxdfs) {
  const Read r = readWorld(
      "Bxdf \"LamaDiffuse\" \"a\"\nBxdf \"LamaSurface\" \"b\" \"reference bxdf materialFront\" [\"a\"]\nSphere 1 -1 "
      "1 360");
  expectClean(r);
  EXPECT_EQ(r.primitive().attributes->bxdf->patterns.at(0)->plugin, "LamaDiffuse");
}

TEST(Shading, ABxdfMayBeNamedAsThePatternItReads) {
  const Read r = readWorld(
      "Pattern \"P\" \"wood\"\nBxdf \"B\" \"wood\" \"reference color c\" [\"wood:out\"]\nSphere 1 -1 1 360");
  expectClean(r);
  ASSERT_EQ(r.primitive().attributes->bxdf->patterns.size(), 1u);
  EXPECT_EQ(r.primitive().attributes->bxdf->patterns[0]->plugin, "P");
}

// A Bxdf line of nothing but __materialid names a material that another scope bound; with a parameter, another handle
// or an id that nobody bound it is a material of its own.
TEST(Shading, MaterialsAreFoundByTheirId) {
  const Read r = readWorld(R"(AttributeBegin
Pattern "P" "p"
Bxdf "S" "m" "reference color diffuseColor" ["p:result"] "string __materialid" ["SG"]
AttributeEnd
Bxdf "S" "m" "string __materialid" ["SG"]
Sphere 1 -1 1 360
Bxdf "S" "m" "string __materialid" ["other"]
Sphere 1 -1 1 360
Bxdf "S" "n" "string __materialid" ["SG"]
Sphere 1 -1 1 360
Bxdf "S" "m" "float gain" [2] "string __materialid" ["SG"]
Sphere 1 -1 1 360)");
  expectClean(r);
  const auto terminal = [&](size_t i) { return r.primitive(i).attributes->bxdf->terminal; };
  EXPECT_NE(terminal(0)->params.find("diffuseColor"), nullptr);
  EXPECT_EQ(r.primitive(0).attributes->bxdf->patterns.size(), 1u);
  EXPECT_EQ(terminal(1)->params.find("diffuseColor"), nullptr);
  EXPECT_EQ(terminal(2)->params.find("diffuseColor"), nullptr);
  EXPECT_NE(terminal(3)->params.find("gain"), nullptr);
}

TEST(Lights, ModernWithFiltersPatternsAndMesh) {
  const Read r = readWorld(R"(AttributeBegin
Translate 0 5 0
LightFilter "PxrRodLightFilter" "rod" "float width" [2]
Pattern "PxrTexture" "map"
Attribute "grouping" "string membership" ["key"]
Light "PxrRectLight" "rect" "float intensity" [3] "reference color lightColor" ["map:resultRGB"]
AttributeEnd
AttributeBegin
Light "PxrMeshLight" "mesh" "float intensity" [1]
Sphere 1 -1 1 360
AttributeEnd
Sphere 2 -2 2 360)");
  expectClean(r);
  ASSERT_EQ(r.world().lights.size(), 2u);
  const Light& l = r.world().lights[0];
  EXPECT_EQ(l.node->plugin, "PxrRectLight");
  EXPECT_EQ(l.toWorld.matrices[0][3][1], 5);
  ASSERT_EQ(l.filters.size(), 1u);
  ASSERT_EQ(l.filterToWorld.size(), 1u);
  EXPECT_EQ(l.filterToWorld[0].matrices[0][3][1], 5);
  ASSERT_EQ(l.patterns.size(), 1u);
  EXPECT_EQ(l.attributes->named.getString("grouping:membership", ""), "key");
  ASSERT_TRUE(r.world().lights[1].geometry);
  EXPECT_EQ(std::get<Quadric>(r.world().lights[1].geometry->shape).args[0], 1);
  ASSERT_EQ(r.world().primitives.size(), 1u) << "a mesh light's geometry is the light's";
}

TEST(Lights, ClassicOnesAreKept) {
  const Read r = readWorld(R"(LightSource "pointlight" 1 "from" [1 2 3] "intensity" 4
AreaLightSource "PxrStdAreaLight" "area" "float exposure" [2]
Geometry "rectlight"
Surface "plastic" "Kd" 0.5
Illuminate 1 0
Sphere 1 -1 1 360)");
  ASSERT_EQ(r.world().classicLights.size(), 3u);
  EXPECT_EQ(r.world().classicLights[0].node->kind, "LightSource");
  EXPECT_EQ(r.world().classicLights[0].node->handle, "1");
  EXPECT_EQ(r.world().classicLights[0].node->params.getFloats("from"), (std::vector<float>{1, 2, 3}));
  EXPECT_TRUE(r.world().classicLights[1].geometry);
  EXPECT_TRUE(r.world().lights.empty());
  EXPECT_EQ(r.primitive(1).attributes->classicShaders.at(0)->plugin, "plastic");
  EXPECT_EQ(*r.primitive(0).attributes->lightSources, (std::vector<uint32_t>{r.world().classicLights[0].id}));
  EXPECT_EQ(r.primitive(1).attributes->lightSources, nullptr);
  EXPECT_TRUE(r.messages.empty()) << "a Surface is rendered, a light's shape is that of its stand-in\n" << r.all();
}

// RISpec 4.1.6: the list of light sources is an attribute. Ids are those of Scene::classicLights.
TEST(Lights, LightSourcesFollowTheAttributeStack) {
  const Read r = readWorld(R"(LightSource "pointlight" 1
AttributeBegin
LightSource "pointlight" 2
LightSource "pointlight" "three"
Sphere 1 -1 1 360
Illuminate 1 0
Illuminate "three" "off"
Sphere 1 -1 1 360
AttributeEnd
Sphere 1 -1 1 360
Illuminate 2 1
Illuminate 1 0
Light "PxrDomeLight" "dome"
Illuminate "dome" 0
TransformBegin
Sphere 1 -1 1 360
TransformEnd
Illuminate "dome" 1
Illuminate 2 0
Sphere 1 -1 1 360)");
  ASSERT_EQ(r.world().classicLights.size(), 3u);
  const uint32_t one = r.world().classicLights[0].id, two = r.world().classicLights[1].id,
                 three = r.world().classicLights[2].id;
  const auto list = [&](size_t i) {
    const auto& held = r.primitive(i).attributes->lightSources;
    return held ? *held : std::vector<uint32_t>();
  };
  EXPECT_EQ(list(0), (std::vector<uint32_t>{one, two, three}));
  EXPECT_EQ(list(1), (std::vector<uint32_t>{two}));
  EXPECT_EQ(list(2), (std::vector<uint32_t>{one}));
  EXPECT_EQ(list(3), (std::vector<uint32_t>{two}));
  EXPECT_EQ(r.primitive(3).attributes->named.find("illuminate:off")->strings, (std::vector<std::string>{"dome"}));
  EXPECT_EQ(list(4), (std::vector<uint32_t>{}));
  EXPECT_EQ(r.primitive(4).attributes->named.find("illuminate:off"), nullptr);
  EXPECT_TRUE(r.messages.empty()) << r.all();
}

// They stand in it, as other lights do, and no list of the world's names them.
TEST(Lights, ClassicOnesInObjects) {
  const Read r = readWorld(R"(LightSource "pointlight" 1
ObjectBegin "lamp"
LightSource "pointlight" 2 "from" [1 2 3]
Translate 0 0 1
AreaLightSource "area" 3
Sphere 1 -1 1 360
Sphere 2 -2 2 360
AreaLightSource "" 4
Sphere 4 -4 4 360
ObjectEnd
ObjectInstance "lamp"
Illuminate 2 0
Sphere 3 -3 3 360)");
  ASSERT_EQ(r.world().prototypes.size(), 1u);
  const Prototype& lamp = r.world().prototypes[0];
  EXPECT_EQ(lamp.primitives.size(), 1u) << "shapes of lights belong to them";
  ASSERT_EQ(lamp.lights.size(), 3u);
  EXPECT_FALSE(lamp.lights[0].geometry);
  for (size_t k = 1; k < 3; ++k) {
    ASSERT_TRUE(lamp.lights[k].geometry);
    EXPECT_EQ(lamp.lights[k].geometry->toWorld.matrices[0].translation(), Imath::V3d(0, 0, 1));
    EXPECT_EQ(std::get<Quadric>(lamp.lights[k].geometry->shape).args[0], float(k));
  }
  ASSERT_EQ(r.world().classicLights.size(), 1u);
  EXPECT_EQ(lamp.primitives[0]->attributes->lightSources, nullptr);
  ASSERT_TRUE(r.primitive(0).attributes->lightSources);
  EXPECT_EQ(*r.primitive(0).attributes->lightSources, (std::vector<uint32_t>{r.world().classicLights[0].id}));
  const Parameter* off = r.primitive(0).attributes->named.find("illuminate:off");
  ASSERT_TRUE(off);
  EXPECT_EQ(off->strings, (std::vector<std::string>{"2"}));
  expectClean(r);
}

TEST(Lights, BeforeTheWorldMoveWithTheCamera) {
  const Read r = readRib(R"(FrameBegin 1
Translate 0 0 2
LightSource "pointlight" 1
Light "PxrDomeLight" "dome"
Translate 1 0 0
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
FrameBegin 2
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
)");
  ASSERT_EQ(r.worlds.size(), 2u);
  ASSERT_EQ(r.worlds[0].classicLights.size(), 1u);
  ASSERT_EQ(r.worlds[0].lights.size(), 1u);
  // the light is 2 in front of the camera, which is at (-1, 0, -2)
  EXPECT_EQ(r.worlds[0].classicLights[0].toWorld.matrices[0].translation(), Imath::V3d(-1, 0, 0));
  EXPECT_EQ(r.worlds[0].lights[0].toWorld.matrices[0].translation(), Imath::V3d(-1, 0, 0));
  EXPECT_EQ(*r.worlds[0].primitives[0]->attributes->lightSources,
            (std::vector<uint32_t>{r.worlds[0].classicLights[0].id}));
  EXPECT_TRUE(r.worlds[1].classicLights.empty()) << "the frame's end forgets them";
  EXPECT_EQ(r.worlds[1].primitives[0]->attributes->lightSources, nullptr);
}

}  // namespace
}  // namespace kinora::rib
