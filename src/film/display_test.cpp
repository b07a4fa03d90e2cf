// Proves that scenes' displays become the right channels, names, files and drivers; that the stock drivers write what
// the film holds, whole or not at all; and that the tools behind diff, merge and info say what is there. It misses
// how other programs read the files.
#include <gtest/gtest.h>
#include <kinora/display.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "film/display_output.h"
#include "film/film_test_samples.h"
#include "film/tools.h"
#include "image/compare.h"
#include "image/read_write.h"
#include "plugin/registry.h"

namespace kinora {
const Descriptor* kinoraStock_openexr();
const Descriptor* kinoraStock_png();
const Descriptor* kinoraStock_jpeg();
const Descriptor* kinoraStock_tiff();
// the table that the build generates from plugins/, cut down to the drivers
std::vector<const Descriptor*> stockPlugins() {
  return {kinoraStock_openexr(), kinoraStock_png(), kinoraStock_jpeg(), kinoraStock_tiff()};
}
}  // namespace kinora

namespace kinora::film {
namespace {

const Descriptor* stockDriver(const std::string& name) {
  static Registry registry;
  static Diagnostics diagnostics([](const std::string&, Severity) {});
  return registry.find(Kind::Display, name, diagnostics, {});
}

scene::Parameter text(const char* name, const char* value) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::String;
  p.strings = {value};
  return p;
}
scene::Parameter integer(const char* name, std::vector<int> values) {
  scene::Parameter p;
  p.name = name;
  p.type = scene::ValueType::Int;
  p.arrayLength = int(values.size());
  p.isArray = values.size() > 1;
  p.ints = std::move(values);
  return p;
}

class Displays : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("kinora-display-" + std::to_string(getpid()) + "-" +
                                                  testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  scene::Display& display(const std::string& file, const char* driver, const char* mode) {
    scene_.displays.push_back({file, driver, mode, {}, {}});
    return scene_.displays.back();
  }
  scene::DisplayChannel& channel(const char* name, scene::ValueType type) {
    scene_.channels.push_back({name, type, 1, {}, {}});
    return scene_.channels.back();
  }
  DisplayPlan plan(const std::string& output = {}) {
    return planDisplays(scene_, {output, false, false}, stockDriver, diagnostics_);
  }
  static std::vector<std::string> names(const Output& o) {
    std::vector<std::string> list;
    for (const OutputChannel& c : o.channels) list.insert(list.end(), c.names.begin(), c.names.end());
    return list;
  }
  // A film of the plan's layout with random samples, 3 of 4 pixels of every channel filled.
  std::unique_ptr<Film> filmFor(const ChannelLayout& layout, Window window = {}) {
    auto film = test::makeFilm(24, 20, layout, window);
    test::randomSamples(layout, film->window(), 4, 1).addTo(*film);
    return film;
  }
  static FrameMetadata frame() {
    FrameMetadata f;
    f.frame = 12;
    f.seed = 1ull << 60;
    f.samples = {{0, 4}};
    f.samplesPerPixel = 4;
    f.renderSeconds = 2;
    f.kinoraVersion = "0.1.0";
    f.sceneHash = "cafe";
    f.worldToCamera[12] = 5;
    return f;
  }
  using Names = std::vector<std::string>;
  std::filesystem::path folder_;
  scene::Scene scene_;
  std::vector<std::string> lines_;
  Diagnostics diagnostics_{[this](const std::string& line, Severity) { lines_.push_back(line); }};
};

TEST_F(Displays, ModesAndCommaListsNameTheirChannels) {
  channel("diffuse", scene::ValueType::Color).params.set(text("source", "color lpe:C<RD>[<L.>O]"));
  channel("id", scene::ValueType::Int).params.set(text("filter", "zmin"));
  display("a.exr", "openexr", "rgbaz");
  display("+b.exr", "d_OpenEXR", "Ci, a,diffuse,P,Nn,id,z");
  const DisplayPlan p = plan();
  ASSERT_EQ(p.outputs.size(), 2u);
  EXPECT_EQ(names(p.outputs[0]), (Names{"R", "G", "B", "A", "Z"}));
  EXPECT_EQ(p.outputs[0].driver, "openexr");
  EXPECT_EQ(names(p.outputs[1]), (Names{"R", "G", "B", "A", "diffuse.R", "diffuse.G", "diffuse.B", "P.X", "P.Y",
                                        "P.Z", "Nn.X", "Nn.Y", "Nn.Z", "id", "Z"}));
  EXPECT_EQ(p.layout.size(), 7) << "Ci, a and z are summed once";
  EXPECT_EQ(p.layout[p.layout.find("diffuse")].source, "lpe:C<RD>[<L.>O]");
  EXPECT_EQ(p.layout[p.layout.find("id")].reducer, Reducer::ZMin);
  EXPECT_EQ(p.layout[p.layout.find("z")].reducer, Reducer::Min);
  EXPECT_TRUE(p.layout[p.layout.find("P")].isData);
  EXPECT_FALSE(p.layout[p.layout.find("diffuse")].isData);
  EXPECT_TRUE(lines_.empty());
}

TEST_F(Displays, ChannelDeclarationsSetReducersAndHalves) {
  channel("zavg", scene::ValueType::Float).params.set(text("source", "z"));
  scene_.channels.back().params.set(text("filter", "average"));
  channel("far", scene::ValueType::Float).params.set(text("source", "float z"));
  scene_.channels.back().params.set(text("filter", "zmax"));
  channel("Ci_even", scene::ValueType::Color).params.set(text("source", "Ci"));
  scene_.channels.back().params.set(text("statistics", "even"));
  channel("own", scene::ValueType::Color).params.set(text("filter", "box"));
  channel("m", scene::ValueType::Matrix);
  display("a.exr", "openexr", "zavg,far,Ci_even,own,m,unknown");
  const DisplayPlan p = plan();
  EXPECT_EQ(p.layout[p.layout.find("zavg")].source, "zfiltered");
  EXPECT_EQ(p.layout[p.layout.find("zavg")].reducer, Reducer::Average);
  EXPECT_EQ(p.layout[p.layout.find("far")].reducer, Reducer::ZMax);
  EXPECT_EQ(p.layout[p.layout.find("far")].source, "z");
  EXPECT_EQ(p.layout[p.layout.find("Ci_even")].half, Half::Even);
  EXPECT_EQ(p.layout[p.layout.find("own")].reducer, Reducer::Sum);
  EXPECT_EQ(p.layout[p.layout.find("own")].filter, (ChannelFilter{"box", 2, 2}));
  EXPECT_EQ(diagnostics_.count("DISPLAY-CHANNEL-FILTER"), 0u);
  EXPECT_EQ(diagnostics_.count("DISPLAY-CHANNEL-TYPE"), 1u);
  EXPECT_EQ(diagnostics_.count("DISPLAY-CHANNEL"), 1u) << "unknown";
}

TEST_F(Displays, ModesAreUnderstoodAsPeopleWriteThem) {
  const std::pair<const char*, Names> table[] = {
      {"RGBA", {"R", "G", "B", "A"}},
      {"rgba,z", {"R", "G", "B", "A", "Z"}},
      {"rgba z", {"R", "G", "B", "A", "Z"}},
      {"rgb;a", {"R", "G", "B", "A"}},
      {" rgb , rgba, a ", {"R", "G", "B", "A"}},
      {"zrgba", {"R", "G", "B", "Z", "A"}},
      {"za", {"Z", "A"}},
      {"rgbo", {"R", "G", "B", "Oi.R", "Oi.G", "Oi.B"}},
      {"{Ci,a}", {"R", "G", "B", "A"}},
      {"[rgba]", {"R", "G", "B", "A"}},
      {"r,g,b,a", {"R", "G", "B", "A"}},
      {"", {"R", "G", "B", "A"}},
      {"rgba,albedo,float id", {"R", "G", "B", "A", "albedo.R", "albedo.G", "albedo.B", "id"}},
      {"float mask,point rayO", {"mask", "rayO.X", "rayO.Y", "rayO.Z"}},
      {"varying color tint, normal bend", {"tint.R", "tint.G", "tint.B", "bend.X", "bend.Y", "bend.Z"}},
      {"Ci,lpe:C<RD>[DS]{2,}<L.'key, rim'>,a",
       {"R", "G", "B", "lpe:C<RD>[DS]{2,}<L.'key, rim'>.R", "lpe:C<RD>[DS]{2,}<L.'key, rim'>.G",
        "lpe:C<RD>[DS]{2,}<L.'key, rim'>.B", "A"}},
      // a channel of one of these names is that channel
      {"Ci,rgbz", {"R", "G", "B", "rgbz"}},
  };
  channel("rgbz", scene::ValueType::Float);
  for (const auto& [mode, wanted] : table) {
    scene_.displays.clear();
    display("a.exr", "openexr", mode);
    EXPECT_EQ(names(plan().outputs.at(0)), wanted) << mode;
  }
  EXPECT_TRUE(lines_.empty()) << lines_[0];
  scene_.displays.clear();
  display("a.exr", "openexr", "normal,unheard");
  EXPECT_EQ(plan().outputs.at(0).channels.size(), 2u) << "a type without a name is a name";
  EXPECT_EQ(diagnostics_.count("DISPLAY-CHANNEL"), 2u);
}

TEST_F(Displays, TwoPicturesOntoOneFileAreAnError) {
  display("a.exr", "openexr", "rgba");
  display("+./a.exr", "openexr", "z");
  EXPECT_FALSE(plan().isWritable);
  EXPECT_EQ(diagnostics_.count("DISPLAY-SAME-FILE"), 1u);
  EXPECT_TRUE(plan("b.exr").isWritable) << "-o moves the first out of the way";
  scene_.displays[1].file = "+b.exr";
  EXPECT_TRUE(plan().isWritable);
  EXPECT_FALSE(plan("b.exr").isWritable) << "-o moves the first onto the second";
  // names that become one by their drivers' extensions
  scene_.displays.clear();
  display("a", "openexr", "rgba");
  display("+a.exr", "openexr", "z");
  EXPECT_FALSE(plan().isWritable);
  // windows beside files, and windows alone
  scene_.displays.clear();
  display("a.tif", "framebuffer", "rgba");
  display("+a.tif", "file", "Ci,z");
  display("+b.tif", "it", "rgb");
  display("+b.tif", "framebuffer", "rgb");
  DisplayPlan p = plan();
  EXPECT_TRUE(p.isWritable);
  ASSERT_EQ(p.outputs.size(), 2u);
  EXPECT_EQ(names(p.outputs[0]), (Names{"R", "G", "B", "Z"})) << "the file, not the window";
  p = plan("c.exr");
  ASSERT_EQ(p.outputs.size(), 2u);
  EXPECT_EQ(p.outputs[0].file, "c.exr");
}

TEST_F(Displays, AsRgbaOffKeepsNames) {
  display("a.exr", "openexr", "rgba").params.set(integer("asrgba", {0}));
  EXPECT_EQ(names(plan().outputs[0]), (Names{"Ci.R", "Ci.G", "Ci.B", "a"}));
}

TEST_F(Displays, DriversFollowTheirNameThenTheExtension) {
  const std::tuple<const char*, const char*, const char*, const char*, int> table[] = {
      // file, driver, file written, writer, warnings
      {"a.exr", "openexr", "a.exr", "openexr", 0},
      {"a", "png", "a.png", "png", 0},
      {"a.tif", "tiff", "a.tif", "tiff", 0},
      {"a.tiff", "file", "a.tiff", "tiff", 0},
      {"a.png", "framebuffer", "a.png", "png", 1},
      {"RenderMan", "framebuffer", "RenderMan.exr", "openexr", 1},
      {"untitled", "it", "untitled.exr", "openexr", 1},
      {"shad.z", "zfile", "shad.z.exr", "openexr", 1},
      {"a.tif", "openexr", "a.tif.exr", "openexr", 0},
      {"x.pic", "file", "x.pic.exr", "openexr", 0}};
  for (const auto& [file, driver, written, writer, warnings] : table) {
    scene_.displays.clear();
    const uint64_t before = diagnostics_.count("DISPLAY-DRIVER");
    display(file, driver, "rgb");
    const DisplayPlan p = plan();
    ASSERT_EQ(p.outputs.size(), 1u) << file;
    EXPECT_EQ(p.outputs[0].file, written);
    EXPECT_EQ(p.outputs[0].driver, writer) << file;
    EXPECT_EQ(diagnostics_.count("DISPLAY-DRIVER") - before, uint64_t(warnings)) << file << driver;
  }
}

TEST_F(Displays, AddingAndOverriding) {
  display("second.exr", "openexr", "rgba");
  display("+z.exr", "openexr", "z");
  display("+second.exr", "framebuffer", "rgba");
  DisplayPlan p = plan();
  ASSERT_EQ(p.outputs.size(), 2u);
  EXPECT_EQ(p.outputs[0].file, "second.exr");
  EXPECT_EQ(p.outputs[1].file, "z.exr");
  p = plan("out.png");
  EXPECT_EQ(p.outputs[0].file, "out.png");
  EXPECT_EQ(p.outputs[0].driver, "png");
  EXPECT_EQ(p.outputs[1].file, "z.exr");
  p = plan("out.what");
  EXPECT_EQ(p.outputs[0].file, "out.what.exr");
  EXPECT_EQ(diagnostics_.count("DISPLAY-EXTENSION"), 1u);

  scene_.displays.clear();
  p = plan();
  EXPECT_EQ(p.outputs[0].file, "untitled.exr");
  EXPECT_EQ(names(p.outputs[0]), (Names{"R", "G", "B", "A"}));
  display("z.exr", "openexr", "z");
  p = plan("out.exr");
  ASSERT_EQ(p.outputs.size(), 2u);
  EXPECT_EQ(names(p.outputs[0]), (Names{"R", "G", "B", "A"})) << "-o makes a picture also where the scene has none";
  scene_.displays.clear();
  display("n", "null", "rgba");
  p = plan();
  EXPECT_TRUE(p.outputs.empty());
  EXPECT_EQ(p.layout.size(), 2);
}

TEST(FillFrame, PadsToTheNumberOfMarks) {
  EXPECT_EQ(fillFrame("a.####.exr", 12), "a.0012.exr");
  EXPECT_EQ(fillFrame("a.#.exr", 123), "a.123.exr");
  EXPECT_EQ(fillFrame("a.###", -5), "a.-05");
  EXPECT_EQ(fillFrame("plain.exr", 7), "plain.exr");
}

TEST_F(Displays, ExrHoldsTheFilmsValuesAndMetadata) {
  for (const char* storage : {"scanline", "tiled"}) {
    scene_.displays.clear();
    scene::Display& d = display(path("a.exr"), "openexr", "Ci,a,z,P");
    d.params.set(text("storage", storage));
    d.params.set(text("exrpixeltype", "float"));
    d.params.set(text("compression", "zip"));
    d.params.set(text("exrheader_artist", "nobody"));
    d.params.set(integer("nonsense", {1}));
    DisplayOutput out(plan(), stockDriver, diagnostics_);
    const auto film = filmFor(out.plan().layout, {3, 2, 19, 17});
    ASSERT_TRUE(out.probe());
    ASSERT_TRUE(out.write(*film, frame())) << (lines_.empty() ? "" : lines_.back());
    image::Image back;
    ASSERT_TRUE(image::read(path("a.exr"), back).ok());
    EXPECT_EQ(back.data, film->window());
    EXPECT_EQ(back.display, (Window{0, 0, 24, 20}));
    const image::Image want = pictureOf(*film, out.plan().outputs[0], {});
    image::Difference diff;
    ASSERT_TRUE(image::compare(want, back, {}, diff).ok());
    EXPECT_TRUE(diff.isBitEqual) << storage;
    EXPECT_EQ(std::get<int>(back.metadata.at("frame")), 12);
    EXPECT_EQ(std::get<std::string>(back.metadata.at("seed")), "1152921504606846976");
    EXPECT_EQ(std::get<std::string>(back.metadata.at("sampleRange")), "0:4");
    EXPECT_EQ(std::get<std::string>(back.metadata.at("sceneHash")), "cafe");
    EXPECT_EQ(std::get<std::string>(back.metadata.at("artist")), "nobody");
    EXPECT_EQ(std::get<image::Matrix44>(back.metadata.at("worldtocamera"))[12], 5.0f);
    EXPECT_EQ(out.written(), Names{path("a.exr")});
  }
  EXPECT_EQ(diagnostics_.count("DISPLAY-PARAMETER"), 2u) << "nonsense, both times";
}

TEST_F(Displays, HalfForColoursFloatForData) {
  display(path("a.exr"), "openexr", "Ci,P,z");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  auto film = test::makeFilm(4, 4, out.plan().layout);
  test::Samples s(out.plan().layout.recordFloats());
  s.add(1, 1, 0, 1, {60000, 0.5f, 65530, 1.00001f, 2, 3, INFINITY});
  s.addTo(*film);
  ASSERT_TRUE(out.write(*film, frame()));
  image::Image back;
  ASSERT_TRUE(image::read(path("a.exr"), back).ok());
  const auto at = [&](const char* n) { return back.at(1, 1)[back.findChannel(n)]; };
  EXPECT_EQ(back.channels[size_t(back.findChannel("R"))].type, image::StoredType::Half);
  EXPECT_EQ(back.channels[size_t(back.findChannel("P.X"))].type, image::StoredType::Float);
  EXPECT_EQ(at("R"), 60000.0f);
  EXPECT_EQ(at("B"), 65504.0f) << "half's largest number instead of infinity";
  EXPECT_NEAR(at("P.X"), 1.00001f, 1e-5f);
  EXPECT_EQ(at("Z"), kNoDepth);
}

TEST_F(Displays, AutocropShrinksTheDataWindow) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("autocrop", "true"));
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  auto film = test::makeFilm(10, 10, out.plan().layout);
  image::Image back;
  ASSERT_TRUE(out.write(*film, frame()));
  ASSERT_TRUE(image::read(path("a.exr"), back).ok());
  EXPECT_EQ(back.data.pixels(), 1u) << "nothing there";
  test::Samples s(4);
  s.add(3, 4, 0, 1, {1, 1, 1, 1});
  s.add(6, 5, 0, 1, {1, 1, 1, 1});
  s.addTo(*film);
  ASSERT_TRUE(out.write(*film, frame()));
  ASSERT_TRUE(image::read(path("a.exr"), back).ok());
  EXPECT_EQ(back.data, (Window{3, 4, 7, 6}));
  EXPECT_EQ(back.at(6, 5)[3], 1.0f);
}

