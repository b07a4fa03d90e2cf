// Proves: a lookup over an ellipse is the mean of round lookups along its longer axis, as wide as the shorter one, for
// each kind of file, side, shape, wrap mode and filter; shapes that are none fall back to the radius; nothing leaves
// the image's range; a point's value does not depend on the group; the value is nearer to the mean over the ellipse
// than a round lookup's. The expected axes are worked out in doubles by another formula. Misses: which footprints surfaces
// have (tests/probes), speed (tools/measure_footprints).
#include <OpenImageIO/imagebuf.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include "base/folder_test.h"
#include "texture/footprint.h"
#include "texture/make_texture.h"
#include "texture/texture_system.h"

namespace kinora {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();

struct Axes {
  float v[4];  // s and t of two half diameters
};
struct Color {
  float v[4];
  bool operator==(const Color& o) const { return std::memcmp(v, o.v, sizeof v) == 0; }
};

class EllipseLookup : public test::FolderTest {
 protected:
  // Grain over waves, in 0.1 .. 0.9.
  void write(const std::string& name, int width, int height, int channels, OIIO::TypeDesc type, bool prepared) const {
    OIIO::ImageSpec spec(width, height, channels, OIIO::TypeFloat);
    if (channels == 4) spec.attribute("oiio:UnassociatedAlpha", 1);
    OIIO::ImageBuf image(spec);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> u(0, 1);
    for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it)
      for (int c = 0; c < channels; ++c)
        it[c] = 0.1f + 0.5f * u(random) + 0.15f * (1 + std::sin(0.2f * float(it.x() + c) + 0.1f * float(it.y())));
    image.set_write_format(type);
    const std::string source = prepared ? path("source.exr") : path(name);
    ASSERT_TRUE(image.write(source)) << image.geterror();
    if (!prepared) return;
    texture::MakeTextureOptions o;
    o.type = type == OIIO::TypeUInt8 ? "byte" : type == OIIO::TypeUInt16 ? "short" : "";
    std::string why;
    ASSERT_EQ(texture::makeTexture(source, path(name), o, why), texture::MakeTextureResult::Made) << why;
  }

  static Color look(TextureSystem& system, int32_t handle, float s, float t, float radius, const TextureOptions& o,
                    const Axes* axes = nullptr) {
    Color c;
    float* const rgba[4] = {&c.v[0], &c.v[1], &c.v[2], &c.v[3]};
    const float* const of[4] = {axes ? axes->v : nullptr, axes ? axes->v + 1 : nullptr, axes ? axes->v + 2 : nullptr,
                                axes ? axes->v + 3 : nullptr};
    system.lookup(&handle, false, 1, &s, &t, &radius, o, rgba, axes ? of : nullptr);
    return c;
  }

  Diagnostics diagnostics_{[](const std::string&, Severity) {}};
};

// Half diameters of an ellipse of these half lengths (texels), turned, as two conjugate ones that are not its axes.
Axes shapeOf(double longer, double shorter, double angle, double phase, int width, int height) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto at = [&](double p, float* out) {
    const double x = longer * std::cos(p), y = shorter * std::sin(p);
    out[0] = float((c * x - s * y) / width);
    out[1] = float((s * x + c * y) / height);
  };
  Axes a;
  at(phase, a.v);
  at(phase + M_PI / 2, a.v + 2);
  return a;
}

struct Shape {
  const char* name;
  double longer, shorter, angle;  // texels, radians
};
// No shorter axis half way between two levels, and no number of probes half way to the next: rounding would decide.
constexpr Shape kShapes[] = {
    {"round", 2.5, 2.5, 0},         {"nearly round", 3.4, 2.5, 0.4}, {"thrice", 7.2, 2.2, 1.1},
    {"ten times", 24, 2.5, 2},      {"below a texel", .4, .1, 1},    {"across texels", 6, .3, 2.6},
    {"longest", 17, 1.1, 0.7},      {"longer", 90, 1.2, 0.2},        {"coarse", 110, 13, 1.9},
    {"upright", 12, 2.2, M_PI / 2}, {"lying", 12, 2.2, 0},           {"a line", 8, 0, 0.5},
};
struct File {
  const char* name;
  int width, height, channels;
  OIIO::TypeDesc type;
  bool prepared;
};
const File kFiles[] = {
    {"bytes.tx", 256, 128, 3, OIIO::TypeUInt8, true}, {"shorts.tx", 64, 512, 4, OIIO::TypeUInt16, true},
    {"floats.tx", 97, 61, 1, OIIO::TypeFloat, true},  {"halves.exr", 130, 200, 4, OIIO::TypeHalf, false},
    {"grey.png", 33, 128, 2, OIIO::TypeUInt8, false}, {"dot.png", 1, 1, 3, OIIO::TypeUInt8, false},
    {"row.tif", 300, 1, 3, OIIO::TypeUInt8, false},
};

