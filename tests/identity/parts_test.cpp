// Proves: a part of a frame and one of another scene never merge, whatever the scenes differ in, and the message
// names the object; parts of one scene do, also where its text, folder, output or way of rendering differs. Misses:
// differences that no file and no request makes (another maker's CPU).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/diagnostics.h"
#include "film/shard.h"
#include "image/read_write.h"
#include "plugin/registry.h"
#include "render/renderer.h"
#include "rib/reader.h"
#include "tests/support/rib_shapes.h"

namespace kinora {
namespace {

namespace fs = std::filesystem;

const std::string kScene = std::string(R"(# a bit of everything
Option "limits" "int gridsize" [64]
Option "searchpath" "string texture" [".:@"]
Option "statistics" "int endofframe" [0]
Format 12 8 1
PixelFilter "gaussian" 2 2
Exposure 1 1
Hider "raytrace" "int maxsamples" [2]
Integrator "PxrPathTracer" "integrator" "int maxIndirectBounces" [1]
SampleFilter "PxrGradeSampleFilter" "grade" "color gain" [1 0.9 0.8]
Display "out.exr" "openexr" "rgba"
Projection "perspective" "fov" [40]
Shutter 0 1
Translate 0 0 6
WorldBegin
TransformBegin
  Translate 1 0 0
  CoordinateSystem "mark"
TransformEnd
AttributeBegin
  Translate 0 3 -2
  Rotate 90 1 0 0
  Light "PxrRectLight" "key" "float intensity" [5]
AttributeEnd
Pattern "PxrTexture" "wood" "string filename" ["wood.png"]
Pattern "PxrOSL" "lines" "string shader" ["stripe"]
Bxdf "PxrDiffuse" "paint" "reference color diffuseColor" ["wood:resultRGB"]
AttributeBegin
  Attribute "identifier" "string name" ["cage"]
  Sides 2
  Orientation "outside"
)") + tests::kCreasedCage + "AttributeEnd\n" +
                           tests::kHair + R"(AttributeBegin
  Attribute "identifier" "string name" ["floor"]
  Attribute "visibility" "int indirect" [1]
  Bxdf "PxrDiffuse" "lined" "reference color diffuseColor" ["lines:resultRGB"]
  PointsPolygons [4] [0 1 2 3] "P" [-3 -1 -3  3 -1 -3  3 -1 3  -3 -1 3] "vertex float[2] st" [0 0  1 0  1 1  0 1]
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["ball"]
  MotionBegin [0 1]
    Translate 1 0.5 0
    Translate 1 0.6 0
  MotionEnd
  Sphere 0.3 -0.3 0.3 360
AttributeEnd
AttributeBegin
  Attribute "identifier" "string name" ["sheet"]
  TrimCurve [1] [2] [0 0 1 2 3 3] [0] [3] [4] [0.1 0.9 0.9 0.1] [0.1 0.1 0.8 0.1] [1 1 1 1]
  NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 "P" [-2 0 1  -1 0 1  -2 1 1  -1 1 1]
AttributeEnd
ObjectBegin "leaf"
  Attribute "identifier" "string name" ["blade"]
  Disk 0 0.2 360
ObjectEnd
AttributeBegin
  Translate -1 0.5 -1
  ObjectInstance "leaf"
AttributeEnd
WorldEnd
)";

std::string with(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos) {
    ADD_FAILURE() << from << " is not in the scene";
    return text;
  }
  return text.replace(at, from.size(), to);
}