// Text chunks of a PNG, and which chunks there are.
std::map<std::string, std::string> chunksOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::map<std::string, std::string> chunks;
  for (size_t at = 8; at + 12 <= bytes.size();) {
    uint32_t n = 0;
    for (size_t k = 0; k < 4; ++k) n = n << 8 | uint8_t(bytes[at + k]);
    const std::string type = bytes.substr(at + 4, 4), data = bytes.substr(at + 8, n);
    chunks[type == "tEXt" ? "text " + data.substr(0, data.find('\0')) : type] =
        type == "tEXt" ? data.substr(data.find('\0') + 1) : data;
    at += 12 + n;
  }
  return chunks;
}

// Straight alpha and a truthful word about the codes, of 8 and of 16 bits, through sRGB and through a gamma of the
// scene's; the same colours in a TIFF stay multiplied.
TEST_F(Displays, PngHasStraightAlphaAndSaysWhatItsCodesAre) {
  struct Case {
    const char *file, *driver;
    int quantize;
    float gamma;
  };
  for (const Case& k : {Case{"a.png", "png", 1, 1},
                        {"b.png", "png", 0, 1},
                        {"c.png", "png", 1, 2.2f},
                        {"d.png", "png", 0, 1.8f},
                        {"e.tif", "tiff", 0, 1}}) {
    scene_.displays.clear();
    scene::Display& d = display(path(k.file), k.driver, "rgba");
    d.params.set(integer("quantize", {k.quantize}));
    scene_.exposure = {1, k.gamma};
    DisplayOutput out(plan(), stockDriver, diagnostics_);
    auto film = test::makeFilm(4, 1, out.plan().layout);
    const float pixels[4][4] = {
        {0.25f, 0.1f, 0.05f, 0.5f}, {0.2f, 0.2f, 0.2f, 0}, {0.5f, 0.25f, 0.125f, 1}, {0.03f, 0.02f, 0.3f, 0.1f}};
    test::Samples s(4);
    for (int x = 0; x < 4; ++x) s.add(x, 0, 0, 1, {pixels[x][0], pixels[x][1], pixels[x][2], pixels[x][3]});
    s.addTo(*film);
    ASSERT_TRUE(out.write(*film, frame()));
    image::Image back;
    ASSERT_TRUE(image::read(path(k.file), back).ok());
    const bool isTiff = k.driver[0] == 't';
    const double most = k.quantize ? 255 : 65535;
    for (int x = 0; x < 4; ++x) {
      const double a = double(pixels[x][3]);
      for (int c = 0; c < 3; ++c) {
        double v = double(pixels[x][c]);
        if (!isTiff && a > 0) v = std::min(1.0, v / a);
        const double code = k.gamma != 1    ? std::pow(v, 1 / double(k.gamma))
                            : v > 0.0031308 ? 1.055 * std::pow(v, 1 / 2.4) - 0.055
                                            : 12.92 * v;
        EXPECT_NEAR(double(back.at(x, 0)[c]), code, 0.51 / most) << k.file << " " << x << " " << c;
      }
      EXPECT_NEAR(double(back.at(x, 0)[3]), a, 0.51 / most);
    }
    if (isTiff) continue;
    const auto chunks = chunksOf(path(k.file));
    if (k.gamma == 1) {
      EXPECT_EQ(chunks.at("text colorSpace"), "sRGB");
      EXPECT_TRUE(chunks.contains("sRGB"));
    } else {
      EXPECT_EQ(chunks.at("text colorSpace"), k.gamma == 2.2f ? "gamma 2.2" : "gamma 1.8");
      EXPECT_FALSE(chunks.contains("sRGB"));
      uint32_t stated = 0;
      for (const char c : chunks.at("gAMA")) stated = stated << 8 | uint8_t(c);
      EXPECT_NEAR(stated, 1e5 / double(k.gamma), 2) << k.file;
    }
  }
  scene_.exposure = {1, 1};
  // EXR: light as it is
  scene_.displays.clear();
  display(path("f.exr"), "openexr", "rgba");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  ASSERT_TRUE(out.write(*filmFor(out.plan().layout), frame()));
  image::Image exr;
  ASSERT_TRUE(image::readHeader(path("f.exr"), exr).ok());
  EXPECT_EQ(std::get<std::string>(exr.metadata.at("colorSpace")), "linear Rec.709 (sRGB primaries)");
}

