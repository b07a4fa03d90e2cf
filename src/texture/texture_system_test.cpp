// Proves where files are found and what is said about them, channels, wrap modes, mip levels, sRGB, atlases, damaged
// files, and that a lookup's value depends on nothing but its arguments. Prints the rate beside a plain loop over
// OpenImageIO. It does not prove OpenImageIO's filters.
#include "texture/texture_system.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/texture.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <thread>

#include "base/folder_test.h"
#include "texture/module/srgb_input.h"

namespace kinora {
namespace {
namespace fs = std::filesystem;
using Pixel = std::function<void(int x, int y, float* out)>;

// A scratch directory of its own, gone at the end.
class TextureTest : public test::FolderTest {
 protected:
  void write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type, const Pixel& pixel,
             bool prepared = false, const char* wrap = nullptr) const {
    OIIO::ImageSpec spec(width, height, channels, type);
    OIIO::ImageBuf image(spec);
    std::vector<float> value(size_t(channels), 0.f);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        pixel(x, y, value.data());
        image.setpixel(x, y, value.data());
      }
    fs::create_directories(fs::path(path(name)).parent_path());
    if (prepared) {
      OIIO::ImageSpec config;
      if (wrap) config.attribute("wrapmodes", wrap);
      ASSERT_TRUE(OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, image, path(name), config));
    } else {
      ASSERT_TRUE(image.write(path(name))) << image.geterror();
    }
  }
  void constant(const std::string& name, float v) const {
    write(name, 32, 32, 3, OIIO::TypeUInt8, [v](int, int, float* out) { out[0] = out[1] = out[2] = v; });
  }
  struct Rgba {
    float v[4];
  };
  static Rgba look(TextureSystem& t, int handle, float s, float tt, float radius = 0, const TextureOptions& o = {}) {
    Rgba r;
    float* const out[4] = {&r.v[0], &r.v[1], &r.v[2], &r.v[3]};
    const int32_t h = handle;
    t.lookup(&h, false, 1, &s, &tt, &radius, o, out);
    return r;
  }
  std::string said() const {
    std::string all;
    for (const Message& m : diagnostics_.messages()) all += m.str() + "\n";
    return all;
  }

  Diagnostics diagnostics_{[](const std::string&, Severity) {}};
  TextureSystem system_{diagnostics_};
};

TEST_F(TextureTest, FindsFilesAndSaysWhatItUsed) {
  constant("a/one.tif", 0.5f);
  constant("b/two.png", 1.f);
  system_.setSearchPath({path("a"), path("b")});
  EXPECT_NEAR(look(system_, system_.handle("one.tif", {}), 0.5f, 0.5f).v[0], 0.5f, 0.01f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 0u);
  // another machine's path, another extension, a Windows path
  EXPECT_NEAR(look(system_, system_.handle("/elsewhere/tex/two.tx", {{}, "pattern 'p'"}), 0.5f, 0.5f).v[0], 1, 0.01f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 1u);
  EXPECT_NE(said().find("pattern 'p'"), std::string::npos);
  EXPECT_NE(said().find("two.png' is used instead"), std::string::npos);
  EXPECT_GE(system_.handle("C:\\art\\one.tex", {}), 0);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 2u);
  // asked for again: the same handle, no more messages
  EXPECT_EQ(system_.handle("/elsewhere/tex/two.tx", {}), system_.handle("/elsewhere/tex/two.tx", {}));
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 2u);
}

// Authors keep textures below and beside the scene and told their renderers so elsewhere.
TEST_F(TextureTest, FoldersOfPicturesNearbyAreTheLastResort) {
  constant("scene/maps/below.png", 0.25f);
  constant("Textures/beside.tif", 0.75f);
  constant("other/hidden.tif", 0.75f);
  fs::create_directories(path("scene"));
  system_.setSearchPath({path("scene")});
  EXPECT_NEAR(look(system_, system_.handle("below.tx", {}), 0.5f, 0.5f).v[0], 0.25f, 0.01f);
  EXPECT_NEAR(look(system_, system_.handle("deep/beside.tif", {}), 0.5f, 0.5f).v[0], 0.75f, 0.01f);
  EXPECT_NE(said().find("below.png' is used instead"), std::string::npos) << said();
  EXPECT_LT(system_.handle("hidden.tif", {}), 0) << "its folder's name says nothing of pictures";
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 3u);
}

TEST_F(TextureTest, MissingFilesGiveTheMissingColour) {
  TextureOptions o;
  o.missingColor[0] = 0.1f, o.missingColor[1] = 0.2f, o.missingColor[2] = 0.3f, o.missingAlpha = 0.4f;
  const int h = system_.handle("nowhere.tx", {});
  for (int k = 0; k < 3; ++k) {
    const Rgba r = look(system_, h, 0.5f, 0.5f, 0, o);
    for (int c = 0; c < 4; ++c) EXPECT_FLOAT_EQ(r.v[c], 0.1f * float(c + 1));
  }
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 1u);
  EXPECT_EQ(look(system_, system_.handle("", {}), 0, 0, 0, o).v[3], 0.4f);
  EXPECT_EQ(look(system_, 12345, 0, 0, 0, o).v[3], 0.4f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 1u);
  EXPECT_EQ(system_.statistics().missingLookups, 5u);
}

