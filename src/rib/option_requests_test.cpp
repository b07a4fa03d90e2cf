// What requests before the world leave in the scene description: options, cameras, displays, frames.
#include <array>
#include <string>
#include <vector>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

using namespace scene;

TEST(Options, EveryRequestBeforeTheWorld) {
  const Read r = readRib(R"(version 3.04
FrameBegin 7
Format 640 480 0.5
FrameAspectRatio 1.5
ScreenWindow -1 1 -0.5 0.5
CropWindow 0.1 0.9 0.2 0.8
Projection "perspective" "fov" [40]
Clipping 0.1 1000
DepthOfField 2.8 0.05 3
Shutter 0.25 0.75
PixelFilter "mitchell" 3 4
PixelSamples 4 5
PixelVariance 0.01
Exposure 2 2.2
Option "limits" "int[2] bucketsize" [16 32] "gridsize" [256]
Option "user" "string pass" ["beauty"]
Display "a.exr" "openexr" "rgba" "int[4] quantize" [0 0 0 0]
Display "+b.exr" "openexr" "Ci,a"
DisplayChannel "color diffuse" "string source" ["color lpe:C<RD>[<L.>O]"]
DisplayChannel "varying float[2] two"
Hider "raytrace" "int maxsamples" [64]
Integrator "PxrPathTracer" "it" "int maxIndirectBounces" [4]
SampleFilter "PxrA" "a"
SampleFilter "PxrB" "b" "reference samplefilter[1] filter" ["a"]
DisplayFilter "PxrBackgroundDisplayFilter" "bg" "color backgroundColor" [1 0 0]
Translate 0 0 5
WorldBegin
Sphere 1 -1 1 360
WorldEnd
FrameEnd
)");
  expectClean(r);
  ASSERT_EQ(r.worlds.size(), 1u);
  const Scene& s = r.world();
  EXPECT_TRUE(s.hasFrame);
  EXPECT_EQ(s.frame, 7);
  EXPECT_EQ(s.resolution, (std::array<int, 2>{640, 480}));
  EXPECT_EQ(s.pixelAspect, 0.5f);
  EXPECT_EQ(s.frameAspect, 1.5f);
  EXPECT_EQ(s.cropWindow, (std::array<float, 4>{0.1f, 0.9f, 0.2f, 0.8f}));
  EXPECT_EQ(s.pixelFilter, "mitchell");
  EXPECT_EQ(s.pixelFilterWidth, (std::array<float, 2>{3, 4}));
  EXPECT_EQ(s.pixelSamples, (std::array<int, 2>{4, 5}));
  EXPECT_EQ(s.pixelVariance, 0.01f);
  EXPECT_EQ(s.exposure, (std::array<float, 2>{2, 2.2f}));
  EXPECT_EQ(s.options.find("limits:bucketsize")->ints, (std::vector<int>{16, 32}));
  EXPECT_EQ(s.options.getInt("limits:gridsize", 0), 256);
  EXPECT_EQ(s.options.getString("user:pass", ""), "beauty");
  ASSERT_EQ(s.displays.size(), 2u);
  EXPECT_EQ(s.displays[0].driver, "openexr");
  EXPECT_EQ(s.displays[1].file, "b.exr");
  EXPECT_EQ(s.displays[1].mode, "Ci,a");
  ASSERT_EQ(s.channels.size(), 2u);
  EXPECT_EQ(s.channels[0].name, "diffuse");
  EXPECT_EQ(s.channels[0].type, ValueType::Color);
  EXPECT_EQ(s.channels[0].params.getString("source", ""), "color lpe:C<RD>[<L.>O]");
  EXPECT_EQ(s.channels[1].arrayLength, 2);
  EXPECT_EQ(s.hider->params.getInt("maxsamples", 0), 64);
  EXPECT_EQ(s.integrator->plugin, "PxrPathTracer");
  EXPECT_EQ(s.integrator->handle, "it");
  ASSERT_EQ(s.sampleFilters.size(), 2u);
  EXPECT_EQ(s.sampleFilters.back()->plugin, "PxrB");
  EXPECT_EQ(s.displayFilters[0]->params.getFloats("backgroundColor"), (std::vector<float>{1, 0, 0}));
  ASSERT_EQ(s.cameras.size(), 1u);
  const Camera& c = s.cameras[0];
  EXPECT_EQ(c.projection->params.getFloat("fov", 0), 40);
  EXPECT_EQ(c.screenWindow, (std::array<float, 4>{-1, 1, -0.5f, 0.5f}));
  EXPECT_EQ(c.clipping, (std::array<float, 2>{0.1f, 1000}));
  EXPECT_EQ(c.depthOfField, (std::array<float, 3>{2.8f, 0.05f, 3}));
  EXPECT_EQ(c.shutter, (std::array<double, 2>{0.25, 0.75}));
  EXPECT_EQ(c.worldToCamera.matrices[0][3][2], 5);
  EXPECT_EQ(s.pos.line, 27u);
}