TEST_F(Displays, PngIsEncodedAndAgreesWithTheImageWriter) {
  display(path("a.png"), "png", "rgba");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  ASSERT_TRUE(out.write(*film, frame()));
  DisplayOutput plain(plan(), {}, diagnostics_);  // no driver: image/ writes it
  const auto byDriver = path("driver.png");
  std::filesystem::rename(path("a.png"), byDriver);
  ASSERT_TRUE(plain.write(*film, frame()));
  image::Image a, b;
  ASSERT_TRUE(image::read(byDriver, a).ok());
  ASSERT_TRUE(image::read(path("a.png"), b).ok());
  image::Difference d;
  ASSERT_TRUE(image::compare(a, b, {}, d).ok());
  EXPECT_EQ(d.differingValues, 0u);
  EXPECT_EQ(a.channels[0].type, image::StoredType::UInt8);
  scene_.displays[0].params.set(integer("quantize", {0, 65535, 0, 65535}));
  DisplayOutput deep(plan(), stockDriver, diagnostics_);
  ASSERT_TRUE(deep.write(*film, frame()));
  ASSERT_TRUE(image::read(path("a.png"), a).ok());
  EXPECT_EQ(a.channels[0].type, image::StoredType::UInt16);
}

TEST_F(Displays, TiffAndJpegHoldWhatTheImageWriterHolds) {
  for (const char* extension : {"tif", "jpg"}) {
    scene_.displays.clear();
    const std::string name = path(std::string("a.") + extension);
    display(name, extension, "rgba");
    DisplayOutput out(plan(), stockDriver, diagnostics_);
    ASSERT_NE(out.plan().outputs[0].driver, kImageWriter);
    const auto film = filmFor(out.plan().layout);
    ASSERT_TRUE(out.write(*film, frame()));
    image::Image a, b;
    ASSERT_TRUE(image::read(name, a).ok());
    DisplayOutput plain(plan(), {}, diagnostics_);
    ASSERT_TRUE(plain.write(*film, frame()));
    ASSERT_TRUE(image::read(name, b).ok());
    image::Difference d;
    ASSERT_TRUE(image::compare(a, b, {}, d).ok());
    // the picture is noise, which JPEG hardly holds; here its colours have full resolution, in the image writer's not
    EXPECT_LT(d.rmse, extension == std::string("tif") ? 1e-9 : 0.15);
    EXPECT_EQ(a.channels.size(), extension == std::string("tif") ? 4u : 3u);
    EXPECT_EQ(a.channels[0].type, image::StoredType::UInt8);
  }
  EXPECT_EQ(diagnostics_.warnings(), 0u) << "alpha is not missed in a JPEG";
}