// The default, magenta, is shown as squares of two greys, which blend into their mean where a lookup covers many.
TEST_F(TextureTest, MissingFilesWithoutAColourGiveGreySquares) {
  const auto squares = [&](TextureSystem& system, int h) {
    const float light = look(system, h, 0.06f, 0.06f).v[0], dark = look(system, h, 0.19f, 0.06f).v[0];
    EXPECT_NEAR(light, 0.36f, 1e-4f);
    EXPECT_NEAR(dark, 0.18f, 1e-4f);
    EXPECT_NEAR(look(system, h, -0.06f, 0.06f).v[0], dark, 1e-4f) << "below 0";
    EXPECT_NEAR(look(system, h, 0.19f, 0.19f).v[1], light, 1e-4f);
    EXPECT_NEAR(look(system, h, 0.33f, 0.06f, 2.f).v[2], 0.27f, 0.01f);
    EXPECT_NEAR(look(system, h, 1e20f, NAN).v[2], 0.27f, 0.01f);
    EXPECT_EQ(look(system, h, 0.06f, 0.06f).v[3], 1.f);
  };
  squares(system_, system_.handle("", {}));  // nothing has been opened yet
  squares(system_, system_.handle("nowhere.tx", {}));
}

TEST_F(TextureTest, DamagedFilesAreRefusedOrGiveTheMissingColour) {
  std::ofstream(path("empty.tif"));
  std::ofstream(path("words.png")) << "this is no picture";
  fs::create_directories(path("folder.tx"));
  for (const char* name : {"empty.tif", "words.png", "folder.tx"})
    EXPECT_FLOAT_EQ(look(system_, system_.handle(path(name), {}), 0.5f, 0.5f).v[1], 0.27f) << name;
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-READ"), 2u);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 1u);  // a folder is no file
  // headers that promise 1e5 x 1e5 pixels in a few hundred bytes
  std::ofstream(path("liar.ppm"), std::ios::binary) << "P6\n100000 100000\n255\n" << std::string(300, 'x');
  std::string bmp(54, '\0');
  const uint32_t side = 100000, offset = 54, header = 40;
  bmp[0] = 'B', bmp[1] = 'M';
  std::memcpy(&bmp[10], &offset, 4), std::memcpy(&bmp[14], &header, 4);
  std::memcpy(&bmp[18], &side, 4), std::memcpy(&bmp[22], &side, 4);
  bmp[26] = 1, bmp[28] = 24;
  std::ofstream(path("liar.bmp"), std::ios::binary) << bmp << std::string(300, 'x');
  for (const char* name : {"liar.ppm", "liar.bmp"}) {
    EXPECT_EQ(system_.handle(path(name), {}), TextureSystem::kNoTexture) << name;
    EXPECT_EQ(system_.image(path(name), -1, {}), nullptr) << name;
  }
  EXPECT_LT(system_.statistics().cacheBytes, 1u << 24);
  // the library that reads volumes ends the program at damaged ones: it is not asked, whatever the name says
  for (const char* name : {"cloud.vdb", "cloud.tif"}) {
    std::ofstream(path(name), std::ios::binary) << std::string(" BDV\0\0\0\0", 8) << std::string(300, '\1');
    EXPECT_EQ(system_.handle(path(name), {}), TextureSystem::kNoTexture) << name;
    EXPECT_EQ(system_.find(path(name)), "") << name;
    EXPECT_NE(diagnostics_.messages().back().what.find("it holds volumes (OpenVDB), no picture"), std::string::npos)
        << diagnostics_.messages().back().what;
  }
}