TEST(Options, RiGroupAndDefaults) {
  const Read r = readRib(
      R"(Option "Ri" "int[2] FormatResolution" [32 16] "float PixelVariance" [0.5] "float[2] Shutter" [0 1] "int Frame" [3]
DepthOfField 1e999 1 1
WorldBegin
WorldEnd)");
  expectClean(r);
  EXPECT_EQ(r.world().resolution, (std::array<int, 2>{32, 16}));
  EXPECT_EQ(r.world().pixelVariance, 0.5f);
  EXPECT_EQ(r.world().frame, 3);
  EXPECT_EQ(r.world().cameras[0].shutter[1], 1);
  EXPECT_EQ(r.world().cameras[0].depthOfField[0], 0) << "an infinite f-number is a pinhole";
  EXPECT_EQ(r.world().cameras[0].projection, nullptr);
}

// As the requests that say the same: whole numbers may be floats, and nonsense is refused.
TEST(Options, RiGroupIsChecked) {
  const Read floats = readRib(
      "Option \"Ri\" \"float[2] FormatResolution\" [6 4] \"float FrameAspectRatio\" [-1]\n"
      "WorldBegin\nWorldEnd");
  expectClean(floats);
  EXPECT_EQ(floats.world().resolution, (std::array<int, 2>{6, 4}));
  const Read r = readRib(R"(Clipping 1 2
Shutter 0 1
Format 6 4 1
Option "Ri" "float[2] Clipping" [5 2] "float[2] Shutter" [1 0] "float FrameAspectRatio" [0] "int[2] FormatResolution" [0 0]
WorldBegin
Attribute "Ri" "string Orientation" ["inside"]
Attribute "Ri" "string Orientation" ["foo"]
Sphere 1 -1 1 360
WorldEnd)");
  EXPECT_EQ(r.count("RIB-ARGUMENTS"), 4u) << r.all();
  EXPECT_EQ(r.messages.size(), 4u) << r.all();
  EXPECT_EQ(r.world().cameras[0].clipping, (std::array<float, 2>{1, 2}));
  EXPECT_EQ(r.world().cameras[0].shutter, (std::array<double, 2>{0, 1}));
  EXPECT_EQ(r.world().frameAspect, -1);
  EXPECT_EQ(r.world().resolution, (std::array<int, 2>{6, 4}));
  EXPECT_EQ(r.primitive().attributes->orientation, scene::Attributes::Orientation::Inside);
}

TEST(Cameras, NamedAndPrimary) {
  const Read r = readRib(R"(TransformBegin
Translate 0 0 1
Projection "perspective" "fov" [20]
Camera "side"
TransformEnd
Projection "perspective" "fov" [30]
Translate 0 0 2
Camera "world" "float[2] shutteropening" [0 1]
WorldBegin
WorldEnd)");
  expectClean(r);
  ASSERT_EQ(r.world().cameras.size(), 2u);
  EXPECT_EQ(r.world().cameras[0].name, "world");
  EXPECT_EQ(r.world().cameras[0].worldToCamera.matrices[0][3][2], 2);
  EXPECT_EQ(r.world().cameras[0].params.getFloats("shutteropening").size(), 2u);
  EXPECT_EQ(r.world().cameras[1].name, "side");
  EXPECT_EQ(r.world().cameras[1].projection->params.getFloat("fov", 0), 20);
  // no camera called "world" and nothing else placed: the first one named
  const Read t = readRib("TransformBegin Translate 0 0 4 Camera \"main\" TransformEnd WorldBegin WorldEnd");
  ASSERT_EQ(t.world().cameras.size(), 1u);
  EXPECT_EQ(t.world().cameras[0].name, "main");
}