TEST_F(Displays, TiffHoldsDataAsFloats) {
  display(path("a.tif"), "tiff", "Ci,a,z,P");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  ASSERT_TRUE(out.write(*film, frame()));
  image::Image a;
  ASSERT_TRUE(image::read(path("a.tif"), a).ok());
  const image::Image exact = pictureOf(*film, out.plan().outputs[0], {});
  ASSERT_EQ(a.channels.size(), exact.channels.size());
  EXPECT_EQ(a.channels[0].type, image::StoredType::Float);
  EXPECT_EQ(a.pixels, exact.pixels);
  EXPECT_EQ(diagnostics_.warnings(), 0u);
  scene_.displays[0].params.set(text("format", "uint16"));
  DisplayOutput small(plan(), stockDriver, diagnostics_);
  ASSERT_TRUE(small.write(*film, frame()));
  ASSERT_TRUE(image::read(path("a.tif"), a).ok());
  EXPECT_EQ(a.channels[0].type, image::StoredType::UInt16);
  EXPECT_EQ(diagnostics_.count("DISPLAY-CHANNELS"), 1u);
}

TEST_F(Displays, FormatsThatCannotHoldTheChannelsSayWhichAreMissing) {
  std::vector<std::string> lines;
  Diagnostics d([&](const std::string& line, Severity) { lines.push_back(line); });
  for (const char* extension : {"png", "jpg"}) {
    lines.clear();
    scene_.displays.clear();
    display(path(std::string("a.") + extension), extension, "z,Ci,a,P");
    Diagnostics fresh([&](const std::string& line, Severity) { lines.push_back(line); });
    DisplayOutput out(planDisplays(scene_, {}, stockDriver, fresh), stockDriver, fresh);
    ASSERT_TRUE(out.write(*filmFor(out.plan().layout), frame()));
    ASSERT_EQ(lines.size(), 1u) << lines[0] << "\n" << lines.back();
    EXPECT_NE(lines[0].find("DISPLAY-CHANNELS"), std::string::npos) << lines[0];
    EXPECT_NE(lines[0].find("cannot hold 4 channels"), std::string::npos) << lines[0];
    image::Image a;
    ASSERT_TRUE(image::read(path(std::string("a.") + extension), a).ok());
    EXPECT_EQ(a.channels.size(), extension == std::string("png") ? 4u : 3u) << "the colour, wherever it stands";
  }
}