TEST_F(TextureTest, TruncatedFilesGiveWhatTheyHold) {
  write("whole.tif", 256, 256, 3, OIIO::TypeUInt8, [](int x, int y, float* out) {
    const uint32_t h = uint32_t(x * 7919 + y * 104729) * 2654435761u;  // does not compress
    out[0] = float(h >> 24) / 255, out[1] = float(h >> 16 & 255) / 255, out[2] = 1;
  });
  std::ifstream in(path("whole.tif"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::ifstream();
  write("half.exr", 256, 256, 3, OIIO::TypeHalf, [](int, int, float* out) { out[0] = out[1] = out[2] = 0.25f; });
  std::ifstream exr(path("half.exr"), std::ios::binary);
  std::string exrBytes((std::istreambuf_iterator<char>(exr)), {});
  std::ofstream(path("cut.tif"), std::ios::binary) << bytes.substr(0, bytes.size() * 2 / 3);
  std::ofstream(path("cut.exr"), std::ios::binary) << exrBytes.substr(0, exrBytes.size() / 2);
  for (const char* name : {"cut.tif", "cut.exr"}) {
    const int h = system_.handle(path(name), {});
    for (int k = 0; k < 100; ++k) {
      const Rgba a = look(system_, h, 0.5f, float(k) / 100, 0), b = look(system_, h, 0.5f, float(k) / 100, 0);
      EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0);  // the same answer each time
      for (float v : a.v) EXPECT_TRUE(std::isfinite(v));
    }
    system_.image(path(name), 0, {});
  }
  EXPECT_GE(diagnostics_.count("ASSET-TEXTURE-READ"), 1u);
}

TEST_F(TextureTest, PtexIsRefusedByName) {
  std::ofstream(path("skin.ptx"), std::ios::binary) << "Ptex" << std::string(300, '\1');
  EXPECT_EQ(system_.handle(path("skin.ptx"), {}), TextureSystem::kNoTexture);
  ASSERT_EQ(diagnostics_.count("ASSET-TEXTURE-READ"), 1u);
  EXPECT_NE(diagnostics_.messages().back().what.find("it is a Ptex file"), std::string::npos)
      << diagnostics_.messages().back().what;
}

// Gone or shorter between two lookups: what the cache still holds stays, the rest is the missing colour, told once.
TEST_F(TextureTest, FilesThatVanishOrShrinkDuringAFrame) {
  const Pixel noise = [](int x, int y, float* out) {
    const uint32_t h = uint32_t(x * 7919 + y * 104729) * 2654435761u;
    out[0] = out[1] = out[2] = 0.5f + float(h >> 24) / 1024;
  };
  for (const char* name : {"gone.tx", "short.tx"}) write(name, 1024, 1024, 3, OIIO::TypeUInt8, noise, true);
  for (int k = 0; k < 120; ++k) constant("other." + std::to_string(1001 + k) + ".tif", 0.5f);
  system_.setSearchPath({folder_.string()});
  TextureOptions o;
  o.missingColor[0] = 9.f;
  const int gone = system_.handle("gone.tx", {}), shorter = system_.handle("short.tx", {}),
            others = system_.handle("other.<UDIM>.tif", {});
  ASSERT_GE(gone, 0);
  ASSERT_GE(shorter, 0);
  const float before = look(system_, gone, 0.01f, 0.01f, 0, o).v[0];
  // of a hundred files that are open, these are closed
  for (int k = 0; k < 120; ++k) look(system_, others, float(k % 10) + 0.5f, 0.5f - float(k / 10));
  fs::remove(path("gone.tx"));
  fs::resize_file(path("short.tx"), 300);
  EXPECT_EQ(look(system_, gone, 0.01f, 0.01f, 0, o).v[0], before);
  for (const int h : {gone, shorter})
    for (int k = 0; k < 64; ++k) {
      const float v = look(system_, h, float(k % 8) / 8 + 0.06f, float(k / 8) / 8 + 0.06f, 0, o).v[0];
      EXPECT_TRUE(v == 9.f || (v >= 0.5f && v <= 0.75f)) << k << ": " << v;
    }
  EXPECT_EQ(look(system_, gone, 0.9f, 0.9f, 0, o).v[0], 9.f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-READ"), 2u) << said();
}

// Far more files than a process may open.
TEST_F(TextureTest, AnAtlasOfAThousandFiles) {
  write("first.tif", 32, 32, 3, OIIO::TypeUInt8, [](int, int, float* out) { out[0] = out[1] = out[2] = 0.4f; });
  for (int k = 0; k < 1000; ++k) fs::copy_file(path("first.tif"), path("skin." + std::to_string(1001 + k) + ".tif"));
  rlimit was{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &was), 0);
  rlimit few = was;
  few.rlim_cur = 160;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  system_.setSearchPath({folder_.string()});
  const int skin = system_.handle("skin.<UDIM>.tif", {});
  for (int round = 0; round < 2; ++round)
    for (int k = 0; k < 1000; ++k) {
      const float v = look(system_, skin, float(k % 10) + 0.5f, 0.5f - float(k / 10)).v[0];
      EXPECT_NEAR(v, 0.4f, 0.005f) << k;
    }
  setrlimit(RLIMIT_NOFILE, &was);
  EXPECT_EQ(said().find("ASSET-TEXTURE-READ"), std::string::npos) << said();
}

// The least cache has room for a tile; what goes is read again, and counted.
TEST_F(TextureTest, ACacheSmallerThanATileReadsAgain) {
  const Pixel noise = [](int x, int y, float* out) {
    out[0] = out[1] = out[2] = float((x * 13 + y * 7) & 255) / 255;
  };
  write(
      "big.tif", 2048, 2048, 4, OIIO::TypeFloat,
      [&](int x, int y, float* out) {
        noise(x, y, out);
        out[3] = 1;
      },
      true);
  TextureSystem small(diagnostics_), large(diagnostics_);
  small.setCacheLimit(1);
  const int a = small.handle(path("big.tif"), {}), b = large.handle(path("big.tif"), {});
  for (int round = 0; round < 3; ++round)
    for (int k = 0; k < 1024; ++k) {
      const float s = float(k % 32) / 32 + 0.01f, t = float(k / 32) / 32 + 0.01f;
      const Rgba x = look(small, a, s, t), y = look(large, b, s, t);
      EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0);
    }
  const TextureStatistics s = small.statistics(), l = large.statistics();
  EXPECT_GT(s.tilesAgain, 100u);
  EXPECT_EQ(l.tilesAgain, 0u);
  EXPECT_LT(s.cacheBytes, 20u << 20);
  EXPECT_GT(l.cacheBytes, 60u << 20);
  ASSERT_EQ(s.largest.size(), 1u);
  EXPECT_EQ(s.largest[0].path, path("big.tif"));
  EXPECT_GT(s.largest[0].bytesRead, l.largest[0].bytesRead);
}

