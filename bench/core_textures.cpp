// texture_vs_oiio: trilinear lookups of groups of 256 points, by the renderer's texture system and by OpenImageIO's
// own call with the same options, on the same points of one tiled mip-mapped file that lies in the cache.
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/texture.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <vector>

#include "core.h"
#include "texture/texture_system.h"

namespace kinora::bench {
namespace {

constexpr uint32_t kGroup = 256;

struct Points {
  std::vector<float> s, t, radius;
};

// `side` groups see a patch of the picture each, as neighbouring camera hits do; scattered ones see all of it.
Points makePoints(uint32_t groups, bool scattered, float least, float most) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> u(0, 1);
  Points p;
  for (uint32_t g = 0; g < groups; ++g) {
    const float s0 = u(random), t0 = u(random), reach = scattered ? 1.f : 0.03f;
    for (uint32_t i = 0; i < kGroup; ++i) {
      p.s.push_back(s0 + reach * u(random));
      p.t.push_back(t0 + reach * u(random));
      p.radius.push_back(least * std::pow(most / least, u(random)));
    }
  }
  return p;
}

}  // namespace

std::string makeTexture(int side, bool isHalf) {
  OIIO::ImageBuf image(OIIO::ImageSpec(side, side, 3, OIIO::TypeDesc::FLOAT));
  for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
    for (int c = 0; c < 3; ++c) it[c] = 0.5f + 0.5f * std::sin(float(it.x() * (c + 1) + it.y() * 3) * 0.05f);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("kinora-bench-" + std::to_string(getpid()) + ".tx")).string();
  OIIO::ImageSpec config;
  config.tile_width = config.tile_height = 64;
  config.set_format(isHalf ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::UINT8);
  if (!OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, image, file, config)) return "";
  return file;
}

void measureTextures(const Options& options, Figures& figures) {
  struct Case {
    const char* name;
    bool isHalf;
    bool scattered;
    float least, most;
  };
  const Case cases[] = {{"texture_vs_oiio", false, false, 5e-4f, 5e-3f},
                        {"texture_vs_oiio_half", true, false, 5e-4f, 5e-3f},
                        {"texture_vs_oiio_scattered", false, true, 1e-3f, 1e-2f}};
  for (const Case& one : cases) {
    const std::string file = makeTexture(options.quick ? 128 : 2048, one.isHalf);
    if (file.empty()) {
      std::fprintf(stderr, "kinora-bench: error BENCH-WRITE: no temporary texture can be written\n");
      return;
    }
    const uint32_t groups = options.quick ? 4 : 400;
    const Points points = makePoints(groups, one.scattered, one.least, one.most);
    std::vector<float> out[4];
    for (auto& o : out) o.resize(kGroup);
    float* const rgba[4] = {out[0].data(), out[1].data(), out[2].data(), out[3].data()};

    Diagnostics diagnostics;
    TextureSystem ours(diagnostics);
    const int32_t handle = ours.handle(file, {});
    TextureOptions request;
    const auto runOurs = [&] {
      for (uint32_t g = 0; g < groups; ++g)
        ours.lookup(&handle, false, kGroup, &points.s[g * kGroup], &points.t[g * kGroup], &points.radius[g * kGroup],
                    request, rgba);
    };
    OIIO::TextureSystem* theirs = OIIO::TextureSystem::create(false);
    OIIO::TextureSystem::Perthread* thread = theirs->get_perthread_info();
    OIIO::TextureSystem::TextureHandle* texture = theirs->get_texture_handle(OIIO::ustring(file), thread);
    OIIO::TextureOpt opt;
    opt.swrap = opt.twrap = OIIO::TextureOpt::WrapPeriodic;
    opt.interpmode = OIIO::TextureOpt::InterpBilinear;
    opt.mipmode = OIIO::TextureOpt::MipModeTrilinear;
    opt.anisotropic = 1;
    const auto runTheirs = [&] {
      for (uint32_t i = 0; i < groups * kGroup; ++i) {
        float texel[3];
        const float r = points.radius[i];
        theirs->texture(texture, thread, opt, points.s[i], points.t[i], r, 0, 0, r, 3, texel);
        for (int c = 0; c < 3; ++c) out[c][i % kGroup] = texel[c];
      }
    };
    runOurs();
    runTheirs();
    std::vector<double> ratio, rate;
    for (int i = 0; i < options.repeat; ++i) {
      double start = threadSeconds();
      runOurs();
      const double a = threadSeconds() - start;
      start = threadSeconds();
      runTheirs();
      const double b = threadSeconds() - start;
      ratio.push_back(b / a);
      rate.push_back(groups * kGroup / a * 1e-6);
    }
    figures.add(one.name, ratio, "lookups a second over OpenImageIO's own call, groups of 256 points, in cache");
    figures.add(std::string("million_lookups") + (one.name + 15), rate, "million lookups a second of one thread");
    OIIO::TextureSystem::destroy(theirs, true);
    std::filesystem::remove(file);
  }
}

}  // namespace kinora::bench
