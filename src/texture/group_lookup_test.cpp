// Proves: group lookups are OpenImageIO's own within rounding, for each pixel type, wrap mode and number of channels,
// on prepared and plain files; a point's value does not depend on the group; the cache's budget holds; headers that
// claim more than their file can hold are refused; atlases with holes; one hint a file. Misses: speed (kinora-bench).
#include "texture/module/group_lookup.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/texture.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>

#include "base/folder_test.h"
#include "texture/module/pyramid_input.h"
#include "texture/texture_system.h"

namespace kinora {
namespace {

class GroupLookup : public test::FolderTest {
 protected:
  void write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type, const char* wrap,
             bool prepared, float value = -1) const {
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeFloat);
    if (wrap) spec.attribute("wrapmodes", wrap);
    OIIO::ImageBuf image(spec);
    for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
      for (int c = 0; c < channels; ++c)
        it[c] = value >= 0
                    ? value
                    : 0.5f + 0.45f * std::sin(float(it.x()) * (0.3f + 0.1f * float(c)) + float(it.y()) * 0.21f);
    if (prepared) {
      OIIO::ImageSpec config;
      if (wrap) config.attribute("wrapmodes", wrap);
      config.set_format(type);
      ASSERT_TRUE(OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, image, path(name), config));
    } else {
      image.set_write_format(type);
      ASSERT_TRUE(image.write(path(name))) << image.geterror();
    }
  }

  Diagnostics diagnostics_{[](const std::string&, Severity) {}};
};

struct Group {
  std::vector<float> s, t, radius, out[4];
  explicit Group(uint32_t n) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> u(-1.3f, 2.2f), e(-12, -0.2f);
    for (uint32_t i = 0; i < n; ++i) {
      s.push_back(u(random));
      t.push_back(u(random));
      radius.push_back(i % 7 == 0 ? 0.f : std::exp2(e(random)));
    }
    for (auto& o : out) o.resize(n);
  }
  void look(TextureSystem& system, int32_t handle, const TextureOptions& options, uint32_t from, uint32_t count) {
    float* const rgba[4] = {&out[0][from], &out[1][from], &out[2][from], &out[3][from]};
    system.lookup(&handle, false, count, &s[from], &t[from], &radius[from], options, rgba);
  }
};

TEST_F(GroupLookup, IsOpenImageIOsOwnCall) {
  struct Case {
    const char* file;
    OIIO::TypeDesc type;
    int channels;
    const char* wrap;
    bool prepared;
    double tolerance;
  };
  const Case cases[] = {
      {"a.tx", OIIO::TypeUInt8, 3, "periodic,periodic", true, 3e-5},
      {"b.tx", OIIO::TypeUInt16, 4, "clamp,clamp", true, 3e-5},
      {"c.tx", OIIO::TypeHalf, 3, "black,clamp", true, 3e-5},
      {"d.tx", OIIO::TypeFloat, 1, "periodic,black", true, 3e-5},
      {"e.tif", OIIO::TypeUInt8, 3, "clamp,periodic", false, 3e-5},
      {"f.exr", OIIO::TypeHalf, 4, nullptr, false, 3e-5},
      {"g.tx", OIIO::TypeFloat, 2, "clamp,clamp", true, 3e-5},
  };
  OIIO::TextureSystem* theirs = OIIO::TextureSystem::create(false);
  auto maker = std::make_unique<texture::LevelMaker>(*theirs->imagecache());
  for (const char* attribute : {"accept_untiled", "accept_unmipped", "unassociatedalpha"})
    theirs->attribute(attribute, 1);
  theirs->attribute("autotile", 64);
  for (const Case& c : cases) {
    // sides of powers of two: in others OpenImageIO's mix of levels jumps where sides are rounded, ours does not
    write(c.file, 256, 128, c.channels, c.type, c.wrap, c.prepared);
    TextureSystem system(diagnostics_);
    const int32_t handle = system.handle(path(c.file), {});
    ASSERT_GE(handle, 0) << c.file;
    OIIO::TextureOpt opt;
    OIIO::TextureOpt::parse_wrapmodes(c.wrap ? c.wrap : "periodic,periodic", opt.swrap, opt.twrap);
    const OIIO::ustring file = c.prepared ? OIIO::ustring(path(c.file)) : maker->add(path(c.file));
    for (const bool isSmart : {false, true}) {  // bilinear; cubic where texels are magnified
      opt.interpmode = isSmart ? OIIO::TextureOpt::InterpSmartBicubic : OIIO::TextureOpt::InterpBilinear;
      opt.mipmode = isSmart ? OIIO::TextureOpt::MipModeAniso : OIIO::TextureOpt::MipModeTrilinear;
      opt.anisotropic = 1;
      TextureOptions options;
      options.filter = isSmart ? 7 : 1;
      Group g(1024);
      g.look(system, handle, options, 0, 1024);
      int differ = 0;
      for (uint32_t i = 0; i < 1024; ++i) {
        float texel[4] = {0, 0, 0, 0};
        const float r = std::min(g.radius[i], 4.f);
        ASSERT_TRUE(theirs->texture(file, opt, g.s[i], g.t[i], r, 0, 0, r, c.channels, texel));
        const float* expected = texel;
        for (int k = 0; k < (c.channels < 3 ? 1 : 3); ++k)
          if (std::fabs(g.out[k][i] - expected[k]) > c.tolerance && ++differ < 4)
            ADD_FAILURE() << c.file << " at " << g.s[i] << ' ' << g.t[i] << " radius " << r << " channel " << k
                          << ": " << g.out[k][i] << " against " << expected[k] << (isSmart ? ", smart" : "");
      }
      EXPECT_EQ(differ, 0) << c.file;
    }
  }
  maker.reset();
  OIIO::TextureSystem::destroy(theirs, true);
}