TEST(Frames, StateComesBackAndFilesAreOneStream) {
  const Read r = readRib(std::vector<std::string>{
      "Format 10 20 1\nFrameBegin 1\nFormat 30 40 1\nWorldBegin\nColor 1 0 0\nSphere 1 -1 1 "
      "360\nWorldEnd\nFrameEnd\n",
      "FrameBegin 2\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd\nFrameEnd\nDeclare \"x\" \"constant float\"\n",
      "WorldBegin\nSphere 1 -1 1 360 \"x\" 3\nWorldEnd\n"});
  expectClean(r);
  ASSERT_EQ(r.worlds.size(), 3u);
  EXPECT_EQ(r.worlds[0].resolution[0], 30);
  EXPECT_EQ(r.worlds[1].resolution[0], 10);
  EXPECT_EQ(r.worlds[1].frame, 2);
  EXPECT_FALSE(r.worlds[1].primitives[0]->attributes->color);
  EXPECT_TRUE(r.worlds[0].primitives[0]->attributes->color);
  EXPECT_EQ(r.worlds[2].primitives[0]->primvars.getFloat("x", 0), 3);
  EXPECT_FALSE(r.worlds[2].hasFrame);
}

TEST(Options, ImagersThatDisplayFiltersStandFor) {
  const Read r = readRib("Imager \"background\" \"color bgcolor\" [.1 .2 .3]\nWorldBegin\nWorldEnd");
  ASSERT_EQ(r.world().displayFilters.size(), 1u);
  const scene::Node& n = *r.world().displayFilters[0];
  EXPECT_EQ(n.plugin, "PxrBackgroundDisplayFilter");
  EXPECT_EQ(n.params.getFloats("backgroundColor"), (std::vector<float>{.1f, .2f, .3f}));
  EXPECT_EQ(n.params.getFloats("backgroundAlpha"), std::vector<float>{1}) << "the imager left alpha 1";
  EXPECT_TRUE(r.messages.empty()) << r.all();
  EXPECT_EQ(r.world().kept.size(), 1u) << "it is written again";
  // one that the scene says itself is the last
  const Read both =
      readRib("DisplayFilter \"PxrBackgroundDisplayFilter\" \"own\"\nImager \"background\"\nWorldBegin\nWorldEnd");
  ASSERT_EQ(both.world().displayFilters.size(), 2u);
  EXPECT_EQ(both.world().displayFilters.back()->handle, "own");
  const auto filterOf = [](const std::string& imager) {
    const Read x = readRib("Imager " + imager + "\nWorldBegin\nWorldEnd");
    EXPECT_TRUE(x.messages.empty()) << x.all();
    EXPECT_EQ(x.world().displayFilters.size(), 1u) << imager;
    return x.world().displayFilters.empty() ? std::make_shared<const scene::Node>() : x.world().displayFilters[0];
  };
  EXPECT_EQ(
      filterOf("\"background\" \"color color\" [1 0 0] \"float alpha\" [0]")->params.getFloats("backgroundAlpha"),
      std::vector<float>{0});
  EXPECT_EQ(filterOf("\"MOSAICbackground\" \"uniform color bgcolor\" [0 1 0]")->params.getFloats("backgroundColor"),
            (std::vector<float>{0, 1, 0}));
  EXPECT_EQ(filterOf("\"clamp\"")->plugin, "ClampDisplayFilter");
  EXPECT_EQ(filterOf("\"clamp\"")->params.getInt("mode", 7), 0);
  EXPECT_EQ(filterOf("\"clamptoalpha\"")->params.getInt("mode", 7), 1);
  const auto gradient = filterOf("\"gradient\" \"uniform color TopColor\" [0 0 1] \"uniform float Sharpness\" [0.5]");
  EXPECT_EQ(gradient->plugin, "GradientDisplayFilter");
  EXPECT_EQ(gradient->params.getFloats("topColor"), (std::vector<float>{0, 0, 1}));
  EXPECT_EQ(gradient->params.getFloats("sharpness"), std::vector<float>{0.5f});
  EXPECT_FALSE(gradient->params.find("bottomColor")) << "the filter has the imager's defaults";
  // of several the last is in force, whether something stands in for it or not
  EXPECT_TRUE(readRib("Imager \"clamp\"\nImager \"fisheye\"\nWorldBegin\nWorldEnd").world().displayFilters.empty());
  // others are named, each once; bad ones do no harm
  const Read others = readRib(
      "Imager \"MOSAICbackground\"\nImager \"fisheye\"\nImager \"fisheye\"\nImager\nImager 3\nImager \"background\" "
      "\"bgcolor\" [1]\nWorldBegin\nWorldEnd");
  EXPECT_EQ(others.count("RIB-KEPT-IMAGER"), 3u) << others.all();
  EXPECT_NE(others.all().find("Imager 'fisheye' is not rendered"), std::string::npos);
  EXPECT_NE(others.all().find("Imager 'MOSAICbackground' is not rendered"), std::string::npos);
  EXPECT_EQ(others.world().displayFilters.size(), 1u);
}

