// How fast ASCII numbers are read, and that the reader holds no more than the numbers themselves. The figure is
// printed; the limit asserted is far below it, because tests share their machine.
#include <chrono>
#include <cstdio>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

TEST(Speed, AsciiNumbers) {
  constexpr int kPoints = 400000;
  std::string text = "WorldBegin\nPoints \"P\" [";
  uint32_t state = 1;
  for (int i = 0; i < 3 * kPoints; ++i) {
    state = state * 1664525u + 1013904223u;
    char buffer[32];
    text.append(buffer, size_t(std::snprintf(buffer, sizeof buffer, "%.7g ", (int(state >> 8) - 8388608) * 1e-4)));
    if (i % 12 == 11) text += '\n';
  }
  text += "]\nPointsPolygons [3] [0 1 2] \"P\" [0 0 0 1 0 0 0 1 0]\nWorldEnd\n";
  const double megabytes = double(text.size()) * 1e-6;
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    std::string copy = text;
    Diagnostics messages([](const std::string&, Severity) {});
    scene::Scene scene;
    RibReader reader(messages, {}, [&](scene::Scene&& s) { scene = std::move(s); });
    const auto start = std::chrono::steady_clock::now();
    reader.readString("t.rib", std::move(copy));
    best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    reader.finish();
    ASSERT_EQ(scene.primitives.size(), 2u);
    const auto* P = scene.primitives[0]->primvars.find("P");
    ASSERT_EQ(P->floats.size(), size_t(3 * kPoints));
    EXPECT_LE(P->floats.capacity(), P->floats.size() + P->floats.size() / 8);  // at most half a byte over each number
  }
  std::printf("ASCII numbers: %.0f MB/s (%.1f MB, best of 5)\n", megabytes / best, megabytes);
  EXPECT_GT(megabytes / best, 5);
}

TEST(Speed, SmallRequests) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 50000; ++i)
    text += "AttributeBegin\nAttribute \"identifier\" \"string name\" [\"s" + std::to_string(i) +
            "\"]\nTranslate 1 0 " + std::to_string(i) + "\nSphere 1 -1 1 360\nAttributeEnd\n";
  text += "WorldEnd\n";
  const double megabytes = double(text.size()) * 1e-6;
  const auto start = std::chrono::steady_clock::now();
  const Read r = readRib(text);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  ASSERT_EQ(r.world().primitives.size(), 50000u);
  std::printf("small requests: %.0f MB/s, %.2f million objects/s, %.0f bytes an object\n", megabytes / seconds,
              0.05 / seconds, double(r.world().bytes()) / 50000);
}

}  // namespace
}  // namespace kinora::rib