// Values of files with and without a folder for their levels, in which nothing is left half made.
TEST_F(TextureTest, LevelsAreKeptInAFolder) {
  const auto noise = [](uint32_t seed) {
    return [seed](int x, int y, float* out) {
      for (int c = 0; c < 4; ++c) {
        const uint32_t h = (uint32_t(x * 7919 + y * 104729 + c * 31) + seed) * 2654435761u;
        out[c] = float(h >> 16 & 0xffff) / 65535;
      }
    };
  };
  write("bytes.png", 150, 70, 4, OIIO::TypeUInt8, noise(1));
  write("shorts.tif", 130, 200, 4, OIIO::TypeUInt16, noise(2));
  write("halves.exr", 90, 129, 4, OIIO::TypeHalf, noise(3));
  write("floats.exr", 65, 64, 4, OIIO::TypeFloat, noise(4));
  const char* const files[] = {"bytes.png", "shorts.tif", "halves.exr", "floats.exr"};
  const std::string folder = path("kept/levels");
  const auto valuesOf = [&](const std::string& in) {
    TextureSystem t(diagnostics_);
    if (!in.empty()) t.setLevelFolder(in);
    std::vector<float> all;
    for (const char* name : files)
      for (const int linearize : {0, 1}) {
        TextureOptions o;
        o.linearize = linearize;
        const int h = t.handle(path(name), {});
        for (int k = 0; k < 400; ++k) {
          const Rgba r = look(t, h, float(k % 20) / 19, float(k / 20) / 19, k % 7 ? std::exp2(-float(k % 9)) : 0, o);
          all.insert(all.end(), r.v, r.v + 4);
        }
      }
    return all;
  };
  const auto list = [&] {
    std::map<std::string, fs::file_time_type> there;
    for (const auto& e : fs::directory_iterator(folder)) there[e.path().filename().string()] = e.last_write_time();
    return there;
  };
  const std::vector<float> expected = valuesOf("");
  EXPECT_TRUE(valuesOf(folder) == expected);
  const auto made = list();
  EXPECT_EQ(made.size(), 16u);  // four files, plain and decoded, the finest level and the coarser ones
  for (const auto& [name, time] : made) EXPECT_NE(name[0], '.') << name;
  EXPECT_TRUE(valuesOf(folder) == expected);
  EXPECT_TRUE(list() == made);  // not again
  // cut short: made again
  for (const auto& [name, time] : made) fs::resize_file(fs::path(folder) / name, 100);
  EXPECT_TRUE(valuesOf(folder) == expected);
  // another picture of the same name
  write("bytes.png", 150, 70, 4, OIIO::TypeUInt8, noise(9));
  fs::last_write_time(path("bytes.png"), fs::last_write_time(path("bytes.png")) + std::chrono::seconds(5));
  const std::vector<float> changed = valuesOf("");
  EXPECT_FALSE(changed == expected);
  EXPECT_TRUE(valuesOf(folder) == changed);
  // several at once
  fs::remove_all(folder);
  std::vector<std::thread> threads;
  std::atomic<int> equal{0};
  for (int k = 0; k < 4; ++k) threads.emplace_back([&] { equal += valuesOf(folder) == changed; });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(equal, 4);
  EXPECT_EQ(list().size(), 16u);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-FOLDER"), 0u) << said();
  // where nothing can be written
  std::ofstream(path("file")) << "no folder";
  EXPECT_TRUE(valuesOf(path("file")) == changed);
  EXPECT_GE(diagnostics_.count("ASSET-TEXTURE-FOLDER"), 1u);
}