class Parts : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "kinora_identity_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    top_ = pattern;
    folder_ = folderOf("here");
  }
  void TearDown() override { fs::remove_all(top_); }

  // With the files that the scene reads.
  std::string folderOf(const std::string& name) {
    const std::string folder = top_ + "/" + name;
    fs::create_directories(folder);
    picture(folder + "/wood.png", 0.25f);
    put(folder + "/stripe.osl",
        "// stripes\nshader stripe(output color resultRGB = 0) { resultRGB = u > .5 ? .7 : .2; }\n");
    return folder;
  }
  static void picture(const std::string& file, float level) {
    image::Image img(
        {0, 0, 16, 16},
        {{"R", image::StoredType::UInt8}, {"G", image::StoredType::UInt8}, {"B", image::StoredType::UInt8}});
    for (size_t i = 0; i < img.pixels.size(); ++i) img.pixels[i] = i % 7 ? level : 0.9f;
    ASSERT_TRUE(image::write(file, img).ok());
  }
  static void put(const std::string& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

  // Renders samples of the scene's text in the folder and keeps them; returns the part's file.
  std::string part(const std::string& text, int first, const std::string& folder, render::Settings settings = {}) {
    put(folder + "/scene.rib", text);
    std::string said;
    Diagnostics diagnostics([&](const std::string& line, Severity s) {
      if (s != Severity::Info) said += line + "\n";
    });
    Registry registry;
    registry.setPath({folder});
    std::optional<scene::Scene> scene;
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    EXPECT_TRUE(reader.readFile(folder + "/scene.rib")) << said;
    reader.finish();
    if (settings.threads == 0) settings.threads = 1;
    settings.firstSample = first;
    settings.lastSample = first + 1;
    settings.texturePath = settings.shaderPath = {folder};
    settings.volumeReader = {{KINORA_PROGRAM, volume::kReadCommand}, 60};
    render::Renderer renderer(registry, diagnostics, settings);
    const std::string file = top_ + "/part" + std::to_string(++parts_) + ".exr";
    if (!scene || !renderer.load(std::move(*scene)) || renderer.renderFilm() != render::Outcome::Complete ||
        !renderer.writeShard(file))
      ADD_FAILURE() << "no part: " << said;
    said_ = said;
    return file;
  }
  std::string part(const std::string& text, int first) { return part(text, first, folder_); }
  // "" when they merge, else the code and what is said.
  static std::string refusal(const std::string& a, const std::string& b) {
    film::Shard merged;
    std::vector<std::string> warnings;
    const film::Status s = film::mergeShards({a, b}, merged, warnings);
    EXPECT_EQ(s.ok(), merged.film != nullptr);
    EXPECT_TRUE(warnings.empty());
    return s.ok() ? "" : s.code + ": " + s.what;
  }

  std::string top_, folder_, said_;
  int parts_ = 0;
};

TEST_F(Parts, OfOtherScenesAreRefused) {
  const struct {
    const char *from, *to, *named;
  } kKinds[] = {
      // what a frame's hash once did not see
      {"[2.5 1.5]", "[3.5 1.5]", "object \"cage\" (PLACE) differs in tag \"crease\": floats"},
      {"[2.5 1.5]", "[2.5 1.75]", "object \"cage\" (PLACE) differs in tag \"corner\": floats"},
      {"[2 0 1 3]", "[1 0 1 3]", "object \"cage\" (PLACE) differs in tag \"interpolateboundary\": ints"},
      {"catmull-clark", "bilinear", "object \"cage\" (PLACE) differs in scheme"},
      {"Sides 2", "Sides 1", "object \"cage\" (PLACE) differs in sides"},
      {"Orientation \"outside\"", "Orientation \"inside\"", "object \"cage\" (PLACE) differs in orientation"},
      {"\"b-spline\" 1 \"b-spline\" 1", "\"b-spline\" 1 \"catmull-rom\" 1",
       "object \"hair\" (PLACE) differs in v basis"},
      {"Translate 1 0 0\n  Coord", "Translate 2 0 0\n  Coord", "coordinate system \"mark\" differs"},
      // of the frame
      {"[64]", "[65]", "option \"limits:gridsize\" differs"},
      {"\"gaussian\" 2 2", "\"gaussian\" 2 3", "width of the pixel filter differs"},
      {"Exposure 1 1", "Exposure 2 1", "exposure differs"},
      {"\"int maxIndirectBounces\" [1]", "\"int maxIndirectBounces\" [2]",
       "Integrator \"integrator\" (PLACE) differs in parameter \"maxIndirectBounces\""},
      {"[1 0.9 0.8]", "[1 0.9 0.7]", "SampleFilter \"grade\" (PLACE) differs in parameter \"gain\""},
      {"[40]", "[41]", "differs in parameter \"fov\""},
      {"Shutter 0 1", "Shutter 0 0.5", "differs in shutter"},
      {"Translate 0 0 6", "Translate 0 0 7", "differs in transform"},
      // of things in it
      {"[5]", "[6]", "light \"key\" (PLACE) differs in parameter \"intensity\""},
      {"Translate 0 3 -2", "Translate 0 3 -1", "light \"key\" (PLACE) differs in transform"},
      {"[0.3 0.3 0.3]", "[0.3 0.3 0.4]",
       "object \"hair\" (PLACE) differs in Bxdf \"dull\": parameter \"diffuseColor\""},
      {"\"wood.png\"]", "\"wood.png\"] \"int filter\" [1]",
       "object \"cage\" (PLACE) differs in Pattern \"wood\": parameter \"filter\""},
      {"indirect\" [1]", "indirect\" [0]", "object \"floor\" (PLACE) differs in attribute \"visibility:indirect\""},
      {"[0 0  1 0  1 1  0 1]", "[0 0  1 0  1 1  0 2]", "object \"floor\" (PLACE) differs in primvar \"st\""},
      {"1 0.6 0", "1 0.7 0", "object \"ball\" (PLACE) differs in transform"},
      {"Sphere 0.3", "Sphere 0.31", "object \"ball\" (PLACE) differs in size"},
      {"[0.1 0.1 0.8 0.1]", "[0.1 0.1 0.7 0.1]", "object \"sheet\" (PLACE) differs in trim curves"},
      {"Disk 0 0.2", "Disk 0 0.1", "object \"blade\" of ObjectBegin \"leaf\" (PLACE) differs in size"},
      {"Translate -1 0.5 -1", "Translate -1 0.5 -2", "instance of object \"leaf\" (PLACE) differs in transform"},
      {"ObjectBegin \"leaf\"", "ObjectBegin \"twig\" Disk 0 1 360 ObjectEnd ObjectBegin \"leaf\"",
       "ObjectBegin \"twig\" (PLACE) is in this one only"},
      {"Sphere 0.3 -0.3 0.3 360", "Sphere 0.3 -0.3 0.3 360\nSphere 0.1 -0.1 0.1 360", "is in this one only"},
  };
  const std::string first = part(kScene, 0);
  EXPECT_EQ(said_, "");
  for (const auto& k : kKinds) {
    SCOPED_TRACE(k.named);
    std::string said = refusal(first, part(with(kScene, k.from, k.to), 1));
    EXPECT_TRUE(said.starts_with("FILM-SHARD-SCENE: \"" + top_ + "/part")) << said;
    // where the objects stand is told too
    std::string expected = k.named;
    if (const size_t place = expected.find("PLACE"); place != std::string::npos) {
      const size_t at = said.find("scene.rib:"), end = said.find(')', at);
      ASSERT_NE(at, std::string::npos) << said;
      const size_t open = said.rfind('(', at);
      expected.replace(place, 5, said.substr(open + 1, end - open - 1));
    }
    EXPECT_NE(said.find(expected), std::string::npos) << said;
  }
}

