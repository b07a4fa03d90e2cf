#include "tests/edits/edited_scene.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "image/read_write.h"
#include "rib/reader.h"
#include "tests/support/rib_shapes.h"

namespace kinora::tests {

namespace fs = std::filesystem;

SceneFolder::SceneFolder() {
  std::string pattern = (fs::temp_directory_path() / "kinora_edits_XXXXXX").string();
  EXPECT_NE(mkdtemp(pattern.data()), nullptr);
  path_ = pattern;
  picture("wood.png", 0.25f);
  picture("brick.png", 0.6f);
  picture("sky.png", 0.4f);
  write("stripe.osl", "shader stripe(float at = .5, output color resultRGB = 0) { resultRGB = u > at ? .7 : .2; }\n");
  write("spots.osl", R"(shader spots(float size = 3, string where = "world", output color resultRGB = 0) {
    point p = transform("common", where, P);
    float seen = 0;
    getattribute("user:wear", seen);
    resultRGB = seen + (mod(size * p[0], 1) > .5 ? color(.8, .3, .2) : color(.1, .3, .6));
  })");
}

SceneFolder::~SceneFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void SceneFolder::picture(const std::string& file, float level) const {
  image::Image img(
      {0, 0, 16, 16},
      {{"R", image::StoredType::UInt8}, {"G", image::StoredType::UInt8}, {"B", image::StoredType::UInt8}});
  for (size_t i = 0; i < img.pixels.size(); ++i) img.pixels[i] = i % 7 ? level : 0.9f;
  EXPECT_TRUE(image::write(path_ + "/" + file, img).ok());
}

void SceneFolder::write(const std::string& file, const std::string& text) const {
  std::ofstream(path_ + "/" + file, std::ios::binary) << text;
}