TEST_F(TextureTest, ChannelsBecomeColourAndAlpha) {
  write("grey.tif", 8, 8, 1, OIIO::TypeFloat, [](int, int, float* o) { o[0] = 0.25f; });
  write("greyAlpha.tif", 8, 8, 2, OIIO::TypeFloat, [](int, int, float* o) { o[0] = 0.25f, o[1] = 0.5f; });
  write("rgba.tif", 8, 8, 4, OIIO::TypeFloat, [](int, int, float* o) { o[0] = 1, o[1] = 2, o[2] = 3, o[3] = 0.75f; });
  const Rgba grey = look(system_, system_.handle(path("grey.tif"), {}), 0.5f, 0.5f);
  EXPECT_FLOAT_EQ(grey.v[0], 0.25f);
  EXPECT_FLOAT_EQ(grey.v[2], 0.25f);
  EXPECT_FLOAT_EQ(grey.v[3], 1.f);
  const Rgba two = look(system_, system_.handle(path("greyAlpha.tif"), {}), 0.5f, 0.5f);
  EXPECT_FLOAT_EQ(two.v[1], 0.25f);
  EXPECT_FLOAT_EQ(two.v[3], 0.5f);
  const int h = system_.handle(path("rgba.tif"), {});
  EXPECT_FLOAT_EQ(look(system_, h, 0.5f, 0.5f).v[1], 2.f);
  EXPECT_FLOAT_EQ(look(system_, h, 0.5f, 0.5f).v[3], 0.75f);
  TextureOptions o;
  o.firstChannel = 1;
  EXPECT_FLOAT_EQ(look(system_, h, 0.5f, 0.5f, 0, o).v[0], 2.f);
  EXPECT_FLOAT_EQ(look(system_, h, 0.5f, 0.5f, 0, o).v[3], 1.f);
  o.firstChannel = 9;
  EXPECT_FLOAT_EQ(look(system_, h, 0.5f, 0.5f, 0, o).v[1], 0.27f);  // the missing colour
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-CHANNEL"), 1u);
}

TEST_F(TextureTest, WrapModes) {
  write("ramp.tif", 64, 64, 3, OIIO::TypeFloat,
        [](int x, int y, float* o) { o[0] = float(x), o[1] = float(y), o[2] = 1; });
  write(
      "black.tx", 64, 64, 3, OIIO::TypeFloat, [](int, int, float* o) { o[0] = o[1] = o[2] = 1; }, true, "black");
  const int h = system_.handle(path("ramp.tif"), {});
  TextureOptions o;
  o.filter = 0;
  constexpr float kQuarter = 16.5f / 64, kThree = 48.5f / 64, k3q = 3 + kQuarter,
                  kMinus = kThree - 1;  // centres of texels
  EXPECT_FLOAT_EQ(look(system_, h, kQuarter, kThree, 0, o).v[0], 16.f);
  EXPECT_FLOAT_EQ(look(system_, h, kQuarter, kThree, 0, o).v[1], 48.f);  // t counts down from the top row
  EXPECT_FLOAT_EQ(look(system_, h, k3q, kMinus, 0, o).v[0], 16.f);       // the file says nothing: periodic
  EXPECT_FLOAT_EQ(look(system_, h, k3q, kMinus, 0, o).v[1], 48.f);
  o.wrapS = o.wrapT = 2;
  EXPECT_FLOAT_EQ(look(system_, h, 3.25f, -2.f, 0, o).v[0], 63.f);
  EXPECT_FLOAT_EQ(look(system_, h, 3.25f, -2.f, 0, o).v[1], 0.f);
  o.wrapS = o.wrapT = 0;
  EXPECT_FLOAT_EQ(look(system_, h, 3.25f, 0.5f, 0, o).v[2], 0.f);
  const int black = system_.handle(path("black.tx"), {});
  EXPECT_FLOAT_EQ(look(system_, black, 1.5f, 0.5f).v[0], 0.f);  // as the file says
  o.wrapS = o.wrapT = 3;
  EXPECT_FLOAT_EQ(look(system_, black, 1.5f, 0.5f, 0, o).v[0], 1.f);
  // numbers that no texture has
  for (float x : {1e30f, -1e30f, std::nanf(""), HUGE_VALF})
    for (int wrap : {0, 2, 3}) {
      o.wrapS = o.wrapT = wrap;
      for (float v : look(system_, h, x, x, x, o).v) EXPECT_TRUE(std::isfinite(v)) << x;
    }
}

