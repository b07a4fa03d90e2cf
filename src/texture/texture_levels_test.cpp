// Proves: each mip level has the image's mean, for sides of 1, odd and prime ones, of every pixel type, with alpha,
// decoded from sRGB, of an atlas, of a part of a file, of a cropped picture; made while looking up or by makeTexture,
// which agree. The expected values are sums over the image's pixels. Misses: how levels look.
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "base/folder_test.h"
#include "texture/area_average.h"
#include "texture/make_texture.h"
#include "texture/module/srgb_input.h"
#include "texture/texture_system.h"

namespace kinora {
namespace {

struct Size {
  int width, height;
};
constexpr Size kSizes[] = {{1, 1},    {2, 1},     {3, 1},   {1, 7},     {3, 3},     {5, 7},     {17, 13}, {31, 64},
                           {101, 67}, {127, 255}, {130, 3}, {129, 257}, {256, 256}, {640, 426}, {997, 11}};
constexpr double kTolerance = 0.002;

// Dark at one side and bright at the other, with grain: a level that drops or repeats a row or column shows.
float shade(Size size, int x, int y, int c) {
  const uint32_t h = (uint32_t(x) * 7919u + uint32_t(y) * 104729u + uint32_t(c) * 611953u) * 2654435761u;
  const float ramp = (float(x) + 0.5f) / float(size.width) * (float(y) + 0.5f) / float(size.height);
  return c == 3 ? 0.3f + 0.6f * float(h >> 31) : (0.1f + 0.6f * ramp * ramp + 0.3f * float(h >> 16) / 65536.f);
}

class TextureLevels : public test::FolderTest {
 protected:
  void write(const std::string& name, Size size, int channels, OIIO::TypeDesc type) const {
    OIIO::ImageSpec spec(size.width, size.height, channels, OIIO::TypeFloat);
    if (channels == 4) spec.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::ImageBuf image(spec);
    for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
      for (int c = 0; c < channels; ++c) it[c] = shade(size, it.x(), it.y(), c);
    image.set_write_format(type);
    ASSERT_TRUE(image.write(path(name))) << image.geterror();
  }
  // Of the stored pixels, by channel; of the colours decoded when `linear`.
  std::vector<double> means(const std::string& name, bool linear = false, int part = 0) const {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::ImageBuf image(path(name), part, 0, nullptr, &config);
    EXPECT_TRUE(image.read(part, 0, true, OIIO::TypeFloat)) << image.geterror();
    std::vector<double> sum(size_t(image.nchannels()), 0.);
    for (OIIO::ImageBuf::ConstIterator<float> it(image); !it.done(); ++it)
      for (int c = 0; c < image.nchannels(); ++c) {
        const float v = it[c];
        sum[size_t(c)] += double(linear && c < 3 ? texture::decodeSrgb(v) : v);
      }
    for (double& s : sum) s /= double(image.spec().full_width) * image.spec().full_height;
    return sum;
  }
  // A level's mean through lookups at its texels' centres with a footprint of just that level. `first`: (s, t) of the
  // image's corner.
  void expectMeans(const std::string& name, Size size, const std::vector<double>& expected, TextureOptions o,
                   float firstS = 0, float firstT = 0, double slack = 0) {
    TextureSystem system(diagnostics_);
    const int32_t handle = system.handle(path(name), {});
    ASSERT_GE(handle, 0) << name;
    o.wrapS = o.wrapT = 3;
    const int smaller = std::min(size.width, size.height);
    int level = 0;
    for (Size at = size;; at = {texture::coarserSide(at.width), texture::coarserSide(at.height)}, ++level) {
      const uint32_t n = uint32_t(at.width * at.height);
      std::vector<float> s(n), t(n), out(4 * n), radius(n, level ? float(1 << level) / float(smaller) : 0.f);
      for (uint32_t i = 0; i < n; ++i) {
        s[i] = firstS + (float(int(i) % at.width) + 0.5f) / float(at.width);
        t[i] = firstT + (float(int(i) / at.width) + 0.5f) / float(at.height);
      }
      float* const rgba[4] = {&out[0], &out[n], &out[2 * n], &out[3 * n]};
      // a radius is at most 4: the coarsest levels of long images are out of reach
      if (radius[0] <= 4.f) {
        system.lookup(&handle, false, n, s.data(), t.data(), radius.data(), o, rgba);
        for (size_t c = 0; c < std::min<size_t>(expected.size(), 4); ++c) {
          double sum = 0;
          const size_t channel = expected.size() == 2 && c == 1 ? 3 : c;
          for (uint32_t i = 0; i < n; ++i) sum += double(rgba[channel][i]);
          const double error = std::fabs(sum / n - expected[c]);
          worst_ = std::max(worst_, error / expected[c]);
          EXPECT_LE(error, kTolerance * expected[c] + slack / n)
              << name << " " << size.width << " x " << size.height << " level " << level << " channel " << c << ": "
              << sum / n << ", the image " << expected[c];
        }
      }
      if (at.width == 1 && at.height == 1) break;
    }
  }
  // The levels that a file holds. Rounding to integers leaves up to half a step of a level's sum.
  void expectStored(const std::string& name, Size size, const std::vector<double>& expected, double halfStep) {
    int levels = 1;
    for (Size at = size; at.width > 1 || at.height > 1; ++levels)
      at = {texture::coarserSide(at.width), texture::coarserSide(at.height)};
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    EXPECT_EQ(OIIO::ImageBuf(path(name)).nmiplevels(), levels) << name;
    for (int level = 0; level < levels; ++level) {
      OIIO::ImageBuf image(path(name), 0, level, nullptr, &config);
      ASSERT_TRUE(image.read(0, level, true, OIIO::TypeFloat)) << image.geterror();
      ASSERT_EQ(image.nchannels(), int(expected.size())) << name;
      std::vector<double> sum(expected.size(), 0.);
      for (OIIO::ImageBuf::ConstIterator<float> it(image); !it.done(); ++it)
        for (size_t c = 0; c < sum.size(); ++c) sum[c] += double(it[int(c)]);
      const double n = double(image.spec().width) * image.spec().height;
      for (size_t c = 0; c < sum.size(); ++c)
        EXPECT_LE(std::fabs(sum[c] / n - expected[c]), kTolerance * expected[c] + halfStep * 1.001 / n)
            << name << " " << size.width << " x " << size.height << " level " << level << " channel " << c << ": "
            << sum[c] / n << ", the image " << expected[c];
    }
  }

