// Proves: the standard set sums to beauty with every integrator on every gallery scene; light groups and lpegroups
// part the light; unoccluded and blocked light add up; a malformed expression is told with a caret and seen; signals
// of user lobes. Misses: volumes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

const std::vector<std::string> kParts{"emissive",         "diffuse",    "indirectDiffuse", "specular",
                                      "indirectSpecular", "subsurface", "transmissive",    "volume"};

// Worst difference between the sum of channels and another one, relative where that is above 1e-3.
double worst(SceneRender& r, const std::vector<std::string>& parts, const std::string& whole) {
  const image::Image sum = r.channel(whole);
  std::vector<double> total(sum.pixels.size(), 0);
  for (const std::string& name : parts) {
    const image::Image p = r.channel(name);
    for (size_t i = 0; i < total.size(); ++i) total[i] += p.pixels[i];
  }
  double d = 0;
  for (size_t i = 0; i < total.size(); ++i)
    d = std::max(d, std::fabs(total[i] - double(sum.pixels[i])) / std::max(1e-3, std::fabs(double(sum.pixels[i]))));
  return d;
}
double mean(SceneRender& r, const std::string& channel) {
  double s = 0;
  for (int c = 0; c < 3; ++c) s += overPixels(r.channel(channel), c).mean();
  return s / 3;
}

// Every gallery scene with every stock integrator. Those that transport light fill all parts; those that show
// something else (openness, geometry, the soundness of a material) send one signal from the first hit to the eye,
// which is emission to an expression: it stands in "emissive", and the sum holds for them too. KINORA_LPE_SCALE=N
// renders N times as wide.
TEST(LightPathChannels, StandardSetSumsToBeautyEverywhere) {
  std::vector<std::string> files;
  for (const auto& e : std::filesystem::directory_iterator(KINORA_SOURCE_DIR "/scenes"))
    if (e.path().extension() == ".rib") files.push_back(e.path().string());
  std::sort(files.begin(), files.end());
  ASSERT_GE(files.size(), 6u);
  const std::set<std::string> transport{"PxrPathTracer", "PxrDirectLighting", "PxrDefault", "PxrVCM", "PxrUnified"};
  const std::set<std::string> signals{"PxrOcclusion", "PxrVisualizer", "PxrValidateBxdf"};
  Registry registry;
  std::vector<std::string> integrators;
  for (const Descriptor* d : registry.all(Kind::Integrator)) {
    integrators.push_back(d->name);
    EXPECT_EQ(transport.count(d->name) + signals.count(d->name), 1u) << d->name << ": say which of the two it is";
  }
  ASSERT_EQ(integrators.size(), transport.size() + signals.size());
  const std::set<std::string> withMedia{"cloud", "fire", "shafts", "caustic_in_fog", "candle", "milk"};
  const char* const scale = std::getenv("KINORA_LPE_SCALE");
  const int times = scale ? std::max(1, std::atoi(scale)) : 1;
  std::map<std::string, double> seen;
  for (const std::string& file : files)
    for (const std::string& integrator : integrators) {
      SCOPED_TRACE(file + ' ' + integrator);
      RenderRequest q;
      q.file = file;
      q.channels = "Ci,beauty";
      for (const std::string& p : kParts) q.channels += "," + p;
      q.settings.resolution = {48 * times, 27 * times};
      q.settings.samplesPerPixel = 4;
      q.settings.integrator = integrator;
      SceneRender r(q);
      ASSERT_TRUE(r.ok());
      const std::string name = std::filesystem::path(file).stem().string();
      const bool hasMedia = withMedia.count(name) != 0,
                 scatters = integrator == "PxrPathTracer" || integrator == "PxrDirectLighting" ||
                            integrator == "PxrUnified" || integrator == "PxrVCM";
      for (const std::string& m : r.messages())
        EXPECT_TRUE(hasMedia && !scatters && m.find("MEDIUM-INTEGRATOR") != std::string::npos) << m;
      const double d = worst(r, kParts, "Ci");
      if (scale) std::printf("%s %s: %.2e\n", std::filesystem::path(file).stem().c_str(), integrator.c_str(), d);
      EXPECT_LT(d, 1e-5);
      EXPECT_EQ(worst(r, {"beauty"}, "Ci"), 0);
      // nothing in a closed room is open, and of a cloud alone nothing is left without scattering
      if ((integrator != "PxrOcclusion" || name != "covered_lamp") && (scatters || name != "cloud")) {
        EXPECT_NE(mean(r, "Ci"), 0);
      }
      if (signals.count(integrator)) {
        EXPECT_EQ(worst(r, {"emissive"}, "Ci"), 0);
      } else if (!hasMedia) {
        EXPECT_GT(mean(r, "diffuse"), 1e-3);
      } else if (scatters && name != "candle" && name != "milk") {  // a flame only emits; milk is behind clear glass
        EXPECT_GT(mean(r, "volume"), 1e-5);
      }
      if (integrator == "PxrPathTracer")
        for (const std::string& p : kParts) seen[p] += mean(r, p);
    }
  for (const std::string& p : kParts) EXPECT_GT(seen[p], 1e-4) << p;
}