TEST_F(TextureTest, LevelFollowsTheFootprint) {
  // black and white texels: fine lookups see one of them, a footprint of several texels sees their mean
  const Pixel checker = [](int x, int y, float* o) { o[0] = o[1] = o[2] = float((x + y) & 1); };
  write("plain.tif", 256, 256, 3, OIIO::TypeUInt8, checker);
  write("ready.tx", 256, 256, 3, OIIO::TypeUInt8, checker, true, "periodic");
  for (const char* name : {"plain.tif", "ready.tx"}) {
    const int h = system_.handle(path(name), {});
    for (int filter : {1, 2, 3, 6, 7}) {
      TextureOptions o;
      o.filter = filter;
      EXPECT_NEAR(look(system_, h, 0.5f, 0.5f, 8.f / 256, o).v[0], 0.5f, 0.01f) << name << " " << filter;
      EXPECT_NEAR(look(system_, h, 0.5f, 0.5f, 2.f, o).v[0], 0.5f, 0.01f) << name << " " << filter;
    }
    TextureOptions o;
    EXPECT_NEAR(look(system_, h, 100.5f / 256, 101.5f / 256, 0, o).v[0], 1.f, 1e-3f);
    EXPECT_NEAR(look(system_, h, 100.5f / 256, 100.5f / 256, 0, o).v[0], 0.f, 1e-3f);
    o.blur = 0.1f;
    EXPECT_NEAR(look(system_, h, 100.5f / 256, 100.5f / 256, 0, o).v[0], 0.5f, 0.01f);
  }
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-UNPREPARED"), 1u);
}

TEST_F(TextureTest, SrgbIsDecodedBeforeFiltering) {
  write("checker.png", 64, 64, 4, OIIO::TypeUInt8, [](int x, int y, float* o) {
    o[0] = o[1] = o[2] = float((x + y) & 1);
    o[3] = 128.f / 255;
  });
  constant("mid.png", 188.f / 255);
  TextureOptions o;
  o.linearize = 1;
  const int h = system_.handle(path("checker.png"), {}), mid = system_.handle(path("mid.png"), {});
  const float decoded = std::pow((188.f / 255 + 0.055f) / 1.055f, 2.4f);
  EXPECT_NEAR(look(system_, mid, 0.5f, 0.5f, 0, o).v[0], decoded, 5e-4f);
  EXPECT_NEAR(look(system_, mid, 0.5f, 0.5f).v[0], 188.f / 255, 1e-3f);
  // the mean of black and white is one half of the light; decoding after filtering would give 0.21
  EXPECT_NEAR(look(system_, h, 0.5f, 0.5f, 0.5f, o).v[0], 0.5f, 0.01f);
  EXPECT_NEAR(look(system_, h, 0.5f, 0.5f, 0.5f, o).v[3], 128.f / 255, 2e-3f);  // alpha is no colour
  // a prepared file holds hashes and averages of its encoded values, which must not leak through
  write(
      "flat.tx", 128, 128, 3, OIIO::TypeUInt8, [](int, int, float* out) { out[0] = out[1] = out[2] = 188.f / 255; },
      true);
  const int flat = system_.handle(path("flat.tx"), {});
  EXPECT_NEAR(look(system_, flat, 0.5f, 0.5f).v[0], 188.f / 255, 1e-3f);
  EXPECT_NEAR(look(system_, flat, 0.5f, 0.5f, 0, o).v[0], decoded, 5e-4f);
  EXPECT_NEAR(look(system_, flat, 0.5f, 0.5f, 0.3f, o).v[0], decoded, 5e-4f);
}

