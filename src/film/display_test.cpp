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

#include "film/display_testing.h"
#include "film/tools.h"
#include "image/compare.h"
#include "image/read_write.h"

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

using test::integer;
using test::stockDriver;
using test::text;

class Displays : public test::DisplayTest {};

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
  scene_.displays.clear();
  display("a.exr", "null", "rgba");
  display("+a.exr", "it", "rgba");
  EXPECT_EQ(plan().outputs.size(), 1u) << "what is not written stands in for nothing";
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
      {"a.png", "framebuffer", "a.png", "png", 1},  // one message each
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
  EXPECT_EQ(fillFrame("####/a.##.exr", 12), "0012/a.12.exr") << "all of them";
}

TEST_F(Displays, ExrHoldsTheFilmsValuesAndMetadata) {
  for (const char* storage : {"scanline", "tiled"}) {
    scene_.displays.clear();
    scene::Display& d = display(path("a.exr"), "openexr", "Ci,a,z,P");
    d.params.set(text("storage", storage));
    d.params.set(text("exrpixeltype", "float"));
    d.params.set(text("compression", "zip"));
    d.params.set(text("exrheader_artist", "nobody"));
    scene::Parameter numbers = integer("exrheader_tile", {3, 4});
    d.params.set(numbers);
    numbers.name = "exrheader_place";
    numbers.type = scene::ValueType::Float;
    numbers.ints.clear();
    for (int i = 0; i < 16; ++i) numbers.floats.push_back(0.5f * float(i));
    d.params.set(numbers);
    numbers.name = "exrheader_plate";
    numbers.floats.resize(2);
    d.params.set(numbers);
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
    EXPECT_EQ(std::get<std::string>(back.metadata.at("tile")), "3 4");
    EXPECT_EQ(std::get<std::string>(back.metadata.at("plate")), "0 0.5");
    EXPECT_EQ(std::get<image::Matrix44>(back.metadata.at("place"))[13], 6.5f);
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
  for (const char* packing : {"zip", "deflate", "Deflate"}) {
    scene_.displays[0].params.set(text("compression", packing));
    DisplayOutput packed(plan(), stockDriver, diagnostics_);
    ASSERT_TRUE(packed.write(*film, frame()));
    ASSERT_TRUE(image::read(path("a.tif"), a).ok());
    EXPECT_EQ(std::get<std::string>(a.metadata.at("compression")), "zip") << packing;
  }
  EXPECT_EQ(diagnostics_.count("DISPLAY-PARAMETER"), 0u);
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

// While it lives no file may grow beyond 500 bytes.
class FullDisk {
 public:
  FullDisk() : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
    rlimit full = before_;
    full.rlim_cur = 500;
    setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(Displays, AFullDiskAtASnapshotIsAWarning) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("exrpixeltype", "float"));
  std::ofstream(path("a.exr")) << "old";
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  const auto film = filmFor(out.plan().layout);
  {
    const FullDisk full;
    out.snapshot(*film, frame());
  }
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
  {
    const FullDisk full;
    EXPECT_FALSE(out.write(*film, frame()));
  }
  EXPECT_EQ(diagnostics_.count("DISPLAY-WRITE"), 2u);
  int files = 0;
  for ([[maybe_unused]] const auto& e : std::filesystem::directory_iterator(folder_)) ++files;
  EXPECT_EQ(files, 2) << "no temporary is left";
  EXPECT_EQ(std::filesystem::file_size(path("a.exr")), 3u);
  EXPECT_EQ(std::filesystem::file_size(path("b.png")), 3u);
}

TEST_F(Displays, ABadParameterOfADriverGivesItsDefault) {
  display(path("a.exr"), "openexr", "rgba").params.set(text("compression", "magic"));
  display("+" + path("b.exr"), "openexr", "rgba").params.set(integer("compression", {3}));
  display("+" + path("c.exr"), "openexr", "rgba").params.set(text("compression", "PIZ"));
  DisplayOutput out(plan(), stockDriver, diagnostics_);
  EXPECT_TRUE(out.write(*filmFor(out.plan().layout), frame()));
  EXPECT_EQ(diagnostics_.count("DISPLAY-PARAMETER"), 2u);
  EXPECT_EQ(out.written(), (Names{path("a.exr"), path("b.exr"), path("c.exr")}));
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
