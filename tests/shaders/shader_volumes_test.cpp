// Proves: texture3d() in frames gives what the voxels of an OpenVDB file say at points of world space, with every
// option and with derivatives, the same for any width and number of threads; files that are not there, hold something
// else or are damaged are one message and the missing colour, within their time. The fixture, volumes.vdb, holds 8 x
// 6 x 4 voxels, "density" = x + 10 y + 100 z and "Cd" = (x, y, z); a voxel is 0.5 wide, the first lies at (1, 2, 3).
// How it was made stands in src/volume/read_process_test.cpp.
#include <chrono>
#include <cmath>
#include <iterator>
#include <random>

#include "fixture.h"
#include "volume/read_process.h"

namespace kinora::tests {
namespace {

const std::string kFixture = KINORA_SOURCE_DIR "/tests/shaders/volumes.vdb";

class ShaderVolumes : public Shaders {
 protected:
  using Rgb = std::array<float, 3>;
  static volume::ReaderProgram reader(double seconds = 60) {
    return {{KINORA_PROGRAM, volume::kReadCommand}, seconds};
  }
  // The body of a shader whose `result` is shown; `at` makes a point of world space of a place in voxels.
  RenderRequest requestFor(const std::string& body) {
    write("asks.osl",
          "point at(float x, float y, float z) { return point(1 + x / 2, 2 + y / 2, 3 + z / 2); }\n"
          "shader asks(output color result = 0) { " +
              body + " }");
    RenderRequest r = requestOf("Pattern \"asks\" \"n\"\n" + std::string(kShow));
    r.settings.texturePath = {folder_, KINORA_SOURCE_DIR "/tests/shaders"};
    r.settings.volumeReader = reader();
    return r;
  }
  Rgb asked(const std::string& body) {
    SceneRender render(requestFor(body));
    for (const std::string& m : render.messages()) ADD_FAILURE() << m;
    return middleOf(render);
  }
};

TEST_F(ShaderVolumes, OptionsOfACall) {
  // three calls to a frame
  const auto three = [&](const std::string& a, const std::string& b, const std::string& c) {
    const auto call = [](const std::string& arguments) { return "texture3d(\"volumes.vdb\", " + arguments + ")"; };
    return asked("result = color(" + call(a) + ", " + call(b) + ", " + call(c) + ");");
  };
  EXPECT_EQ(three("at(3, 2, 1)", "at(3.25, 2.5, 1.75)", "at(-2, 2, 1)"), (Rgb{123, 203.25f, 0}));
  EXPECT_EQ(
      three("at(7.5, 2, 1)", "at(3.4, 2.4, 1.4), \"interp\", \"closest\"", "at(3, 2, 1), \"subimage\", \"density\""),
      (Rgb{63.5f, 123, 123}));
  EXPECT_EQ(three("at(3, 2, 1), \"subimage\", \"Cd\"", "at(3, 2, 1), \"subimage\", \"Cd\", \"firstchannel\", 1",
                  "at(3, 2, 1), \"subimage\", 0, \"firstchannel\", 2"),
            (Rgb{3, 2, 1}));
  EXPECT_EQ(three("at(9, 2, 1), \"wrap\", \"clamp\"", "at(9, 2, 1), \"wrap\", \"periodic\"",
                  "at(9, 2, 1), \"wrap\", \"mirror\""),
            (Rgb{127, 121, 126}));
  EXPECT_EQ(three("at(9, 7, 1), \"swrap\", \"clamp\", \"twrap\", \"periodic\"", "at(1, 2, 5), \"rwrap\", \"mirror\"",
                  "at(9, 2, 1), \"wrap\", \"black\""),
            (Rgb{117, 221, 0}));
  EXPECT_EQ(three("at(3, 2, 1), \"firstchannel\", 1, \"fill\", 5", "at(3, 2, 1), \"time\", 3, \"width\", 0",
                  "at(3, 2, 1), \"subimage\", 1"),
            (Rgb{5, 123, 123}));
  // a box of four voxels: a linear field keeps its value inside
  EXPECT_EQ(three("at(3, 2.5, 1.5), \"sblur\", 0.5", "at(3, 2, 1.5), vector(2, 0, 0), vector(0), vector(0, 0, .75)",
                  "at(0, 2, 1), vector(2, 0, 0), vector(0), vector(0)"),
            (Rgb{178, 173, 60.5f}));
  EXPECT_EQ(asked("result = texture3d(\"volumes.vdb\", at(3, 2, 1), \"subimage\", \"Cd\");"), (Rgb{3, 2, 1}));
  EXPECT_EQ(asked("result = texture3d(\"volumes.vdb\", point(2.5, -19.5, .5), \"subimage\", \"turned\");"),
            (Rgb{3, 3, 3}));
  EXPECT_EQ(asked("result = texture3d(\"volumes.vdb\", at(3, 2, 1));"), (Rgb{123, 123, 123}));
  EXPECT_EQ(asked("result = texture3d(\"volumes.vdb\", at(3, 2, 1), \"fill\", .5);"), (Rgb{123, .5f, .5f}));
  EXPECT_EQ(asked("result = texture3d(\"volumes.vdb\", at(3, 2, 1), \"subimage\", \"Cd\", \"firstchannel\", 1);"),
            (Rgb{2, 1, 0}));
  EXPECT_EQ(
      asked(
          "float a = 9, b = 9; string why = \"x\"; float x = texture3d(\"volumes.vdb\", at(3, 2, 1), \"subimage\", "
          "\"Cd\", \"alpha\", a, \"errormessage\", why); x = texture3d(\"volumes.vdb\", at(3, 2, 1), \"alpha\", b); "
          "result = color(a, b, why == \"\");"),
      (Rgb{2, 1, 1}));
  EXPECT_EQ(
      asked("int n = 0, size[3], e = 0; gettextureinfo(\"volumes.vdb\", \"exists\", e); "
            "gettextureinfo(\"volumes.vdb\", \"channels\", n); "
            "if (gettextureinfo(\"volumes.vdb\", \"resolution\", size)) result = color(size[0] + 10 * size[1] + "
            "100 * size[2], n, e + 2 * gettextureinfo(\"volumes.vdb\", \"averagecolor\", result));"),
      (Rgb{468, 1, 1}));
}

// Wherever the camera is; 2, 20 and 200 a unit of world space.
TEST_F(ShaderVolumes, PointsOfWorldSpaceAndDerivatives) {
  RenderRequest r = requestFor(
      "point q = P + vector(2, 3, 2.5); float d = texture3d(\"volumes.vdb\", q, \"width\", 0); "
      "vector g = vector(2, 20, 200); float there = dot(g, q - point(1, 2, 3)), x = dot(g, Dx(q)), y = dot(g, "
      "Dy(q)); "
      "result = color(d - there, max(abs(Dx(d) - x), abs(Dy(d) - y)), max(abs(x), abs(y)));");
  const std::string camera = "Projection \"orthographic\"";
  r.rib.replace(r.rib.find(camera), camera.size(), camera + "\nTranslate 0 0 .25");
  SceneRender render(r);
  ASSERT_TRUE(render.messages().empty()) << render.messages()[0];
  const Rgb seen = middleOf(render);
  EXPECT_NEAR(seen[0], 0, 1e-4);
  EXPECT_NEAR(seen[1], 0, 1e-3);
  EXPECT_GT(seen[2], 0.1f);  // a pixel is an eighth wide
}

TEST_F(ShaderVolumes, TheSameForEveryWidthAndThreads) {
  const std::string body =
      "string part = mod(floor(P[0] * 8), 2) == 0 ? \"Cd\" : \"density\"; string how = P[1] > 0 ? \"mirror\" : "
      "\"clamp\"; "
      "result = texture3d(\"volumes.vdb\", P * 3 + vector(2, 3, .7), \"subimage\", part, \"wrap\", how, \"blur\", "
      "P[0] * .2)"
      " + Dx(texture3d(\"volumes.vdb\", P + vector(2, 3, 2.7)));";
  std::vector<int64_t> first;
  for (const auto& [width, threads] : {std::pair{1u, 1}, {8u, 1}, {8u, 2}, {4u, 2}}) {
    RenderRequest r = requestFor(body);
    r.settings.width = width;
    r.settings.threads = threads;
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    const std::vector<int64_t> state = stateOf(render.film());
    if (first.empty()) first = state;
    EXPECT_EQ(state, first) << width << ' ' << threads;
  }
}

TEST_F(ShaderVolumes, WhatIsNotThereIsToldOnce) {
  write("words.vdb", "words");
  const auto refused = [&](const std::string& arguments, const std::string& code, const std::string& words) {
    SceneRender render(requestFor("string why = \"\"; float a = 0; result = texture3d(" + arguments +
                                  ", \"missingcolor\", color(1, 2, 3), \"missingalpha\", .5, \"alpha\", a, "
                                  "\"errormessage\", why); if (why != \"\") result[0] = a;"));
    EXPECT_EQ(render.messages().size(), 1u);
    EXPECT_EQ(told(render, code), 1u) << arguments;
    EXPECT_NE(render.messages().empty() ? std::string::npos : render.messages()[0].find(words), std::string::npos)
        << render.messages()[0];
    EXPECT_EQ(middleOf(render), (Rgb{.5f, 2, 3})) << arguments;
  };
  refused("\"lost.vdb\", P", "ASSET-VOLUME-MISSING", "'lost.vdb'");
  refused("\"words.vdb\", P", "ASSET-VOLUME-READ", "it holds no volumes (OpenVDB)");
  refused("\"volumes.vdb\", P, \"subimage\", \"fuel\"", "ASSET-VOLUME-READ",
          "it has no grid 'fuel'; it holds 'Cd', 'density', 'turned'");
  refused("\"volumes.vdb\", P, \"subimage\", 3", "ASSET-VOLUME-READ", "it has no grid number 3");
  refused("\"volumes.vdb\", P, \"subimage\", -1", "ASSET-VOLUME-READ", "it has no grid number -1");
  // black without a word about it
  SceneRender lost(requestFor("result = texture3d(\"lost.vdb\", P);"));
  EXPECT_EQ(middleOf(lost), (Rgb{0, 0, 0}));
}

std::string fixtureBytes() {
  std::ifstream file(kFixture, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST_F(ShaderVolumes, DamagedFilesEndNoFrame) {
  const std::string good = fixtureBytes();
  write("cut.vdb", good.substr(0, good.size() / 2));
  SceneRender render(requestFor("result = texture3d(\"cut.vdb\", P, \"missingcolor\", color(1, 2, 3));"));
  EXPECT_EQ(render.messages().size(), 1u);
  EXPECT_EQ(told(render, "ASSET-VOLUME-READ"), 1u);
  EXPECT_EQ(middleOf(render), (Rgb{1, 2, 3}));
}

// The program itself as the process that reads. Some of these end it by an assertion, some fill its memory.
TEST_F(ShaderVolumes, CutFilesAreRefused) {
  const std::string good = fixtureBytes(), path = folder_ + "/cut.vdb";
  for (size_t k = 0; k < 20; ++k) {
    write("cut.vdb", good.substr(0, good.size() * k / 20));
    std::string error;
    EXPECT_EQ(volume::readGrid(reader(10), path, "", error), nullptr) << k;
    EXPECT_NE(error, "") << k;
  }
}

TEST_F(ShaderVolumes, AlteredFilesGiveAGridOrAReason) {
  const std::string good = fixtureBytes(), path = folder_ + "/altered.vdb";
  std::mt19937 random(11);
  int refused = 0;
  for (int k = 0; k < 40; ++k) {
    std::string bytes = good;
    for (uint32_t n = 1u << random() % 3; n > 0; --n) {
      const uint32_t to[3] = {0, 255, uint32_t(random())};
      bytes[random() % bytes.size()] = char(to[random() % 3]);
    }
    write("altered.vdb", bytes);
    std::string error;
    const auto start = std::chrono::steady_clock::now();
    const auto grid = volume::readGrid(reader(10), path, "", error);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_LT(seconds, 60) << k;
    EXPECT_NE(grid != nullptr, !error.empty()) << k << error;
    refused += !grid;
    float v[3];
    const double middle[3] = {4, 3, 2};
    if (grid) grid->lookUp(middle, {}, v);
  }
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace kinora::tests