// A floor, a ball on it, a key light and a fill light, a wall that blocks the key.
std::string room(const std::string& options) {
  return R"(
Hider "raytrace" "int maxsamples" [64]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [2] "float clampLuminance" [1e30]
Format 32 32 1
PixelFilter "box" 1 1
)" + options +
         R"(
Projection "perspective" "fov" [50]
Translate 0 -1 4
WorldBegin
  AttributeBegin
    ConcatTransform [1 0 0 0  0 0 1 0  0 -1 0 0  1 2.5 0 1]
    Light "PxrRectLight" "key" "float intensity" [6] "string lightGroup" ["key"]
  AttributeEnd
  Light "PxrDomeLight" "fill" "float intensity" [0.2] "string lightGroup" ["fill"]
  AttributeBegin
    Attribute "identifier" "string lpegroup" ["floor"]
    Bxdf "PxrDiffuse" "floor" "color diffuseColor" [0.5 0.5 0.5]
    Polygon "vertex point P" [-3 0 -3  3 0 -3  3 0 3  -3 0 3]
  AttributeEnd
  AttributeBegin
    Bxdf "PxrDiffuse" "wall" "color diffuseColor" [0.6 0.3 0.2]
    Polygon "vertex point P" [0.6 0 -0.5  0.6 1.2 -0.5  0.6 1.2 1  0.6 0 1]
    Translate -0.6 0.5 0
    Sphere 0.5 -0.5 0.5 360
  AttributeEnd
WorldEnd
)";
}
std::string channel(const std::string& name, const std::string& expression) {
  return "DisplayChannel \"color " + name + "\" \"string source\" [\"color lpe:" + expression + "\"]\n";
}

TEST(LightPathChannels, GroupsOfLightsAndSurfaces) {
  RenderRequest q;
  q.rib = room(channel("key", "C.*[<L.'key'><O.'key'>]") + channel("fill", "C.*[<L.'fill'><O.'fill'>]") +
               channel("other", "C.*<L.'none'>") + channel("lit", "C.*L") + channel("seen", "CO") +
               channel("none", "CL") + channel("floor", "C<.D'floor'>[DS]*[LO]") +
               channel("rest", "C[^<.D'floor'>][DS]*[LO]") + channel("sky", "C[LO]") + channel("d1", "CD1.*L") +
               channel("d2", "C<RD'Diffuse'>.*L"));
  q.channels = "Ci,key,fill,other,lit,seen,none,floor,rest,sky,d1,d2,indirect,direct";
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  ASSERT_EQ(r.messages().size(), 1u);
  EXPECT_NE(r.messages()[0].find("LPE-EMPTY"), std::string::npos) << "CL is no path: " << r.messages()[0];
  EXPECT_LT(worst(r, {"key", "fill"}, "Ci"), 1e-5);
  // a light that the camera sees is in one of both
  EXPECT_LT(worst(r, {"lit", "seen"}, "Ci"), 1e-5);
  EXPECT_LT(worst(r, {"sky"}, "seen"), 1e-6);
  EXPECT_GT(mean(r, "seen"), 0.02);
  EXPECT_EQ(mean(r, "none"), 0);
  EXPECT_LT(worst(r, {"direct", "indirect"}, "Ci"), 1e-5);
  EXPECT_LT(worst(r, {"floor", "rest", "sky"}, "Ci"), 1e-5);
  EXPECT_LT(worst(r, {"d2", "sky"}, "Ci"), 1e-5) << "all materials have one lobe, \"Diffuse\"";
  EXPECT_GT(mean(r, "key"), 0.02);
  EXPECT_GT(mean(r, "fill"), 0.02);
  EXPECT_EQ(mean(r, "other"), 0);
  EXPECT_EQ(mean(r, "d1"), 0) << "\"Diffuse\" is D2";
  EXPECT_GT(mean(r, "floor"), 0.02);
  EXPECT_GT(mean(r, "rest"), 0.003);
}