TEST_F(GroupLookup, APointsValueIsItsOwn) {
  write("a.tx", 300, 300, 3, OIIO::TypeUInt8, "periodic,periodic", true);
  TextureSystem system(diagnostics_);
  const int32_t handle = system.handle(path("a.tx"), {});
  Group whole(512), single(512);
  whole.look(system, handle, {}, 0, 512);
  for (uint32_t i = 512; i-- > 0;) single.look(system, handle, {}, i, 1);
  for (int c = 0; c < 4; ++c) EXPECT_EQ(std::memcmp(whole.out[c].data(), single.out[c].data(), 512 * 4), 0);
}

TEST_F(GroupLookup, TheBudgetHolds) {
  write("big.tx", 2048, 2048, 4, OIIO::TypeFloat, nullptr, true);  // 85 MB with its levels
  TextureSystem system(diagnostics_);
  constexpr uint64_t kLimit = 16u << 20;
  system.setCacheLimit(kLimit);
  const int32_t handle = system.handle(path("big.tx"), {});
  Group g(1 << 14);
  for (float& r : g.radius) r = 0;
  for (uint32_t at = 0; at < 1 << 14; at += 256) {
    g.look(system, handle, {}, at, 256);
    // the tiles that the last groups held may wait to be freed
    EXPECT_LE(system.statistics().cacheBytes, kLimit + (8u << 20));
  }
  EXPECT_GT(system.statistics().tilesRead, 1000u) << "all of it was looked at";
}

TEST_F(GroupLookup, HeadersThatClaimTooMuchAreRefused) {
  std::ofstream(path("vast.ppm")) << "P6\n100000 100000\n255\nabc";
  TextureSystem system(diagnostics_);
  TextureOptions o;
  o.missingColor[0] = 0.25f;
  const int32_t handle = system.handle(path("vast.ppm"), {});
  Group g(16);
  g.look(system, handle, o, 0, 16);
  EXPECT_EQ(g.out[0][3], 0.25f);
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-READ"), 1u);
  EXPECT_LT(system.statistics().cacheBytes, 1u << 20);
}

TEST_F(GroupLookup, AtlasesMayHaveHoles) {
  write("skin.1001.tif", 32, 32, 3, OIIO::TypeUInt8, nullptr, false, 0.2f);
  write("skin.1003.tif", 32, 32, 3, OIIO::TypeUInt8, nullptr, false, 0.6f);
  write("skin.1011.tif", 32, 32, 3, OIIO::TypeUInt8, nullptr, false, 0.8f);
  TextureSystem system(diagnostics_);
  TextureOptions o;
  for (float& c : o.missingColor) c = 0.45f;
  for (const char* name : {"skin.<UDIM>.tif", "skin._MAPID_.tif", "skin.%(UDIM)d.tif"}) {
    const int32_t handle = system.handle(path(name), {});
    ASSERT_GE(handle, 0) << name;
    const float s[5] = {0.5f, 1.5f, 2.5f, 0.5f, 7.5f}, t[5] = {0.5f, 0.5f, 0.5f, -0.5f, 0.5f}, r[5] = {};
    const float expected[5] = {0.2f, 0.45f, 0.6f, 0.8f, 0.45f};
    float out[4][5];
    float* const rgba[4] = {out[0], out[1], out[2], out[3]};
    system.lookup(&handle, false, 5, s, t, r, o, rgba);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(out[0][i], expected[i], 0.003f) << name << ' ' << i;
  }
  // one hint for each file of the set that is not prepared, however often it is named
  EXPECT_EQ(diagnostics_.count("ASSET-TEXTURE-UNPREPARED"), 3u);
}

}  // namespace
}  // namespace kinora