TEST_F(Displays, AFullDiskAtASnapshotIsAWarning) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("exrpixeltype", "float"));
  std::ofstream(path("a.exr")) << "old";
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit full = before;
  full.rlim_cur = 500;
  setrlimit(RLIMIT_FSIZE, &full);
  out.snapshot(*film, frame());
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(diagnostics_.errors(), 0u);
  EXPECT_EQ(diagnostics_.count("DISPLAY-SNAPSHOT"), 1u);
  EXPECT_EQ(std::filesystem::file_size(path("a.exr")), 3u);
  EXPECT_TRUE(out.write(*film, frame())) << "with space again the picture is there";
}

TEST_F(Displays, WhatCannotBeWrittenIsAnErrorAndTheOthersAreWritten) {
  display(path("no/such/a.exr"), "openexr", "rgba");
  display("+" + path("b.png"), "png", "rgba");
  display("+" + path("c.tif"), "tiff", "rgba");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  EXPECT_FALSE(out.probe());
  EXPECT_FALSE(out.write(*film, frame()));
  EXPECT_EQ(diagnostics_.count("DISPLAY-WRITE"), 2u);
  EXPECT_EQ(out.written(), (Names{path("b.png"), path("c.tif")}));
}

TEST_F(Displays, AFullDiskKeepsTheOldPicture) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("exrpixeltype", "float"));
  display("+" + path("b.png"), "png", "rgba");
  std::ofstream(path("a.exr")) << "old";
  std::ofstream(path("b.png")) << "old";
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit full = before;
  full.rlim_cur = 500;
  setrlimit(RLIMIT_FSIZE, &full);
  const bool ok = out.write(*film, frame());
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_FALSE(ok);
  EXPECT_EQ(diagnostics_.count("DISPLAY-WRITE"), 2u);
  int files = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(folder_)) ++files;
  EXPECT_EQ(files, 2) << "no temporary is left";
  EXPECT_EQ(std::filesystem::file_size(path("a.exr")), 3u);
  EXPECT_EQ(std::filesystem::file_size(path("b.png")), 3u);
}