// Indirect rays see nothing of a scene, and shadow rays neither.
void hideFromLight(scene::Scene& s) {
  for (auto& p : s.primitives) {
    auto a = std::make_shared<scene::Attributes>(*p->attributes);
    scene::Parameter v;
    v.name = "visibility:transmission";
    v.type = scene::ValueType::Int;
    v.ints = {0};
    a->named.set(v);
    v.name = "visibility:indirect";
    a->named.set(v);
    s.setPrimitiveAttributes(p->id, a);
  }
}

// The light that the wall blocks is the difference between a room without shadows and the room: against a scene in
// which the wall and the ball cast none.
TEST(LightPathChannels, UnoccludedAndBlockedLight) {
  const std::string channels =
      channel("open", "unoccluded;CDL") + channel("shade", "shadows;CDL") + channel("lit", "CDL");
  RenderRequest q;
  q.rib = room(channels);
  q.channels = "Ci,open,shade,lit";
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  EXPECT_GT(mean(r, "shade"), 0.005);
  EXPECT_LT(worst(r, {"shade", "lit"}, "open"), 1e-3) << "the same samples, added in another order";
  RenderRequest none = q;
  none.edit = hideFromLight;
  none.channels = "Ci,lit";
  // indirect rays see nothing and shadow rays neither: what reaches a point is unshadowed, by both techniques
  testing::Moments a, b;
  for (uint32_t seed = 0; seed < 12; ++seed) {
    q.settings.seed = seed + 1;
    none.settings.seed = seed + 101;
    SceneRender x(q), y(none);
    a.add(mean(x, "open"));
    b.add(mean(y, "lit"));
  }
  EXPECT_SAME_MEAN(a, b, 0.01);
}

// Directions that a glossy floor draws find lights behind what is in the way, too: light as if unoccluded has the mean
// and the noise of a room without shadows. (By light samples alone it has many times that noise.)
TEST(LightPathChannels, UnoccludedLightOnGlossySurfacesIsAsQuietAsThePicture) {
  for (const char* integrator : {"PxrPathTracer", "PxrVCM"}) {
    SCOPED_TRACE(integrator);
    RenderRequest q;
    q.rib = room(channel("open", "unoccluded;CSL") + channel("lit", "CSL"));
    const std::string floor = "Bxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [0.5 0.5 0.5]";
    ASSERT_NE(q.rib.find(floor), std::string::npos);
    q.rib.replace(q.rib.find(floor), floor.size(),
                  "Bxdf \"PxrSurface\" \"floor\" \"float diffuseGain\" [0] \"color specularEdgeColor\" [1 1 1] "
                  "\"int specularFresnelMode\" [1] \"color specularIor\" [3 3 3] \"int specularModelType\" [1] "
                  "\"float specularRoughness\" [0.08] \"int specularDoubleSided\" [1]");
    q.channels = "Ci,open,lit";
    q.settings.samplesPerPixel = 16;
    q.settings.integrator = integrator;
    q.settings.sets = {{"integrator.maxIndirectBounces", "2"}, {"integrator.clampLuminance", "1e30"}};
    if (std::string(integrator) == "PxrVCM")
      q.settings.sets.insert(q.settings.sets.end(),
                             {{"integrator.connectPaths", "0"}, {"integrator.mergePaths", "0"}});
    RenderRequest none = q;
    none.edit = hideFromLight;
    testing::Moments means[2];
    double noise[2] = {};
    image::Image before[2];
    for (uint32_t seed = 0; seed < 6; ++seed)
      for (const int k : {0, 1}) {
        RenderRequest& of = k ? none : q;
        of.settings.seed = seed + 1;  // the same samples meet the same lights
        SceneRender r(of);
        ASSERT_TRUE(r.ok());
        const image::Image now = r.channel(k ? "lit" : "open");
        means[k].add(overPixels(now).mean());
        for (size_t i = 0; seed && i < now.pixels.size(); ++i) {
          const double d = double(now.pixels[i]) - double(before[k].pixels[i]);
          noise[k] += d * d;
        }
        before[k] = now;
        if (!k) {
          EXPECT_GT(overPixels(now).mean(), 1.005 * overPixels(r.channel("lit")).mean()) << "nothing is in shadow";
        }
      }
    EXPECT_NEAR(means[0].mean(), means[1].mean(), 1e-5 * means[1].mean());
    EXPECT_GT(noise[1], 0);
    EXPECT_LT(noise[0], 1.5 * noise[1]);
  }
}