  Diagnostics diagnostics_{[](const std::string&, Severity) {}};
  double worst_ = 0;
};

struct PixelKind {
  const char* name;
  const char* ending;
  OIIO::TypeDesc type;
  int channels;
  double halfStep;  // of a stored texel
};
const PixelKind kKinds[] = {
    {"grey8", ".png", OIIO::TypeUInt8, 1, 0.5 / 255},
    {"rgb8", ".tif", OIIO::TypeUInt8, 3, 0.5 / 255},
    {"alpha8", ".png", OIIO::TypeUInt8, 4, 0.5 / 255},
    {"greyAlpha8", ".png", OIIO::TypeUInt8, 2, 0.5 / 255},
    {"alpha16", ".png", OIIO::TypeUInt16, 4, 0.5 / 65535},
    {"rgb16", ".tif", OIIO::TypeUInt16, 3, 0.5 / 65535},
    {"half", ".exr", OIIO::TypeHalf, 3, 0},
    {"alphaHalf", ".exr", OIIO::TypeHalf, 4, 0},
    {"float", ".exr", OIIO::TypeFloat, 3, 0},
    {"alphaFloat", ".tif", OIIO::TypeFloat, 4, 0},
};

std::string fileName(const PixelKind& kind, Size size, const char* ending) {
  return std::string(kind.name) + "_" + std::to_string(size.width) + "_" + std::to_string(size.height) + ending;
}

TEST_F(TextureLevels, KeepTheMeanWhenMadeByLookups) {
  for (const PixelKind& kind : kKinds)
    for (const Size size : kSizes) {
      const std::string name = fileName(kind, size, kind.ending);
      write(name, size, kind.channels, kind.type);
      TextureOptions o;
      expectMeans(name, size, means(name), o);
      if (HasFailure()) return;
    }
  std::printf("worst level: %.4f %% off the image's mean\n", 100 * worst_);
}

TEST_F(TextureLevels, KeepTheMeanOfLightWhenSrgbIsDecoded) {
  for (const PixelKind& kind : {kKinds[1], kKinds[2], kKinds[5]})
    for (const Size size : kSizes) {
      const std::string name = fileName(kind, size, kind.ending);
      write(name, size, kind.channels, kind.type);
      TextureOptions o;
      o.linearize = 1;
      expectMeans(name, size, means(name, true), o);
    }
}

// Lookups by the library's own call, with levels that it chooses: the coarsest one is the mean.
TEST_F(TextureLevels, KeepTheMeanForOtherFiltersAndWraps) {
  for (const Size size : {Size{101, 67}, Size{31, 64}, Size{5, 7}}) {
    const std::string name = fileName(kKinds[1], size, ".tif");
    write(name, size, 3, OIIO::TypeUInt8);
    TextureSystem system(diagnostics_);
    const int32_t handle = system.handle(path(name), {});
    for (const int linearize : {0, 1}) {
      const std::vector<double> expected = means(name, linearize != 0);
      for (const int filter : {0, 1, 3, 6, 7})
        for (const int wrap : {2, 3, 4}) {
          TextureOptions o;
          o.filter = filter, o.wrapS = o.wrapT = wrap, o.linearize = linearize;
          const float s = 0.3f, t = 0.6f, radius = 4.f;
          float out[4];
          float* const rgba[4] = {&out[0], &out[1], &out[2], &out[3]};
          system.lookup(&handle, false, 1, &s, &t, &radius, o, rgba);
          for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(out[c], expected[c], kTolerance * expected[c]) << name << " filter " << filter;
        }
    }
  }
}

TEST_F(TextureLevels, KeepTheMeanOfEachFileOfAnAtlas) {
  const Size sizes[] = {{101, 67}, {33, 35}};
  write("skin.1001.png", sizes[0], 3, OIIO::TypeUInt8);
  write("skin.1012.png", sizes[1], 3, OIIO::TypeUInt8);
  expectMeans("skin.<UDIM>.png", sizes[0], means("skin.1001.png"), {}, 0, 0);
  expectMeans("skin.<UDIM>.png", sizes[1], means("skin.1012.png"), {}, 1, -1);
}

TEST_F(TextureLevels, KeepTheMeanOfPartsAndOfCroppedPictures) {
  const Size size{101, 67};
  std::vector<OIIO::ImageBuf> images;
  std::vector<OIIO::ImageSpec> specs;
  for (int part = 0; part < 2; ++part) {
    OIIO::ImageSpec spec(size.width, size.height, 3, OIIO::TypeFloat);
    spec.attribute("oiio:subimagename", part ? "second" : "first");
    images.emplace_back(spec);
    for (OIIO::ImageBuf::Iterator<float> it(images.back()); !it.done(); ++it)
      for (int c = 0; c < 3; ++c) it[c] = shade(size, it.x(), it.y(), c) * (part ? 0.5f : 1.f);
    specs.push_back(spec);
  }
  auto output = OIIO::ImageOutput::create(path("parts.exr"));
  ASSERT_TRUE(output->open(path("parts.exr"), 2, specs.data()));
  ASSERT_TRUE(output->write_image(OIIO::TypeFloat, images[0].localpixels()));
  ASSERT_TRUE(output->open(path("parts.exr"), specs[1], OIIO::ImageOutput::AppendSubimage));
  ASSERT_TRUE(output->write_image(OIIO::TypeFloat, images[1].localpixels()));
  ASSERT_TRUE(output->close());
  expectMeans("parts.exr", size, means("parts.exr"), {});
  // the second part by the library's call, with levels that it chooses: the coarsest one
  TextureSystem system(diagnostics_);
  const int32_t handle = system.handle(path("parts.exr"), {});
  TextureSystem::Part second;
  second.number = 1;
  const float s = 0.3f, t = 0.6f, radius = 4.f;
  float out[4];
  float* const rgba[4] = {&out[0], &out[1], &out[2], &out[3]};
  system.lookup(&handle, false, 1, &s, &t, &radius, {}, second, rgba);
  const std::vector<double> mean = means("parts.exr", false, 1);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(out[c], mean[c], kTolerance * mean[c]);

  // a data window within the display window: black around it
  OIIO::ImageSpec spec(40, 30, 3, OIIO::TypeFloat);
  spec.x = 20, spec.y = 11;
  spec.full_width = size.width, spec.full_height = size.height;
  OIIO::ImageBuf crop(spec);
  for (OIIO::ImageBuf::Iterator<float> it(crop); !it.done(); ++it)
    for (int c = 0; c < 3; ++c) it[c] = shade(size, it.x(), it.y(), c);
  ASSERT_TRUE(crop.write(path("crop.exr")));
  expectMeans("crop.exr", size, means("crop.exr"), {});
  std::string why;
  ASSERT_EQ(texture::makeTexture(path("crop.exr"), path("crop.tx"), {}, why), texture::MakeTextureResult::Made)
      << why;
  expectStored("crop.tx", size, means("crop.exr"), 0);
  for (const char* name : {"made.tx", "made.exr"}) {
    ASSERT_EQ(texture::makeTexture(path("parts.exr"), path(name), {}, why), texture::MakeTextureResult::Made) << why;
    expectStored(name, size, means("parts.exr"), 0);
  }
}

TEST_F(TextureLevels, KeepTheMeanWhenMadeBeforehand) {
  for (const PixelKind& kind : kKinds)
    for (const Size size : kSizes) {
      const std::string source = fileName(kind, size, kind.ending);
      write(source, size, kind.channels, kind.type);
      const bool floats = kind.halfStep == 0;
      for (const char* ending : {".tx", ".exr"}) {
        if (!floats && std::string(ending) == ".exr") continue;
        const std::string name = "made_" + fileName(kind, size, ending);
        std::string why;
        ASSERT_EQ(texture::makeTexture(path(source), path(name), {}, why), texture::MakeTextureResult::Made) << why;
        expectStored(name, size, means(source), kind.halfStep);
        // and as lookups see it
        expectMeans(name, size, means(source), {}, 0, 0, kind.halfStep * 1.001);
      }
      if (HasFailure()) return;
    }
}

TEST_F(TextureLevels, KeepTheMeanOfLightWhenMadeLinear) {
  const Size size{101, 67};
  for (const int channels : {3, 4}) {
    write("encoded.png", size, channels, OIIO::TypeUInt8);
    texture::MakeTextureOptions o;
    o.linearize = true;
    std::string why;
    ASSERT_EQ(texture::makeTexture(path("encoded.png"), path("light.tx"), o, why), texture::MakeTextureResult::Made)
        << why;
    expectStored("light.tx", size, means("encoded.png", true), 0);
  }
}

// Rounding every texel up at one half brightens a level by half a step: here by one part in ten.
TEST_F(TextureLevels, RoundingOfDarkBytesDoesNotAddUp) {
  const Size size{128, 128};
  OIIO::ImageBuf image(OIIO::ImageSpec(size.width, size.height, 3, OIIO::TypeFloat));
  for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
    for (int c = 0; c < 3; ++c) it[c] = float(5 + (it.x() & 1)) / 255.f;
  image.set_write_format(OIIO::TypeUInt8);
  ASSERT_TRUE(image.write(path("dark.png")));
  expectMeans("dark.png", size, means("dark.png"), {});
  std::string why;
  ASSERT_EQ(texture::makeTexture(path("dark.png"), path("dark.tx"), {}, why), texture::MakeTextureResult::Made)
      << why;
  expectStored("dark.tx", size, means("dark.png"), 0.5 / 255);
}

TEST_F(TextureLevels, AverageColourOfAFileIsItsMean) {
  const Size size{101, 67};
  write("plain.png", size, 3, OIIO::TypeUInt8);
  std::string why;
  ASSERT_EQ(texture::makeTexture(path("plain.png"), path("made.tx"), {}, why), texture::MakeTextureResult::Made);
  TextureSystem system(diagnostics_);
  const std::vector<double> expected = means("plain.png");
  for (const char* name : {"plain.png", "made.tx"}) {
    float colour[3] = {};
    ASSERT_TRUE(system.fact(path(name), "averagecolor", 3, nullptr, colour, nullptr)) << name;
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(colour[c], expected[c], kTolerance * expected[c] + 0.5 / 255) << name;
  }
}

TEST_F(TextureLevels, KeepTheMeanWithTheOptionsOfMaking) {
  const Size size{101, 67};
  write("source.exr", size, 3, OIIO::TypeFloat);
  const std::vector<double> expected = means("source.exr");
  const auto make = [&](const char* output, const texture::MakeTextureOptions& o) {
    std::string why;
    EXPECT_EQ(texture::makeTexture(path("source.exr"), path(output), o, why), texture::MakeTextureResult::Made)
        << output << ": " << why;
  };
  texture::MakeTextureOptions o;
  o.latlong = true;
  for (const char* name : {"environment.tx", "environment.exr"}) {
    make(name, o);
    expectStored(name, size, expected, 0);
  }
  o = {};
  o.tileSize = 16, o.wrapS = "clamp", o.wrapT = "mirror", o.compression = "lzw";
  o.type = "byte";
  make("byte.tx", o);
  expectStored("byte.tx", size, expected, 0.5 / 255);
  EXPECT_EQ(OIIO::ImageBuf(path("byte.tx")).spec().get_string_attribute("wrapmodes"), "clamp,mirror");
  EXPECT_EQ(OIIO::ImageBuf(path("byte.tx")).spec().format, OIIO::TypeUInt8);
  o.type = "short";
  make("short.tx", o);
  expectStored("short.tx", size, expected, 0.5 / 65535);
  o = {};
  o.mipMapped = false;
  for (const char* name : {"flat.tx", "flat.exr"}) {
    make(name, o);
    EXPECT_EQ(OIIO::ImageBuf(path(name)).nmiplevels(), 1) << name;
    TextureSystem system(diagnostics_);
    const float s = 0.5f / float(size.width), t = 0.5f / float(size.height), radius = 2.f;
    float out[4];
    float* const rgba[4] = {&out[0], &out[1], &out[2], &out[3]};
    const int32_t handle = system.handle(path(name), {});
    system.lookup(&handle, false, 1, &s, &t, &radius, {}, rgba);
    EXPECT_NEAR(out[0], shade(size, 0, 0, 0), 1e-5f) << name << ": made without levels, it has none";
  }
}

// What lies beyond what an integer can hold is cut before levels are made of it.
TEST_F(TextureLevels, BytesOfBrightImagesAreCutFirst) {
  const Size size{33, 21};
  OIIO::ImageBuf image(OIIO::ImageSpec(size.width, size.height, 3, OIIO::TypeFloat));
  for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
    for (int c = 0; c < 3; ++c) it[c] = it.x() == 5 ? 40.f : 0.2f;
  ASSERT_TRUE(image.write(path("bright.exr")));
  texture::MakeTextureOptions o;
  o.type = "byte";
  std::string why;
  ASSERT_EQ(texture::makeTexture(path("bright.exr"), path("bright.tx"), o, why), texture::MakeTextureResult::Made);
  const double expected = 0.2 + 0.8 / size.width;
  expectStored("bright.tx", size, {expected, expected, expected}, 0.5 / 255);
}

// Levels are made by whichever thread first needs them, of tiles that others may be making.
TEST_F(TextureLevels, SameBitsForManyThreads) {
  write("odd.tif", {1021, 509}, 3, OIIO::TypeUInt8);
  write("odd.exr", {997, 1500}, 4, OIIO::TypeFloat);
  constexpr uint32_t n = 1024, kThreads = 8;
  std::vector<float> s(n), t(n), r(n);
  for (uint32_t i = 0; i < n; ++i) {
    s[i] = std::fmod(float(i) * 0.618034f, 1.f), t[i] = std::fmod(float(i) * 0.381966f, 1.f);
    r[i] = std::exp2(-float(i % 12));
  }
  const auto run = [&](TextureSystem& system, uint32_t first) {
    std::vector<float> out(2 * 2 * 4 * n);
    for (uint32_t k = 0; k < n; k += 64)
      for (uint32_t f = 0; f < 2; ++f)
        for (uint32_t bicubic = 0; bicubic < 2; ++bicubic) {
          TextureOptions o;
          o.filter = bicubic ? 3 : 1;
          o.linearize = int(f == 0);
          const int32_t handle = system.handle(path(f ? "odd.exr" : "odd.tif"), {});
          const uint32_t from = (k + first) % n;
          float* const to = &out[(f * 2 + bicubic) * 4 * n];
          float* const rgba[4] = {to + from, to + n + from, to + 2 * n + from, to + 3 * n + from};
          system.lookup(&handle, false, 64, &s[from], &t[from], &r[from], o, rgba);
        }
    return out;
  };
  TextureSystem alone(diagnostics_), together(diagnostics_);
  const std::vector<float> expected = run(alone, 0);
  together.setCacheLimit(1 << 20);  // much less than the files need: what is made must not be made for ever
  std::vector<std::vector<float>> got(kThreads);
  std::vector<std::thread> threads;
  for (uint32_t i = 0; i < kThreads; ++i) threads.emplace_back([&, i] { got[i] = run(together, i * 64); });
  for (std::thread& thread : threads) thread.join();
  for (const auto& g : got) EXPECT_EQ(g, expected);
}

}  // namespace
}  // namespace kinora