TEST_F(EllipseLookup, IsTheMeanOfRoundLookupsAlongItsLongerAxis) {
  uint32_t compared = 0, several = 0;
  double worst = 0;
  for (const File& file : kFiles) {
    write(file.name, file.width, file.height, file.channels, file.type, file.prepared);
    TextureSystem system(diagnostics_);
    const int32_t handle = system.handle(path(file.name), {});
    ASSERT_GE(handle, 0) << file.name;
    for (const int filter : {0, 1, 2, 3, 6, 7})
      for (const int wrap : {0, 1, 2, 3, 4})
        for (const int blends : {0, 1})
          for (const Shape& shape : kShapes) {
            // what is larger than four times the texture is cut off
            if (shape.longer > double(texture::kMostReach) * std::min(file.width, file.height)) continue;
            TextureOptions o;
            o.filter = filter, o.wrapS = wrap, o.wrapT = wrap == 2 ? 3 : wrap, o.interpolateLevels = blends;
            const double reach = double(texture::kCovered) * shape.longer,
                         stretch = reach / std::max(shape.shorter, 1.);
            const int count =
                stretch < texture::kLeastStretch ? 1 : int(std::min(stretch + 0.5, double(texture::kMostProbes)));
            for (const float phase : {0.f, 0.9f}) {
              const Axes axes = shapeOf(shape.longer, shape.shorter, shape.angle, phase, file.width, file.height);
              const float s = 0.13f + 0.31f * phase, t = 0.71f - 0.2f * phase, unused = 0.01f;
              const Color got = look(system, handle, s, t, unused, o, &axes);
              double expected[4] = {0, 0, 0, 0};
              const float radius = float(shape.shorter / std::min(file.width, file.height));
              for (int k = 0; k < count && filter != 0; ++k) {
                const double along = reach * ((2. * k + 1) / count - 1);
                const Color one =
                    look(system, handle, float(s + (count > 1 ? along * std::cos(shape.angle) / file.width : 0)),
                         float(t + (count > 1 ? along * std::sin(shape.angle) / file.height : 0)), radius, o);
                for (int c = 0; c < 4; ++c) expected[c] += double(one.v[c]) / count;
              }
              if (filter == 0) {  // nearest asks for a texel: its footprint is the circle
                const Color one = look(system, handle, s, t, unused, o);
                for (int c = 0; c < 4; ++c) expected[c] = double(one.v[c]);
              }
              several += count > 1;
              ++compared;
              for (int c = 0; c < 4; ++c) {
                const double error = std::fabs(double(got.v[c]) - expected[c]);
                worst = std::max(worst, error);
                // places differ by the rounding of coordinates: 1e-7 of a side of 512, some texels of which differ by a half
                ASSERT_LE(error, 2e-5) << file.name << " filter " << filter << " wrap " << wrap << " blends "
                                       << blends << " " << shape.name << " phase " << phase << " channel " << c
                                       << ": " << got.v[c] << " against " << expected[c];
              }
            }
          }
  }
  EXPECT_GT(compared, 7000u);
  EXPECT_GT(several, 4000u);
  std::printf("%u lookups, off by %.2g at most\n", compared, worst);
}

