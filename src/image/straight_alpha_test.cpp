// Proves: straight colours are those of what covers, whatever light is seen where nothing does; without such light they
// are the division by alpha and nothing else. Misses: light that changes within an object's width (it is carried on
// smoothly).
#include "image/straight_alpha.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kinora::image {
namespace {

constexpr int kWidth = 61, kHeight = 43;
const std::vector<size_t> kColors{0, 1, 2};

// A soft disk: alpha falls over `soft` pixels.
float coverAt(int x, int y, float soft) {
  const float d = std::hypot(float(x) - 30, float(y) - 20);
  return std::min(1.f, std::max(0.f, (14 - d) / soft));
}

Image pictureOf(float soft, const std::array<float, 3>& object, const std::array<float, 3>& sky, float skySlope = 0) {
  Image i({0, 0, kWidth, kHeight}, {{"R"}, {"G"}, {"B"}, {"A"}});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float a = coverAt(x, y, soft);
      for (size_t c = 0; c < 3; ++c) i.at(x, y)[c] = a * object[c] + (1 - a) * (sky[c] + skySlope * float(y));
      i.at(x, y)[3] = a;
    }
  return i;
}

TEST(StraightAlpha, IsTheColourOfWhatCovers) {
  const std::array<float, 3> object{0.1f, 0.4f, 0.9f}, sky{0.5f, 0.6f, 0.8f};
  for (const float soft : {1.5f, 5.f, 12.f}) {  // an edge, and one that is out of focus
    Image i = pictureOf(soft, object, sky);
    makeStraight(i, kColors, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const float a = coverAt(x, y, soft);
        for (size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(i.at(x, y)[c], a > 0 ? object[c] : sky[c], a > 0 ? 1e-6 / a + 1e-6 : 0)
              << soft << " " << x << " " << y;
        EXPECT_EQ(i.at(x, y)[3], a);
      }
  }
}

// A sky that changes is carried on from around: the colour of what covers is missed by a little of the change.
TEST(StraightAlpha, SkiesMayChange) {
  Image i = pictureOf(3, {0.2f, 0.2f, 0.2f}, {0.3f, 0.3f, 0.3f}, 0.01f);
  makeStraight(i, kColors, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (const float a = coverAt(x, y, 3); a > 0.05f) {
        EXPECT_NEAR(i.at(x, y)[0], 0.2, 0.04 * (1 - a) / a + 1e-6) << x << " " << y << " " << a;
        EXPECT_LT(i.at(x, y)[0], 0.75) << "divided whole it would be " << (0.2 + (1 - a) / a * 0.5);
      }
}

TEST(StraightAlpha, WithoutLightBehindItIsTheDivision) {
  Image i = pictureOf(5, {0.1f, 0.4f, 2}, {0, 0, 0}), divided = i;
  i.at(3, 3)[0] = divided.at(3, 3)[0] = std::numeric_limits<float>::quiet_NaN();  // a pixel that is none
  makeStraight(i, kColors, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float a = divided.at(x, y)[3];
      for (int c = 0; c < 3; ++c) {
        if (x == 3 && y == 3) continue;
        EXPECT_EQ(i.at(x, y)[c], a > 0 && a < 1 ? divided.at(x, y)[c] / a : divided.at(x, y)[c]);
      }
    }
}

TEST(StraightAlpha, OddPictures) {
  // no pixel is empty: nothing is known of what is behind
  Image full({0, 0, 2, 1}, {{"R"}, {"G"}, {"B"}, {"A"}});
  const float pixels[2][4] = {{0.25f, 0.1f, -0.05f, 0.5f}, {0.5f, 0.5f, 0.5f, 1.25f}};
  for (int x = 0; x < 2; ++x) std::copy_n(pixels[x], 4, full.at(x, 0));
  makeStraight(full, kColors, 3);
  EXPECT_FLOAT_EQ(full.at(0, 0)[0], 0.5f);
  EXPECT_FLOAT_EQ(full.at(0, 0)[2], -0.1f);
  EXPECT_EQ(full.at(1, 0)[0], 0.5f) << "covered more than wholly";
  // more light behind than the pixel has: black, not below
  Image odd({0, 0, 2, 1}, {{"R"}, {"G"}, {"B"}, {"A"}});
  const float more[2][4] = {{0.1f, 0.1f, 0.1f, 0.5f}, {4, 4, 4, 0}};
  for (int x = 0; x < 2; ++x) std::copy_n(more[x], 4, odd.at(x, 0));
  makeStraight(odd, kColors, 3);
  EXPECT_EQ(odd.at(0, 0)[0], 0);
  EXPECT_EQ(odd.at(1, 0)[0], 4);
  Image none;
  makeStraight(none, kColors, 3);
  makeStraight(odd, {}, 3);
}

}  // namespace
}  // namespace kinora::image