scene::Scene sceneWithEverything(const SceneFolder& folder, Diagnostics& diagnostics) {
  static const std::string kText = std::string(R"(
Option "limits" "int gridsize" [64]
Format 20 14 1
PixelFilter "gaussian" 2 2
Exposure 1 1
Hider "raytrace" "int maxsamples" [2]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [2]
SampleFilter "PxrGradeSampleFilter" "grade" "color gain" [1 0.9 0.8]
DisplayChannel "color Ci"
DisplayChannel "float a"
DisplayChannel "color key" "string source" ["lpe:C.*<L.'warm'>"]
DisplayChannel "normal Nn"
Display "out.exr" "openexr" "Ci,a,z,key,Nn"
Projection "perspective" "fov" [45]
Shutter 0 1
Translate 0 -0.5 6
WorldBegin
TransformBegin
  Translate 1 0 0
  CoordinateSystem "mark"
TransformEnd
AttributeBegin
  Attribute "grouping" "string membership" ["lamps"]
  Translate 0 3 -2
  Rotate 90 1 0 0
  Light "PxrRectLight" "top" "float intensity" [5] "string lightGroup" ["warm"]
AttributeEnd
AttributeBegin
  Translate 2 2 -3
  Scale 0.5 0.5 0.5
  LightFilter "PxrIntMultLightFilter" "dim" "float intensity" [0.8]
  Light "PxrSphereLight" "bulb" "float intensity" [9] "lightfilterreference lightFilters" ["dim"]
AttributeEnd
AttributeBegin
  Attribute "visibility" "int camera" [0]
  Light "PxrDomeLight" "sky" "float intensity" [0.4] "string lightColorMap" ["sky.png"]
AttributeEnd
Pattern "PxrTexture" "wood" "string filename" ["wood.png"]
Pattern "PxrOSL" "lines" "string shader" ["stripe"] "float at" [0.4]
Pattern "PxrOSL" "dots" "string shader" ["spots"] "string where" ["mark"]
Bxdf "PxrDiffuse" "paint" "reference color diffuseColor" ["wood:resultRGB"]
AttributeBegin
  Attribute "identifier" "string name" ["cage"]
  Translate -1.5 0.4 0
  Scale 0.6 0.6 0.6
)") + kCreasedCage + "AttributeEnd\n" +
                                   kHair + R"(AttributeBegin
  Attribute "identifier" "string name" ["floor"]
  Attribute "visibility" "int indirect" [1]
  Attribute "user" "float wear" [0.1]
  Bxdf "PxrDiffuse" "lined" "reference color diffuseColor" ["lines:resultRGB"]
  PointsPolygons [4 4] [0 1 2 3  1 4 5 2] "P" [-3 -1 -3  0 -1 -3  0 -1 3  -3 -1 3  3 -1 -3  3 -1 3]
    "vertex float[2] st" [0 0  1 0  1 1  0 1  2 0  2 1]
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["relief"]
  Attribute "displacementbound" "float sphere" [1]
  Displace "PxrDisplace" "bumps" "float dispAmount" [0.2] "reference float dispScalar" ["wood:resultR"]
  Translate 0 1.4 0
  PointsPolygons [4 3] [0 1 2 3  1 4 2] "P" [-0.5 0 0  0 0 0  0 0.5 0  -0.5 0.5 0  0.5 0.2 0]
    "vertex float[2] st" [0 0  1 0  1 1  0 1  2 0]
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["wall"]
  Attribute "lighting" "string excludesubset" ["lamps"]
  Bxdf "PxrDiffuse" "dotted" "reference color diffuseColor" ["dots:resultRGB"]
  PointsPolygons [4] [0 1 2 3] "P" [-3 -1 3  3 -1 3  3 3 3  -3 3 3] "vertex normal N" [0 0 -1  0.2 0 -1  0 0 -1  -0.2 0 -1]
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["ball"]
  Attribute "grouping" "string membership" ["balls"]
  Bxdf "PxrSurface" "gloss" "color diffuseColor" [0.2 0.4 0.2] "float specularRoughness" [0.3]
    "color specularEdgeColor" [0.5 0.5 0.5]
  MotionBegin [0 1]
    Translate 1 0.5 0
    Translate 1 0.6 0
  MotionEnd
  Sphere 0.4 -0.4 0.4 360
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["glass"]
  Attribute "trace" "string reflectexcludesubset" ["balls"]
  Bxdf "PxrGlass" "clear"
  Translate 0 0 -1
  Sphere 0.5 -0.5 0.5 360
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["flag"]
  Color [0.8 0.3 0.1]
  MotionBegin [0 1]
    PointsPolygons [3] [0 1 2] "P" [-0.5 1 0  0.5 1 0  0 1.8 0]
    PointsPolygons [3] [0 1 2] "P" [-0.5 1 0  0.5 1 0  0.3 1.8 0]
  MotionEnd
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["dust"]
  Points "P" [-1 1 0  1 1.5 0  0.5 1.7 -1] "varying float width" [0.1 0.2 0.1]
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["sheet"]
  Bxdf "PxrSurface" "cutout" "float presence" [0.6] "color diffuseColor" [0.9 0.9 0.5]
  Patch "bilinear" "P" [-2 0 1  -1 0 1  -2 1 1  -1 1.2 1.5]
AttributeEnd
AttributeBegin
  Light "PxrMeshLight" "strip" "float intensity" [6]
  Bxdf "PxrBlack" "black"
  PointsPolygons [4] [0 1 2 3] "P" [2 0 1  2 0 0  2 0.5 0  2 0.5 1]
AttributeEnd
ObjectBegin "leaf"
  Attribute "identifier" "string name" ["blade"]
  Disk 0 0.2 360
  Bxdf "PxrDiffuse" "green" "color diffuseColor" [0.1 0.6 0.2]
  PointsPolygons [3] [0 1 2] "P" [-0.3 0 0  0.3 0 0  0 0.6 0.1]
ObjectEnd
ObjectBegin "twig"
  Attribute "identifier" "string name" ["stem"]
  PointsPolygons [3] [0 1 2] "P" [-0.1 0 0  0.1 0 0  0 1 0]
  AttributeBegin
    Translate 0.3 0.3 0
    ObjectInstance "leaf"
  AttributeEnd
ObjectEnd
AttributeBegin
  Translate -1 0.5 -1
  ObjectInstance "leaf"
AttributeEnd
AttributeBegin
  Translate 1.5 -1 -1
  Rotate 30 0 1 0
  Bxdf "PxrDiffuse" "brown" "color diffuseColor" [0.4 0.2 0.1]
  ObjectInstance "twig"
AttributeEnd
AttributeBegin
  Translate -0.6 -1 -1.5
  ObjectInstance "twig"
AttributeEnd
ObjectBegin "bead"
  SolidBegin "difference"
    Sphere 0.3 -0.3 0.3 360
    SolidBegin "primitive"
      Cylinder 0.1 -0.5 0.5 360
      Disk 0.5 0.1 360
      Disk -0.5 0.1 360
    SolidEnd
  SolidEnd
ObjectEnd
AttributeBegin
  Translate -0.6 0 -1.2
  Rotate 50 0 1 0
  SolidBegin "union"
    ObjectInstance "bead"
    AttributeBegin
      Translate 0.3 0 0
      Sphere 0.2 -0.2 0.2 360
    AttributeEnd
  SolidEnd
AttributeEnd
WorldEnd
)";
  folder.write("scene.rib", kText);
  std::optional<scene::Scene> out;
  rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { out = std::move(s); });
  EXPECT_TRUE(reader.readFile(folder.path() + "/scene.rib"));
  reader.finish();
  EXPECT_TRUE(out);
  return out ? std::move(*out) : scene::Scene();
}

}  // namespace kinora::tests