TEST_F(Displays, ABadParameterOfADriverIsAnErrorOfThatPictureOnly) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("compression", "magic"));
  display("+" + path("b.exr"), "openexr", "rgba").params.set(integer("compression", {3}));
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  EXPECT_FALSE(out.write(*filmFor(out.plan().layout), frame()));
  EXPECT_EQ(diagnostics_.count("DISPLAY-WRITE"), 1u);
  EXPECT_EQ(diagnostics_.count("DISPLAY-PARAMETER"), 1u);
  EXPECT_EQ(out.written(), Names{path("b.exr")});
}

TEST_F(Displays, MergedPartsGiveTheUnsplitPicture) {
  display(path("beauty.exr"), "openexr", "Ci,a,z,P").params.set(text("exrpixeltype", "float"));
  display("+" + path("look.png"), "png", "rgba");
  const DisplayPlan p = plan();
  const auto samples = test::randomSamples(p.layout, {0, 0, 24, 20}, 8, 4);
  const auto part = [&](uint32_t begin, uint32_t end) {
    auto film = test::makeFilm(24, 20, p.layout);
    std::vector<int> order;
    for (int i = 0; i < samples.size(); ++i)
      if (samples.index[size_t(i)] >= begin && samples.index[size_t(i)] < end) order.push_back(i);
    samples.addTo(*film, order, 0, order.size());
    return film;
  };
  ShardInfo info;
  info.sceneHash = "cafe";
  info.outputs = outputsToJson(p, frame());
  info.ranges = {{0, 3}};
  ASSERT_TRUE(writeShard(path("1.exr"), *part(0, 3), info).ok());
  info.ranges = {{3, 8}};
  ASSERT_TRUE(writeShard(path("2.exr"), *part(3, 8), info).ok());

  DisplayOutput direct(p, stockDriver, diagnostics_);
  ASSERT_TRUE(direct.write(*part(0, 8), frame()));
  const ToolResult merged =
      mergeParts({path("2.exr"), path("1.exr")}, path("merged.exr"), false, stockDriver, {}, diagnostics_);
  ASSERT_EQ(merged.exitCode, 0) << lines_.back();
  const ToolResult same = diffImages(path("beauty.exr"), path("merged.exr"), {}, {}, 1, diagnostics_);
  EXPECT_EQ(same.exitCode, 0) << same.text;
  EXPECT_NE(same.text.find("identical in every bit"), std::string::npos) << same.text;
  image::Image picture;
  ASSERT_TRUE(image::readHeader(path("merged.exr"), picture).ok());
  EXPECT_EQ(std::get<std::string>(picture.metadata.at("sampleRange")), "0:8");
  EXPECT_EQ(std::get<image::Matrix44>(picture.metadata.at("worldtocamera"))[12], 5.0f);

  EXPECT_EQ(mergeParts({path("1.exr")}, path("kept.exr"), true, stockDriver, {}, diagnostics_).exitCode, 0);
  EXPECT_TRUE(isShard(path("kept.exr")));
  EXPECT_NE(imageInfo(path("kept.exr"), diagnostics_).text.find("samples: 0:3"), std::string::npos);
  EXPECT_EQ(mergeParts({path("1.exr"), path("1.exr")}, path("x.exr"), false, stockDriver, {}, diagnostics_).exitCode,
            kToolUnreadable);
  EXPECT_EQ(mergeParts({path("merged.exr")}, path("x.exr"), false, stockDriver, {}, diagnostics_).exitCode,
            kToolUnreadable);
  EXPECT_EQ(
      mergeParts({path("1.exr"), path("2.exr")}, path("no/x.exr"), false, stockDriver, {}, diagnostics_).exitCode,
      kToolUnwritable);
  EXPECT_EQ(mergeParts({path("2.exr")}, path("gap.exr"), false, stockDriver, {}, diagnostics_).exitCode, 0);
  EXPECT_EQ(diagnostics_.count("FILM-SHARD-GAP"), 1u);
  ShardInfo lying = info;
  for (const char* outputs : {"", "{}", "{\"outputs\":[{}]}", "[1,2", "null"}) {
    lying.outputs = outputs;
    ASSERT_TRUE(writeShard(path("lie.exr"), *part(3, 8), lying).ok());
    EXPECT_EQ(mergeParts({path("lie.exr")}, path("x.exr"), false, stockDriver, {}, diagnostics_).exitCode,
              kToolUnreadable);
  }
}

