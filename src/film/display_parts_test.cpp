// Proves that parts of a frame know all that their pictures take, that merging and comparing tell what is there and
// write over nothing, and that files of integers say what their codes are. It misses how other programs read the
// files.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "film/display_testing.h"
#include "film/tools.h"
#include "image/compare.h"
#include "image/read_write.h"

namespace kinora::film {
namespace {

using test::integer;
using test::stockDriver;
using test::text;

class PartsAndFiles : public test::DisplayTest {};

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
TEST_F(PartsAndFiles, PngHasStraightAlphaAndSaysWhatItsCodesAre) {
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
        // what is seen where nothing covers is behind the others too
        if (!isTiff && a > 0) v = std::min(1.0, std::max(0.0, v - (1 - a) * double(pixels[1][c])) / a);
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

TEST_F(PartsAndFiles, MergedPartsGiveTheUnsplitPicture) {
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
  EXPECT_EQ(std::get<int>(picture.metadata.at("complete")), 1);
  ASSERT_TRUE(image::readHeader(path("gap.exr"), picture).ok());
  EXPECT_EQ(std::get<int>(picture.metadata.at("complete")), 0);
  ShardInfo lying = info;
  for (const char* outputs : {"", "{}", "{\"outputs\":[{}]}", "[1,2", "null"}) {
    lying.outputs = outputs;
    ASSERT_TRUE(writeShard(path("lie.exr"), *part(3, 8), lying).ok());
    EXPECT_EQ(mergeParts({path("lie.exr")}, path("x.exr"), false, stockDriver, {}, diagnostics_).exitCode,
              kToolUnreadable);
  }
}

// Names that are no Unicode and numbers that are none travel with a part; what is altered is refused.
TEST_F(PartsAndFiles, WhatAPartKnowsOfItsPicturesComesBack) {
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

TEST_F(PartsAndFiles, NoPartIsWrittenOver) {
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

TEST_F(PartsAndFiles, DiffJudgesByTheLimitsGiven) {
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
  image::Image infinite = a;
  infinite.pixels[5] = INFINITY;
  ASSERT_TRUE(image::write(path("infinite.exr"), infinite).ok());
  const auto runInfinite = [&](const DiffLimits& limits) {
    return diffImages(path("a.exr"), path("infinite.exr"), limits, {}, 1, diagnostics_).exitCode;
  };
  DiffLimits mean;
  mean.rmse = 0.1;
  EXPECT_EQ(runInfinite(mean), kToolDiffers) << "a mean over finite values";
  mean.rmse.reset();
  mean.relativeMse = 0.1;
  EXPECT_EQ(runInfinite(mean), kToolDiffers);
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

TEST_F(PartsAndFiles, InfoTellsChannelsAndMetadata) {
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

}  // namespace
}  // namespace kinora::film