TEST(Options, CameraParametersAndEmptyWindows) {
  const Read r = readRib(R"(Clipping 1 2
CropWindow .5 .5 0 1
Camera "a" "int apertureNSides" [6] "float nearClip" [0.5] "float farClip" [100]
Camera "b" "float nearClip" [5] "float farClip" [1]
WorldBegin
Sphere 1 -1 1 360
WorldEnd
)");
  ASSERT_EQ(r.world().cameras.size(), 2u);
  EXPECT_EQ(r.world().cameras[0].clipping, (std::array<float, 2>{0.5f, 100}));
  EXPECT_EQ(r.world().cameras[1].clipping, (std::array<float, 2>{1, 2})) << "nonsense leaves Clipping";
  EXPECT_EQ(r.world().cropWindow, (std::array<float, 4>{0.5f, 0.5f, 0, 1})) << "the renderer refuses it";
  EXPECT_TRUE(r.messages.empty()) << r.all();
}

// What is asked for by a name that has no effect here is told once; the values that ask for nothing are not.
TEST(Options, NamesWithoutEffectAreTold) {
  const auto said = [](const std::string& before, const std::string& inside = "") {
    const Read r = readRib(before + "\nWorldBegin\n" + inside + "\nSphere 1 -1 1 360\nWorldEnd\n");
    std::string codes;
    for (const Message& m : r.messages) codes += m.code + " ";
    return codes;
  };
  EXPECT_EQ(
      said("Hider \"raytrace\" \"int adaptall\" [1] \"float[2] exposurebracket\" [-2 2] \"int minextrasamples\" "
           "[8]\nHider \"raytrace\" \"int adaptall\" [1]"),
      "RIB-NO-EFFECT-ADAPTALL RIB-NO-EFFECT-EXPOSUREBRACKET RIB-NO-EFFECT-MINEXTRASAMPLES ");
  EXPECT_EQ(
      said("Option \"checkpoint\" \"string interval\" [\"10m\"] \"string exitat\" [\"2h\"] \"int asfinal\" [1]"),
      "RIB-NO-EFFECT-ASFINAL ");
  EXPECT_EQ(said("Option \"lighting\" \"float minimumestimate\" [.01]"), "RIB-NO-EFFECT-MINIMUMESTIMATE ");
  EXPECT_EQ(said("Display \"a.exr\" \"openexr\" \"rgba\" \"int[2] resolution\" [64 64] \"int[2] origin\" [8 8] \"int "
                 "merge\" [1]"),
            "RIB-NO-EFFECT-RESOLUTION RIB-NO-EFFECT-ORIGIN RIB-NO-EFFECT-MERGE ");
  EXPECT_EQ(said("", "Attribute \"trace\" \"int samplemotion\" [0]"), "RIB-NO-EFFECT-SAMPLEMOTION ");
  EXPECT_EQ(said("Option \"shade\" \"int subsurfaceTypeDefaultFromVersion24\" [1] \"int shadowBumpTerminator\" [0] "
                 "\"float roughnessmollification\" [.5]\nOption \"trace\" \"int maxdepth\" [1]\nOption \"trace\" "
                 "\"int maxdepth\" [1]"),
            "RIB-NO-EFFECT-SUBSURFACETYPEDEFAULTFROMVERSION24 RIB-NO-EFFECT-SHADOWBUMPTERMINATOR "
            "RIB-NO-EFFECT-ROUGHNESSMOLLIFICATION RIB-NO-EFFECT-MAXDEPTH ");
  EXPECT_EQ(said("",
                 "Attribute \"trace\" \"float bias\" [.1] \"int autobias\" [0]\nAttribute \"dice\" \"string "
                 "strategy\" [\"worlddistance\"] \"float worlddistancelength\" [.1]"),
            "RIB-NO-EFFECT-AUTOBIAS RIB-NO-EFFECT-STRATEGY RIB-NO-EFFECT-WORLDDISTANCELENGTH ");
  EXPECT_EQ(said("",
                 "Attribute \"volume\" \"float fps\" [30] \"float shutteroffset\" [2] \"int "
                 "velocityshuttercorrection\" [1] \"int voxelinterpolation\" [1]"),
            "RIB-NO-EFFECT-FPS RIB-NO-EFFECT-SHUTTEROFFSET RIB-NO-EFFECT-VELOCITYSHUTTERCORRECTION "
            "RIB-NO-EFFECT-VOXELINTERPOLATION ");
  // what exporters write everywhere
  EXPECT_EQ(
      said("Option \"shade\" \"int subsurfaceTypeDefaultFromVersion24\" [0] \"int shadowBumpTerminator\" [1] "
           "\"float roughnessmollification\" [1]\nOption \"trace\" \"int maxdepth\" [10]",
           "Attribute \"trace\" \"float bias\" [0.001] \"float autobias\" [1]\nAttribute \"dice\" \"string "
           "strategy\" [\"instanceprojection\"] \"float worlddistancelength\" [-1]\nAttribute \"dice\" \"string "
           "strategy\" [\"planarprojection\"]\nAttribute \"volume\" \"float fps\" [24] \"int "
           "velocityshuttercorrection\" [0]"),
      "");
  EXPECT_EQ(said("Hider \"photon\" \"int emit\" [10]"), "RIB-NO-EFFECT-HIDER ");
  EXPECT_EQ(said("Hider \"bake\""), "RIB-NO-EFFECT-HIDER ");
  EXPECT_EQ(said("Hider \"raytracer\""), "RIB-NO-EFFECT-HIDER ");
  for (const char* other : {"raytrace", "hidden", "stochastic", "null", "stitch"})
    EXPECT_EQ(said("Hider \"" + std::string(other) + "\""), "") << other;
  EXPECT_EQ(said("Option \"bucket\" \"string order\" [\"spirals\"]"), "RIB-MISSPELT ");
  EXPECT_EQ(said("Option \"bucket\" \"string order\" [\"spiral\"]"), "");
  EXPECT_EQ(
      said("Hider \"raytrace\" \"int adaptall\" [0] \"float[2] exposurebracket\" [-1 1] \"int minextrasamples\" "
           "[-1] \"int samplemotion\" [0] \"int samplestride\" [2]\nOption \"checkpoint\" \"string interval\" [\"\"] "
           "\"int keepfiles\" [0]\nOption \"lighting\" \"float minimumestimate\" [1e-6]\nDisplay \"a.exr\" "
           "\"openexr\" \"rgba\" \"int[2] origin\" [0 0] \"int merge\" [0]\nHider \"hidden\" \"int jitter\" [1]",
           "Attribute \"trace\" \"int samplemotion\" [1]"),
      "");
}