// Names that are no Unicode and numbers that are none travel with a part; what is altered is refused.
TEST_F(Displays, WhatAPartKnowsOfItsPicturesComesBack) {
  const std::string odd = "p\xe9 \"x\"";
  scene::Display& d = display(odd + ".exr", "openexr", "rgba");
  scene::Parameter p;
  p.name = "exrheader_" + odd;
  p.floats = {INFINITY, -1, 0.1f};
  d.params.set(p);
  d.params.set(text("exrheader_who", odd.c_str()));
  d.params.set(integer("quantize", {0, 200, 0, 255}));
  display("n", "null", "Ci,a,z");
  auto filter = std::make_shared<scene::Node>();
  filter->kind = "DisplayFilter";
  filter->plugin = "PxrBackgroundDisplayFilter";
  filter->handle = odd;
  filter->params.set(text("aov", odd.c_str()));
  scene_.displayFilters = {filter};
  DisplayPlan part = planDisplays(scene_, {{}, false, false, true}, stockDriver, diagnostics_);
  part.texturePath = {odd, "b"};
  FrameMetadata f = frame(), g;
  f.worldToNdc.emplace();
  (*f.worldToNdc)[5] = -0.1f;
  f.screenWindow = {0.1f, -0.2f, 0.3f};
  DisplayPlan back;
  const image::Status status = outputsFromJson(outputsToJson(part, f), part.layout, back, g);
  ASSERT_TRUE(status.ok()) << status.what;
  ASSERT_EQ(back.outputs.size(), 1u);
  const Output &a = part.outputs[0], &b = back.outputs[0];
  EXPECT_EQ(b.file, a.file);
  EXPECT_EQ(b.driver, a.driver);
  EXPECT_TRUE(b.isBeauty);
  EXPECT_EQ(names(b), names(a));
  EXPECT_EQ(b.channels[0].values, a.channels[0].values);
  ASSERT_EQ(b.params.size(), a.params.size());
  EXPECT_EQ(b.params.find(p.name)->floats, p.floats);
  EXPECT_EQ(b.params.find("exrheader_who")->strings, Names{odd});
  ASSERT_EQ(back.displayFilters.size(), 1u);
  EXPECT_EQ(back.displayFilters[0]->plugin, filter->plugin);
  EXPECT_EQ(back.displayFilters[0]->handle, odd);
  EXPECT_EQ(back.displayFilters[0]->params.find("aov")->strings, Names{odd});
  EXPECT_EQ(back.texturePath, part.texturePath);
  EXPECT_EQ(g.worldToNdc, f.worldToNdc);
  EXPECT_EQ(g.screenWindow, f.screenWindow);
  EXPECT_EQ(back.pixelAspect, part.pixelAspect);

  // -o of a whole render and -o of a merge mean the same picture, written or not
  scene_.displays.erase(scene_.displays.begin());
  for (const char* mode : {"Ci,a,z", "z"}) {
    scene_.displays[0].mode = mode;
    const DisplayPlan whole = plan("o.exr");
    DisplayPlan merged = planDisplays(scene_, {{}, false, false, true}, stockDriver, diagnostics_);
    EXPECT_TRUE(merged.outputs.empty());
    ASSERT_TRUE(outputsFromJson(outputsToJson(merged, f), merged.layout, back, g).ok());
    redirectPrimary(back, "o.exr", diagnostics_);
    ASSERT_EQ(back.outputs.size(), 1u) << mode;
    ASSERT_EQ(whole.outputs.size(), 1u) << mode;
    EXPECT_EQ(back.outputs[0].file, "o.exr");
    EXPECT_EQ(back.outputs[0].driver, "openexr");
    EXPECT_EQ(names(back.outputs[0]), names(whole.outputs[0])) << mode;
  }
}