TEST_F(Parts, OfOneSceneMerge) {
  const std::string first = part(kScene, 0);
  EXPECT_EQ(refusal(first, part(kScene, 1)), "");
  std::string told = with(kScene, "WorldBegin", "\n\n# another comment\nWorldBegin # here");
  told = with(told, "\"out.exr\"", "\"elsewhere.exr\"");
  told = with(told, "[\".:@\"]", "[\"nowhere:.:@\"]");
  told = with(told, "[0]", "[1]");
  EXPECT_EQ(refusal(first, part(told, 1)), "") << "only the text is another one";
  render::Settings other;
  other.threads = 3;
  other.width = 1;
  other.groupSize = 64;
  other.bucketOrder = "spiral";
  EXPECT_EQ(refusal(first, part(kScene, 1, folder_, other)), "") << "rendered in another way";
  // what the command line says is as if the scene said it
  render::Settings size;
  size.resolution = {12, 8};
  EXPECT_EQ(refusal(first, part(with(kScene, "Format 12 8 1", "Format 60 80 1"), 1, folder_, size)), "");
  EXPECT_EQ(refusal(first, part(kScene, 1, folderOf("there"))), "") << "a copy in another folder";
  EXPECT_EQ(refusal(part(with(kScene, "wood.png", folder_ + "/wood.png"), 0),
                    part(with(kScene, "wood.png", top_ + "/there/wood.png"), 1, top_ + "/there")),
            "")
      << "named by whole paths";
}