TEST(Options, SlipsInKnownNamesAreTold) {
  const auto what = [](const std::string& before, const std::string& inside) {
    const Read r = readRib(before + "\nWorldBegin\n" + inside + "\nSphere 1 -1 1 360\nWorldEnd\n");
    const Message* m = r.find("RIB-MISSPELT");
    EXPECT_LE(r.count("RIB-MISSPELT"), 1u) << r.all();
    return m ? m->what + " / " + m->advice : std::string();
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  for (const char* name : {"camra", "camerra", "camrea", "camerq", "Camera"}) {
    const std::string said = what("", std::string("Attribute \"visibility\" \"int ") + name + "\" [0]");
    EXPECT_TRUE(has(said, (std::string("visibility:") + name).c_str()) && has(said, "did you mean \"camera\""))
        << said;
  }
  EXPECT_TRUE(has(what("", "Attribute \"visiblity\" \"int camera\" [0]"), "did you mean \"visibility\""));
  EXPECT_TRUE(has(what("Option \"limits\" \"int threds\" [2]", ""), "did you mean \"threads\""));
  EXPECT_TRUE(has(what("Option \"limit\" \"int threads\" [2]", ""), "did you mean \"limits\""));
  EXPECT_TRUE(has(what("Hider \"raytrace\" \"int maxsample\" [2]", ""), "did you mean \"maxsamples\""));
  EXPECT_TRUE(has(what("", "Attribute \"trace\" \"string holdout\" [\"1\"]"), "is a number"));
  EXPECT_TRUE(has(what("", "Attribute \"lighting\" \"int subset\" [1]"), "is a string"));
  EXPECT_TRUE(has(what("Option \"lpe\" \"string difuse2\" [\"Albedo\"]", ""), "did you mean \"diffuse2\""));
  EXPECT_TRUE(has(what("Option \"lpe\" \"string diffuse2\" [\"Albedo\"] \"string usr12\" [\"\"]", ""), "\"user12\""));
  EXPECT_TRUE(
      has(what("Hider \"raytrace\" \"int foo\" [1]\nHider \"raytrace\" \"int foo\" [1]", ""), "raytrace:foo"));
  EXPECT_EQ(what("Hider \"raytrace\" \"string integrationmode\" [\"path\"] \"float[2] shutteropening\" [0 1] \"float "
                 "dofaspect\" [1]\nHider \"hidden\" \"int foo\" [1]\nOption \"lpe\" \"string user3\" [\"a\"]",
                 ""),
            "");
  // other words, and one's own, are nobody's mistake
  for (const char* said : {"\"user\" \"int camra\" [0]", "\"visibility\" \"int photon\" [0]",
                           "\"visibility\" \"string transmission\" [\"Os\"]", "\"cull\" \"int hidden\" [0]",
                           "\"dice\" \"int hair\" [1]", "\"identifier\" \"string shadinggroup\" [\"a\"]",
                           "\"Ri\" \"int Sides\" [1]", "\"shade\" \"float minsamples\" [2]"})
    EXPECT_EQ(what("", std::string("Attribute ") + said), "");
  EXPECT_EQ(what("Option \"limits\" \"int ptexturememory\" [9] \"color zthreshold\" [1 1 1]\nHider \"hidden\" \"int "
                 "maxsample\" [2]",
                 ""),
            "");
}

TEST(Options, ClippingPlaneIsKeptInCameraSpace) {
  const Read r = readRib("Translate 0 0 5\nRotate 90 0 1 0\nClippingPlane 1 2 0  0 0 2\nWorldBegin\nWorldEnd");
  expectClean(r);
  ASSERT_EQ(r.world().cameras[0].clippingPlanes.size(), 1u);
  const std::array<double, 6> p = r.world().cameras[0].clippingPlanes[0];
  // left-handed: +z turns to +x, +x to -z
  const double expected[6] = {0, 2, 4, 2, 0, 0};
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(p[i], expected[i], 1e-12) << i;
  EXPECT_EQ(readRib("ClippingPlane 1 2 0  0 0 0\nWorldBegin\nWorldEnd").messages.size(), 1u);
}

}  // namespace
}  // namespace kinora::rib