TEST(LightPathChannels, MalformedOnesAreToldAndSeen) {
  RenderRequest q;
  q.rib = room("DisplayChannel \"color bad\" \"string source\" [\"color lpe:C<RD[DS]*L\"]\n" + channel("none", "CD") +
               "DisplayChannel \"float wrong\" \"string source\" [\"lpe:CDL\"]\n" +
               "DisplayChannel \"color odd\" \"string source\" [\"lpe:CDL\"] \"string statistics\" [\"median\"]\n" +
               "DisplayChannel \"color narrow\" \"string source\" [\"Ci\"] \"string filter\" [\"sharp\"]\n");
  q.channels = "Ci,bad,none,wrong,odd,narrow";
  q.settings.samplesPerPixel = 2;
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  std::string all;
  for (const std::string& m : r.messages()) all += m + "\n";
  EXPECT_NE(
      all.find(
          "test.rib:6: warning LPE-SYNTAX: the light path expression of channel \"bad\" is malformed at character"),
      std::string::npos)
      << all;
  EXPECT_NE(all.find("\n    lpe:C<RD[DS]*L\n             ^\n"), std::string::npos) << all;
  EXPECT_NE(all.find("LPE-EMPTY"), std::string::npos) << all;
  EXPECT_NE(all.find("DISPLAY-CHANNEL-TYPE: channel \"wrong\""), std::string::npos) << all;
  EXPECT_NE(all.find("DISPLAY-CHANNEL-STATISTICS"), std::string::npos) << all;
  EXPECT_NE(all.find("DISPLAY-CHANNEL-FILTER"), std::string::npos) << all;
  const image::Image bad = r.channel("bad");
  EXPECT_EQ(bad.at(5, 5)[0], 1);
  EXPECT_EQ(bad.at(5, 5)[1], 0);
  EXPECT_EQ(bad.at(5, 5)[2], 1);
  EXPECT_EQ(mean(r, "none"), 0);
  EXPECT_GT(mean(r, "wrong"), 0.01) << "as a colour";
}

TEST(LightPathChannels, WithoutAClampNoclampIsNotTold) {
  for (const char* most : {"10", "1e30"}) {
    RenderRequest q;
    q.rib = room(channel("all", "noclamp;C.*[LO]"));
    q.channels = "Ci,all";
    q.settings.samplesPerPixel = 1;
    q.settings.integrator = "PxrPathTracer";
    q.settings.sets.emplace_back("integrator.clampLuminance", most);
    SceneRender r(q);
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(says(r, "LPE-PREFIX"), std::string(most) == "10");
  }
}

TEST(LightPathChannels, SignalsOfUserLobes) {
  RenderRequest q;
  q.rib = room(channel("white", "nothruput;noinfinitecheck;noclamp;unoccluded;overwrite;C<.S'passthru'>*((U2L)|O)") +
               "DisplayChannel \"normal facing\" \"string source\" [\"normal lpe:nothruput;overwrite;CU6L\"]\n");
  q.channels = "Ci,white,facing,albedo,Nn,emissive,a";
  SceneRender r(q);
  ASSERT_TRUE(r.ok());
  EXPECT_EQ(worst(r, {"facing"}, "Nn"), 0);
  EXPECT_LT(worst(r, {"albedo", "emissive"}, "white"), 1e-6);
  EXPECT_GT(mean(r, "white"), 0.2);
}

}  // namespace
}  // namespace kinora::tests