// maketex --linearize makes such files, and TIFF has no place to say so.
TEST_F(TextureTest, DecodingNumbersThatAreLightIsTold) {
  const auto half = [](int, int, float* out) { out[0] = out[1] = out[2] = 0.5f; };
  write("light.exr", 8, 8, 3, OIIO::TypeHalf, half);
  write("codes.png", 8, 8, 3, OIIO::TypeUInt8, half);
  TextureOptions decoded;
  decoded.linearize = 1;
  look(system_, system_.handle(path("codes.png"), {}), 0.5f, 0.5f, 0, decoded);
  look(system_, system_.handle(path("light.exr"), {}), 0.5f, 0.5f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-DECODED"), 0u);
  for (int time = 0; time < 2; ++time) look(system_, system_.handle(path("light.exr"), {}), 0.5f, 0.5f, 0, decoded);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-DECODED"), 1u);
}

TEST_F(TextureTest, AtlasOfFiles) {
  constant("skin.1001.tif", 0.2f);
  constant("skin.1002.tif", 0.4f);
  constant("skin.1011.tif", 0.6f);
  constant("z_u1_v0.tif", 0.8f);
  constant("z_u0_v1.tif", 1.f);
  system_.setSearchPath({folder_.string()});
  const int udim = system_.handle("skin.<UDIM>.tif", {}), zbrush = system_.handle("z_<u>_<v>.tif", {});
  // t down: the first row of the atlas is 0..1, the one above it -1..0
  EXPECT_NEAR(look(system_, udim, 0.5f, 0.5f).v[0], 0.2f, 0.01f);
  EXPECT_NEAR(look(system_, udim, 1.5f, 0.5f).v[0], 0.4f, 0.01f);
  EXPECT_NEAR(look(system_, udim, 0.5f, -0.5f).v[0], 0.6f, 0.01f);
  EXPECT_NEAR(look(system_, udim, 1.5f, -0.5f).v[1], 0.27f, 0.01f);  // no such file: the missing colour
  EXPECT_NEAR(look(system_, udim, -0.5f, 0.5f).v[1], 0.27f, 0.01f);
  EXPECT_NEAR(look(system_, zbrush, 1.5f, 0.5f).v[0], 0.8f, 0.01f);
  EXPECT_NEAR(look(system_, zbrush, 0.5f, -0.5f).v[0], 1.f, 0.01f);
  EXPECT_NEAR(look(system_, system_.handle("skin._MAPID_.tif", {}), 1.5f, 0.5f).v[0], 0.4f, 0.01f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 0u);
  EXPECT_EQ(system_.handle("none.<UDIM>.tif", {}), TextureSystem::kNoTexture);
}

TEST_F(TextureTest, HolesOfAnAtlasAreNamedOnceAndGiveTheMissingColour) {
  constant("hole.1001.tif", 0.2f);
  constant("hole.1003.tif", 0.4f);
  constant("hole.1011.tif", 0.6f);
  constant("full.1001.tif", 0.2f);
  system_.setSearchPath({folder_.string()});
  TextureOptions o;
  o.missingColor[0] = 9.f;
  const int hole = system_.handle("hole.<UDIM>.tif", {}), full = system_.handle("full.<UDIM>.tif", {});
  EXPECT_NEAR(look(system_, hole, 2.5f, 0.5f, 0, o).v[0], 0.4f, 0.01f);
  // the far borders of tiles without a neighbour are theirs
  constexpr float kBorders[][3] = {{1.f, 0.5f, 0.2f}, {3.f, 0.5f, 0.4f}, {3.f, 0.f, 0.4f}, {1.f, -1.f, 0.6f}};
  for (const auto& [s, t, value] : kBorders)
    EXPECT_NEAR(look(system_, hole, s, t, 0, o).v[0], value, 0.01f) << s << " " << t;
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-TILE"), 0u);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(look(system_, hole, 1.5f, 0.5f, 0, o).v[0], 9.f);
  EXPECT_EQ(look(system_, hole, 1.5f, -0.5f, 0, o).v[0], 9.f);
  EXPECT_EQ(look(system_, hole, std::nanf(""), 0.5f, 0, o).v[0], 9.f);
  ASSERT_EQ(diagnostics_.count("ASSET-TEXTURE-TILE"), 1u);
  EXPECT_NE(diagnostics_.messages().back().what.find("1002, 1012, 1013"), std::string::npos)
      << diagnostics_.messages().back().what;
  EXPECT_EQ(look(system_, full, 1.5f, 0.5f, 0, o).v[0], 9.f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-TILE"), 2u) << "one for each set";
}

TEST_F(TextureTest, WholeImagesForLights) {
  write("map.exr", 4, 2, 3, OIIO::TypeFloat,
        [](int x, int y, float* o) { o[0] = float(x), o[1] = float(y), o[2] = 7; });
  constant("map8.png", 188.f / 255);
  const HostImage* m = system_.image(path("map.exr"), -1, {});
  ASSERT_NE(m, nullptr);
  EXPECT_EQ(m->width, 4u);
  EXPECT_EQ(m->height, 2u);
  EXPECT_EQ(m->channels, 3u);
  EXPECT_FLOAT_EQ(m->pixels[(1 * 4 + 2) * 3 + 0], 2.f);
  EXPECT_FLOAT_EQ(m->pixels[(1 * 4 + 2) * 3 + 1], 1.f);
  EXPECT_EQ(system_.image(path("map.exr"), -1, {}), m);
  const HostImage* e = system_.image(path("map8.png"), -1, {});
  ASSERT_NE(e, nullptr);
  EXPECT_NEAR(e->pixels[0], texture::decodeSrgb(188.f / 255), 1e-5f);
  EXPECT_NEAR(system_.image(path("map8.png"), 0, {})->pixels[0], 188.f / 255, 1e-5f);
  EXPECT_EQ(system_.image("nowhere.exr", -1, {}), nullptr);
  EXPECT_EQ(system_.image("nowhere.exr", -1, {}), nullptr);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-MISSING"), 1u);
}

TEST_F(TextureTest, SameBitsWithThreadsAndColdCaches) {
  const Pixel noise = [](int x, int y, float* o) {
    const uint32_t h = uint32_t(x * 7919 + y * 104729) * 2654435761u;
    o[0] = float(h >> 24) / 255, o[1] = float(h >> 16 & 255) / 255, o[2] = float(h >> 8 & 255) / 255;
  };
  write("ready.tx", 1024, 1024, 3, OIIO::TypeUInt8, noise, true);
  write("plain.tif", 1024, 512, 3, OIIO::TypeUInt8, noise);
  constexpr uint32_t n = 4096;
  std::vector<float> s(n), t(n), r(n);
  for (uint32_t i = 0; i < n; ++i) {
    s[i] = std::fmod(float(i) * 0.618034f, 3.f) - 1, t[i] = std::fmod(float(i) * 0.381966f, 3.f) - 1;
    r[i] = std::exp2(-1 - float(i % 11));
  }
  const auto run = [&](TextureSystem& system, const TextureOptions& o, uint32_t order) {
    std::vector<float> out(4 * 2 * n);
    const int32_t handles[2] = {system.handle(path("ready.tx"), {}), system.handle(path("plain.tif"), {})};
    for (uint32_t k = 0; k < n; k += 64)
      for (uint32_t f = 0; f < 2; ++f) {
        const uint32_t from = order ? n - 64 - k : k;
        float* const rgba[4] = {&out[(f * 4 + 0) * n + from], &out[(f * 4 + 1) * n + from],
                                &out[(f * 4 + 2) * n + from], &out[(f * 4 + 3) * n + from]};
        system.lookup(&handles[f], false, 64, &s[from], &t[from], &r[from], o, rgba);
      }
    return out;
  };
  for (int filter : {1, 3, 7})
    for (int linearize : {0, 1}) {
      TextureOptions o;
      o.filter = filter;
      o.linearize = linearize;
      const std::vector<float> want = run(system_, o, 0);
      EXPECT_EQ(run(system_, o, 1), want);  // warm, another order
      TextureSystem small(diagnostics_);
      small.setCacheLimit(1 << 20);  // tiles come and go
      std::vector<float> a, b;
      std::thread one([&] { a = run(small, o, 0); }), two([&] { b = run(small, o, 1); });
      one.join(), two.join();
      EXPECT_EQ(a, want);
      EXPECT_EQ(b, want);
    }
}

// Not a pass or fail on speed: a machine under load would fail at random.
TEST_F(TextureTest, PrintsItsRate) {
  const Pixel ramp = [](int x, int y, float* o) { o[0] = float(x) / 1024, o[1] = float(y) / 1024, o[2] = 0.5f; };
  write("rate.tx", 1024, 1024, 3, OIIO::TypeUInt8, ramp, true);
  constexpr uint32_t n = 256, groups = 64;
  std::vector<float> s(n * groups), t(n * groups), r(n * groups, 1.7f / 1024);
  for (uint32_t g = 0; g < groups; ++g)
    for (uint32_t i = 0; i < n; ++i) {  // a 16 x 16 patch
      s[g * n + i] = float(g % 8) / 8 + float(i % 16) * 1.3f / 1024;
      t[g * n + i] = float(g / 8) / 8 + float(i / 16) * 1.3f / 1024;
    }
  std::vector<float> out(4 * n);
  float* const rgba[4] = {&out[0], &out[n], &out[2 * n], &out[3 * n]};
  const int32_t h = system_.handle(path("rate.tx"), {});
  OIIO::TextureSystem* plain = OIIO::TextureSystem::create(false);
  auto* handle = plain->get_texture_handle(OIIO::ustring(path("rate.tx")));
  auto* thread = plain->get_perthread_info();
  const auto seconds = [] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  };
  for (int filter : {1, 3}) {
    TextureOptions o;
    o.filter = filter;
    double ours = 1e9, theirs = 1e9;
    for (int k = 0; k < 9; ++k) {
      double start = seconds();
      for (uint32_t g = 0; g < groups; ++g) system_.lookup(&h, false, n, &s[g * n], &t[g * n], &r[g * n], o, rgba);
      ours = std::min(ours, seconds() - start);
      start = seconds();
      for (uint32_t i = 0; i < n * groups; ++i) {
        OIIO::TextureOpt opt;
        opt.swrap = opt.twrap = OIIO::TextureOpt::WrapPeriodic;
        opt.interpmode = filter == 1 ? OIIO::TextureOpt::InterpBilinear : OIIO::TextureOpt::InterpBicubic;
        opt.mipmode = OIIO::TextureOpt::MipModeTrilinear;
        opt.anisotropic = 1;
        float value[4];
        plain->texture(handle, thread, opt, s[i], t[i], r[i], 0, 0, r[i], 3, value);
      }
      theirs = std::min(theirs, seconds() - start);
    }
    std::printf("texture lookups, filter %d: %.2f million/s in groups, %.2f by a plain loop over OpenImageIO\n",
                filter, n * groups / ours * 1e-6, n * groups / theirs * 1e-6);
    EXPECT_GT(ours, 0);
  }
  OIIO::TextureSystem::destroy(plain, true);
  const TextureStatistics st = system_.statistics();
  EXPECT_GT(st.lookups, uint64_t(n * groups));
  EXPECT_GT(st.tilesRead, 0u);
  EXPECT_GT(st.cacheBytes, 0u);
}

}  // namespace
}  // namespace kinora