TEST_F(Parts, FilesCountByWhatTheyHold) {
  const std::string first = part(kScene, 0);
  const std::string there = folderOf("there");
  picture(there + "/wood.png", 0.26f);
  std::string said = refusal(first, part(kScene, 1, there));
  EXPECT_NE(said.find("texture \"wood.png\" differs"), std::string::npos) << said;
  fs::remove(there + "/wood.png");
  said = refusal(first, part(kScene, 1, there));
  EXPECT_NE(said.find("texture \"wood.png\" differs"), std::string::npos) << said;
  // a shader: what it computes, not how it is written
  folderOf("there");
  put(there + "/stripe.osl",
      "shader stripe(output color resultRGB = 0)\n{\n  resultRGB = u > .5 ? .7 : .2; // moved\n}\n");
  EXPECT_EQ(refusal(first, part(kScene, 1, there)), "");
  put(there + "/stripe.osl", "shader stripe(output color resultRGB = 0) { resultRGB = u > .5 ? .7 : .3; }\n");
  said = refusal(first, part(kScene, 1, there));
  EXPECT_NE(said.find("shader \"stripe\" differs"), std::string::npos) << said;
  // the first process of a farm compiles, the others find what it wrote
  const std::string caching = with(kScene, "Format", "Option \"shader\" \"int cache\" [1]\nFormat");
  const std::string cached = folderOf("cached");
  const std::string source = part(caching, 0, cached);
  ASSERT_TRUE(fs::exists(cached + "/stripe.oso"));
  fs::remove(cached + "/stripe.osl");
  EXPECT_EQ(refusal(source, part(caching, 1, cached)), "");
}

// Each way by which a file gets into a frame.
TEST_F(Parts, FilesOfEveryKindCount) {
  const struct {
    const char *from, *to;        // in the scene
    const char *file, *content;   // that the scene reads then; no content: a picture
    const char *changed, *named;  // what it is replaced by
  } kWays[] = {
      {"wood.png", "skin.<UDIM>.png", "skin.1002.png", nullptr, nullptr, "texture \"skin.<UDIM>.png\" differs"},
      {"Light \"PxrRectLight\" \"key\"", "Light \"PxrDomeLight\" \"sky\" \"string lightColorMap\" [\"sky.png\"]",
       "sky.png", nullptr, nullptr, "texture \"sky.png\" differs"},
      {"\"stripe\"", "\"includes\"", "level.h", "#define LEVEL .2\n", "#define LEVEL .3\n",
       "shader \"includes\" differs"},
      {"\"stripe\"", "\"asks\"", "asked.png", nullptr, nullptr, "texture \"asked.png\" differs"},
  };
  const std::string there = folderOf("there");
  for (const auto& way : kWays) {
    SCOPED_TRACE(way.file);
    const auto fill = [&](const std::string& folder, bool isChanged) {
      picture(folder + "/skin.1001.png", 0.5f);
      put(folder + "/includes.osl",
          "#include \"level.h\"\nshader includes(output color resultRGB = 0) { resultRGB = LEVEL; }\n");
      put(folder + "/asks.osl",
          "shader asks(output color resultRGB = 0) { gettextureinfo(\"asked.png\", \"averagecolor\", resultRGB); "
          "}\n");
      if (way.content)
        put(folder + "/" + way.file, isChanged ? way.changed : way.content);
      else
        picture(folder + "/" + way.file, isChanged ? 0.5f : 0.25f);
    };
    fill(folder_, false);
    fill(there, false);
    const std::string scene = with(kScene, way.from, way.to);
    const std::string first = part(scene, 0);
    EXPECT_EQ(said_, "");
    EXPECT_EQ(refusal(first, part(scene, 1, there)), "");
    fill(there, true);
    const std::string said = refusal(first, part(scene, 1, there));
    EXPECT_NE(said.find(way.named), std::string::npos) << said;
  }
}

// What a shader asks for while the samples are taken: a volume, and a texture by a name that it makes.
TEST_F(Parts, FilesThatAreMetLateCount) {
  const std::string scene = with(kScene, "\"stripe\"", "\"late\"");
  const auto fill = [&](const std::string& folder) {
    put(folder + "/late.osl",
        "shader late(output color resultRGB = 0) { color grid = texture3d(\"smoke.vdb\", point(2, 3, 4), "
        "\"subimage\", "
        "\"density\"); resultRGB = .001 * grid + .5 * (color)texture(concat(\"wo\", \"od.png\"), u, v); }\n");
    fs::copy_file(KINORA_SOURCE_DIR "/tests/shaders/volumes.vdb", folder + "/smoke.vdb",
                  fs::copy_options::overwrite_existing);
  };
  fill(folder_);
  const std::string first = part(scene, 0);
  EXPECT_EQ(said_, "");
  const std::string there = folderOf("there");
  fill(there);
  EXPECT_EQ(refusal(first, part(scene, 1, there)), "");
  {
    // the grid is the same, the file is another: the identifier in its header
    std::fstream vdb(there + "/smoke.vdb", std::ios::in | std::ios::out | std::ios::binary);
    vdb.seekp(30);
    vdb.put('0' + (vdb.seekg(30), vdb.get() == '0' ? 1 : 0));
  }
  std::string said = refusal(first, part(scene, 1, there));
  EXPECT_NE(said.find("volume \"smoke.vdb\" differs"), std::string::npos) << said;
  fs::copy_file(folder_ + "/smoke.vdb", there + "/smoke.vdb", fs::copy_options::overwrite_existing);
  // the texture alone, which no parameter names here
  const std::string plain = with(scene, "Pattern \"PxrTexture\" \"wood\" \"string filename\" [\"wood.png\"]\n", "");
  const std::string before = part(with(plain, "\"reference color diffuseColor\" [\"wood:resultRGB\"]", ""), 0);
  picture(there + "/wood.png", 0.5f);
  said = refusal(before, part(with(plain, "\"reference color diffuseColor\" [\"wood:resultRGB\"]", ""), 1, there));
  EXPECT_NE(said.find("texture \"wood.png\" differs"), std::string::npos) << said;
}