TEST_F(EllipseLookup, ShapesThatAreNoneFallBack) {
  for (const File& file : kFiles) {
    write(file.name, file.width, file.height, file.channels, file.type, file.prepared);
    TextureSystem system(diagnostics_);
    const int32_t handle = system.handle(path(file.name), {});
    for (const int filter : {0, 1, 3, 7})
      for (const int wrap : {0, 2, 3, 4}) {
        TextureOptions o;
        o.filter = filter, o.wrapS = o.wrapT = wrap;
        for (const float radius : {0.f, 0.02f, 3.f, kNan, kInfinity, -1.f}) {
          const Color round = look(system, handle, 0.3f, 0.4f, radius, o);
          for (const Axes& none : {Axes{{0, 0, 0, 0}}, Axes{{kNan, 0, 0, 0.1f}}, Axes{{0.1f, 0, 0, kNan}},
                                   Axes{{kNan, kNan, kNan, kNan}}, Axes{{-0.f, 0, -0.f, 0}}})
            EXPECT_EQ(look(system, handle, 0.3f, 0.4f, radius, o, &none), round)
                << file.name << " filter " << filter << " radius " << radius;
          for (const Axes& odd : {Axes{{kInfinity, 0, 0, 0.1f}}, Axes{{1e30f, 1e30f, -1e30f, 1e30f}},
                                  Axes{{1e-38f, 0, 0, 0}}, Axes{{0, 0, 0.25f, 0}}, Axes{{0, 0.25f, 0, 0}},
                                  Axes{{0.1f, 0.1f, 0.1f, 0.1f}}, Axes{{1e-20f, 1e-20f, -1e-20f, 1e-20f}},
                                  Axes{{-kInfinity, kInfinity, kInfinity, kInfinity}}, Axes{{3, 0, 0, 1e-7f}}})
            for (const float s : {0.3f, -255.9f, 256.f, 1e9f, kNan}) {
              const Color c = look(system, handle, s, 0.4f, radius, o, &odd);
              for (int k = 0; k < 4; ++k) {
                EXPECT_GE(c.v[k], wrap == 0 ? -1e-4f : 0.09f) << file.name << " filter " << filter << " s " << s;
                EXPECT_LE(c.v[k], 1.0001f) << file.name << " filter " << filter << " s " << s;
              }
            }
        }
      }
    // larger than the image in all directions: its mean, as the coarsest level has it; of a row 16 probes see less
    if (file.width > 8 * file.height) continue;
    TextureOptions o;
    const Axes vast{{1e20f, 0, 0, 1e20f}};
    const Color c = look(system, handle, 0.3f, 0.4f, 0, o, &vast), mean = look(system, handle, 0.3f, 0.4f, 4, o);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(c.v[k], mean.v[k], 2e-3f) << file.name;
  }
}

// Blur widens all axes; the atlas of one file is the file with its edges held.
TEST_F(EllipseLookup, BlurAndAtlas) {
  write("part.1001.tif", 128, 128, 3, OIIO::TypeUInt8, false);
  TextureSystem system(diagnostics_);
  const int32_t file = system.handle(path("part.1001.tif"), {}), atlas = system.handle(path("part.<UDIM>.tif"), {});
  ASSERT_GE(atlas, 0);
  TextureOptions clamped;
  clamped.wrapS = clamped.wrapT = 2;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(0, 1);
  for (int i = 0; i < 200; ++i) {
    const Axes a =
        shapeOf(30 * double(u(random)) + 1, 3 * double(u(random)), 7 * double(u(random)), u(random), 128, 128);
    const float s = u(random), t = u(random);
    // rows of an atlas count up from below: its t is 1 - (1 - t), which rounds
    const Color one = look(system, file, s, 1.f - (1.f - t), 0, clamped, &a),
                two = look(system, atlas, s, t, 0, {}, &a);
    EXPECT_EQ(one, two) << s << " " << t;
    TextureOptions blurred;
    blurred.blur = 0.05f;
    const Axes wider = shapeOf(10 + 0.05 * 128, 2 + 0.05 * 128, 0.3, 0, 128, 128),
               thin = shapeOf(10, 2, 0.3, 0, 128, 128);
    const Color expected = look(system, file, s, t, 0, {}, &wider), got = look(system, file, s, t, 0, blurred, &thin);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(got.v[c], expected.v[c], 1e-4f);
  }
}