TEST_F(Displays, NoPartIsWrittenOver) {
  display(path("beauty.exr"), "openexr", "rgba");
  const DisplayPlan p = plan();
  ShardInfo info;
  info.outputs = outputsToJson(p, frame());
  info.ranges = {{0, 4}};
  ASSERT_TRUE(writeShard(path("beauty.exr"), *filmFor(p.layout), info).ok());
  std::filesystem::create_symlink(path("beauty.exr"), path("link.exr"));
  const auto size = std::filesystem::file_size(path("beauty.exr"));
  const auto merge = [&](const char* output, bool keep) {
    return mergeParts({path("beauty.exr")}, output[0] ? path(output) : "", keep, stockDriver, {}, diagnostics_)
        .exitCode;
  };
  EXPECT_EQ(merge("", false), kToolBadCommand) << "the picture has the part's name";
  EXPECT_EQ(merge("beauty.exr", false), kToolBadCommand);
  EXPECT_EQ(merge("link.exr", false), kToolBadCommand);
  EXPECT_EQ(merge("./beauty.exr", true), kToolBadCommand);
  EXPECT_EQ(diagnostics_.count("FILM-MERGE-OVERWRITE"), 4u);
  EXPECT_TRUE(isShard(path("beauty.exr")));
  EXPECT_EQ(std::filesystem::file_size(path("beauty.exr")), size);
  EXPECT_EQ(merge("picture.exr", false), kToolOk);
}

TEST_F(Displays, DiffJudgesByTheLimitsGiven) {
  image::Image a({0, 0, 4, 4}, {{"R", image::StoredType::Float}});
  image::Image b = a;
  b.pixels[5] = 0.5f;
  ASSERT_TRUE(image::write(path("a.exr"), a).ok());
  ASSERT_TRUE(image::write(path("b.exr"), b).ok());
  const auto run = [&](const DiffLimits& l) {
    return diffImages(path("a.exr"), path("b.exr"), l, {}, 1, diagnostics_).exitCode;
  };
  DiffLimits l;
  EXPECT_EQ(run(l), kToolDiffers);
  l.maximum = 0.5;
  EXPECT_EQ(run(l), kToolOk);
  l.rmse = 0.1;
  EXPECT_EQ(run(l), kToolDiffers) << "RMSE is 0.125";
  l.rmse = 0.13;
  l.differingPixels = 0.05;
  EXPECT_EQ(run(l), kToolDiffers);
  l.differingPixels = 0.0625;
  EXPECT_EQ(run(l), kToolOk);
  const ToolResult r = diffImages(path("a.exr"), path("b.exr"), {}, path("d.exr"), 4, diagnostics_);
  EXPECT_NE(r.text.find("maximum 0.5 at 1 1 in R"), std::string::npos) << r.text;
  image::Image d;
  ASSERT_TRUE(image::read(path("d.exr"), d).ok());
  EXPECT_EQ(d.pixels[5], 2.0f);
  EXPECT_EQ(diffImages(path("a.exr"), path("none.exr"), {}, {}, 1, diagnostics_).exitCode, kToolUnreadable);
  EXPECT_EQ(diffImages(path("a.exr"), path("b.exr"), {}, path("no/d.exr"), 1, diagnostics_).exitCode,
            kToolUnwritable);
  b.pixels[5] = NAN;
  ASSERT_TRUE(image::write(path("b.exr"), b).ok());
  DiffLimits byRmse, byMaximum;
  byRmse.rmse = 1;
  byMaximum.maximum = 1;
  for (const DiffLimits& m : {byRmse, byMaximum, DiffLimits{}}) EXPECT_EQ(run(m), kToolDiffers);
}

TEST_F(Displays, InfoTellsChannelsAndMetadata) {
  display(path("a.exr"), "openexr", "rgbaz");
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  ASSERT_TRUE(out.write(*filmFor(out.plan().layout, {1, 1, 9, 9}), frame()));
  const ToolResult r = imageInfo(path("a.exr"), diagnostics_);
  EXPECT_EQ(r.exitCode, 0);
  for (const char* part : {"openexr picture, 8 x 8, 5 channels", "data window: 1 1 to 9 9", "channel Z (float)",
                           "sceneHash: cafe", "colorSpace: linear Rec.709"})
    EXPECT_NE(r.text.find(part), std::string::npos) << part << "\n" << r.text;
  EXPECT_EQ(imageInfo(path("none"), diagnostics_).exitCode, kToolUnreadable);
}

// Drivers declare what they take; the declaration is what scenes, the manual and these defaults read.
TEST(StockDrivers, DescriptorsAreComplete) {
  for (const char* name : {"openexr", "png"}) {
    const Descriptor* d = stockDriver(name);
    EXPECT_EQ(d->abiVersion, kAbiVersion);
    EXPECT_EQ(d->descriptorBytes, sizeof(Descriptor));
    EXPECT_EQ(d->kind, Kind::Display);
    EXPECT_STREQ(d->name, name);
    ASSERT_EQ(d->tableCount, 1u);
    EXPECT_TRUE(d->tables[0].functions && d->create && d->destroy);
    for (uint32_t i = 0; i < d->paramCount; ++i) EXPECT_GT(std::strlen(d->params[i].name), 0u);
  }
}

}  // namespace
}  // namespace kinora::film