TEST_F(Parts, LibrariesOfPluginsCount) {
  const std::string scene = with(kScene, "\"gaussian\"", "\"Tent\"");
  const std::string there = folderOf("there"), unused = folderOf("unused");
  for (const std::string& folder : {folder_, there, unused}) fs::copy_file(KINORA_TENT, folder + "/Tent.so");
  const std::string first = part(scene, 0);
  EXPECT_EQ(said_, "");
  EXPECT_EQ(refusal(first, part(scene, 1, there)), "");
  std::ofstream(there + "/Tent.so", std::ios::binary | std::ios::app) << "built anew";
  std::string said = refusal(first, part(scene, 1, there));
  EXPECT_NE(said.find("library of the plug-in \"Tent\" differs"), std::string::npos) << said;
  fs::remove(there + "/Tent.so");
  said = refusal(first, part(scene, 1, there));
  EXPECT_NE(said.find("library of the plug-in \"Tent\" is in those before it only"), std::string::npos) << said;
  // one that the scene does not use lies beside it
  EXPECT_EQ(refusal(part(kScene, 0), part(kScene, 1, unused)), "");
}

// A frame after an edit is that of a fresh load: files of the scene before do not count.
TEST_F(Parts, AnEditedSceneIsTheSceneThatItIs) {
  const std::string edited = with(kScene, "\"reference color diffuseColor\" [\"wood:resultRGB\"]", "");
  const auto hashOf = [&](const std::string& file) {
    film::Shard s;
    EXPECT_TRUE(film::readShard(file, s).ok());
    return s.info.sceneHash;
  };
  const std::string before = hashOf(part(kScene, 0)), fresh = hashOf(part(edited, 0));
  EXPECT_EQ(before.size(), 32u);
  EXPECT_NE(before, fresh);
  Diagnostics diagnostics([](const std::string&, Severity) {});
  Registry registry;
  const auto read = [&](const std::string& text) {
    scene::Scene scene;
    rib::RibReader reader(diagnostics, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    put(folder_ + "/scene.rib", text);
    EXPECT_TRUE(reader.readFile(folder_ + "/scene.rib"));
    reader.finish();
    return scene;
  };
  render::Settings settings;
  settings.threads = 1;
  settings.firstSample = 0;
  settings.lastSample = 1;
  settings.texturePath = settings.shaderPath = {folder_};
  render::Renderer renderer(registry, diagnostics, settings);
  ASSERT_TRUE(renderer.load(read(kScene)));
  for (const auto& [text, hash] : {std::pair(edited, fresh), {std::string(kScene), before}}) {
    const scene::Scene wanted = read(text);
    for (size_t i = 0; i < wanted.primitives.size(); ++i)
      ASSERT_TRUE(renderer.scene().replacePrimitive(renderer.scene().primitives[i]->id, *wanted.primitives[i]));
    for (size_t i = 0; i < wanted.prototypes.size(); ++i) renderer.scene().prototypes[i] = wanted.prototypes[i];
    for (size_t i = 0; i < wanted.instances.size(); ++i) renderer.scene().instances.set(i, wanted.instances[i]);
    ASSERT_TRUE(renderer.update());
    ASSERT_EQ(renderer.renderFilm(), render::Outcome::Complete);
    ASSERT_TRUE(renderer.writeShard(top_ + "/edited.exr"));
    EXPECT_EQ(hashOf(top_ + "/edited.exr"), hash);
  }
}

}  // namespace
}  // namespace kinora