TEST_F(EllipseLookup, APointsValueIsItsOwn) {
  write("a.tx", 300, 300, 3, OIIO::TypeUInt8, true);
  write("b.png", 65, 130, 4, OIIO::TypeUInt8, false);
  TextureSystem system(diagnostics_);
  const int32_t files[2] = {system.handle(path("a.tx"), {}), system.handle(path("b.png"), {})};
  constexpr uint32_t n = 700;
  std::mt19937 random(5);
  std::uniform_real_distribution<float> u(0, 1);
  std::vector<int32_t> handles(n);
  std::vector<float> s(n), t(n), r(n, 0.01f), axes[4], together[4];
  for (auto& a : axes) a.resize(n);
  for (auto& x : together) x.resize(n);
  for (uint32_t i = 0; i < n; ++i) {
    handles[i] = files[random() & 1];
    s[i] = 3 * u(random) - 1, t[i] = 3 * u(random) - 1;
    const Axes a = shapeOf(std::exp2(6 * double(u(random))), std::exp2(3 * double(u(random)) - 1),
                           7 * double(u(random)), u(random), 300, 300);
    for (int k = 0; k < 4; ++k) axes[k][i] = i % 5 == 0 ? 0.f : a.v[k];
  }
  for (const int filter : {1, 3, 7}) {
    TextureOptions o;
    o.filter = filter;
    float* const rgba[4] = {together[0].data(), together[1].data(), together[2].data(), together[3].data()};
    const float* const of[4] = {axes[0].data(), axes[1].data(), axes[2].data(), axes[3].data()};
    system.lookup(handles.data(), true, n, s.data(), t.data(), r.data(), o, rgba, of);
    for (uint32_t i = n; i-- > 0;) {
      const Axes a{{axes[0][i], axes[1][i], axes[2][i], axes[3][i]}};
      const Color alone = look(system, handles[i], s[i], t[i], r[i], o, &a);
      for (int c = 0; c < 4; ++c) ASSERT_EQ(together[c][i], alone.v[c]) << i << " filter " << filter;
    }
  }
}

// Grain averaged over the ellipse: what a pixel should show. A round lookup of the shorter axis sees a part of it.
TEST_F(EllipseLookup, IsNearerToTheMeanOverTheEllipse) {
  constexpr int kSide = 512;
  OIIO::ImageBuf image(OIIO::ImageSpec(kSide, kSide, 1, OIIO::TypeFloat));
  std::mt19937 random(11);
  std::uniform_real_distribution<float> u(0, 1);
  for (OIIO::ImageBuf::Iterator<float> it(image); !it.done(); ++it) it[0] = u(random);
  ASSERT_TRUE(image.write(path("grain.exr")));
  TextureSystem system(diagnostics_);
  const int32_t handle = system.handle(path("grain.exr"), {});
  const float* const grain = static_cast<const float*>(image.localpixels());
  for (const double stretch : {4., 8., 16.}) {
    constexpr double kShorter = 3;
    double ofEllipse = 0, ofCircle = 0;
    for (int i = 0; i < 400; ++i) {
      const double angle = 2 * M_PI * double(u(random)), c = std::cos(angle), s = std::sin(angle);
      const double x = kSide * double(u(random)), y = kSide * double(u(random));
      double sum = 0, weights = 0;
      const int reach = int(stretch * kShorter) + 1;
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const double px = std::floor(x) + dx + 0.5 - x, py = std::floor(y) + dy + 0.5 - y;
          const double a = (c * px + s * py) / (stretch * kShorter), b = (c * py - s * px) / kShorter;
          if (a * a + b * b > 1) continue;
          const int ix = (int(std::floor(x)) + dx + kSide) % kSide, iy = (int(std::floor(y)) + dy + kSide) % kSide;
          sum += double(grain[iy * kSide + ix]);
          weights += 1;
        }
      const double mean = sum / weights;
      const Axes axes = shapeOf(stretch * kShorter, kShorter, angle, 0, kSide, kSide);
      const float st[2] = {float(x / kSide), float(y / kSide)}, radius = float(kShorter / kSide);
      const double e = double(look(system, handle, st[0], st[1], radius, {}, &axes).v[0]) - mean,
                   r = double(look(system, handle, st[0], st[1], radius, {}).v[0]) - mean;
      ofEllipse += e * e;
      ofCircle += r * r;
    }
    std::printf("%g times as long: error %.3f of a round lookup's\n", stretch, std::sqrt(ofEllipse / ofCircle));
    EXPECT_LT(ofEllipse, 0.55 * ofCircle) << stretch;
  }
}

}  // namespace
}  // namespace kinora
